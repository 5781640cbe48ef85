"""
Mass and damping from a log
===========================

The log has positions and forces at the handle of a simulated robot: 1.2 and 1.4 kg, 6 and 8 N·s/m.
Identification finds them with intervals, and says what the force had beside them.
"""

from pathlib import Path

import matplotlib.pyplot as plt

from telespring.identification import identify, read_log

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
root = next(folder for folder in (here, *here.parents) if (folder / "examples" / "log.csv").exists())
log = read_log(root / "examples" / "log.csv")
robot = identify(log.time, log.position, log.force)

true = {"mass": (1.2, 1.4), "damping": (6.0, 8.0)}
figure, axes = plt.subplots(1, 2, figsize=(8, 3.6), layout="constrained")
for ax, name, unit in zip(axes, ("mass", "damping"), ("kg", "N·s/m"), strict=True):
    for place, (axis, value) in enumerate(zip(robot.axes, true[name], strict=True)):
        estimate = getattr(axis, name)
        low, high = estimate.interval
        ax.errorbar(
            place, estimate.value, [[estimate.value - low], [high - estimate.value]], fmt="o", capsize=6
        )
        ax.plot(place, value, "x", color="black", markersize=10)
    ax.set(xticks=[0, 1], xticklabels=["x", "y"], ylabel=f"{name.capitalize()}, {unit}", xlim=(-0.5, 1.5))
figure.suptitle("Estimates with 95 % intervals, and the truth (×)")

# %%

for axis, mass, damping in zip(robot.axes, *true.values(), strict=True):
    assert abs(axis.mass.value - mass) < 0.02 * mass
    assert abs(axis.damping.value - damping) < 0.02 * damping
