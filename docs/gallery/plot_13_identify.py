"""
Mass and damping from a log
===========================

The log has positions and forces at the handle of a simulated robot: 1.2 and 1.4 kg, 6 and 8 N·s/m.
Identification estimates them, each with an interval that shows how far the estimate can be trusted.
"""

from pathlib import Path

import matplotlib.pyplot as plt

from telespring.identification import identify, read_log

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
root = next(folder for folder in (here, *here.parents) if (folder / "examples" / "log.csv").exists())
log = read_log(root / "examples" / "log.csv")
robot = identify(log.time, log.position, log.force)

true = {"mass": (1.2, 1.4), "damping": (6.0, 8.0)}
units = {"mass": "kg", "damping": "N·s/m"}
figure, ax = plt.subplots(layout="constrained")
ax.axhline(0.0, color="black", linestyle="--", label="truth")
labels = []
for name, values in true.items():
    for axis, value in zip(robot.axes, values, strict=True):
        estimate = getattr(axis, name)
        error, low, high = (100 * (each / value - 1) for each in (estimate.value, *estimate.interval))
        label = None if labels else "estimate with its 95 % interval"
        ax.errorbar(len(labels), error, [[error - low], [high - error]], fmt="oC0", capsize=6, label=label)
        labels.append(f"{name} on {axis.axis}\n{estimate.value:.3f} {units[name]}")
ax.set_xticks(range(len(labels)), labels)
ax.set_ylabel("Deviation from the truth, %")
ax.legend()

# %%

for axis, mass, damping in zip(robot.axes, *true.values(), strict=True):
    assert axis.mass.interval[0] < mass < axis.mass.interval[1]
    assert axis.damping.interval[0] < damping < axis.damping.interval[1]
    assert abs(axis.mass.value - mass) < 0.01 * mass
    assert abs(axis.damping.value - damping) < 0.01 * damping
