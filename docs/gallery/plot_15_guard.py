"""
The guard in a rehearsal
========================

Two simulated people follow a target, coupled by 142 N/m over 84 ms. The bare spring makes them swing more
and more. Behind the guard, which gives out no more energy than it has, the same spring leaves the people in
control.
"""

import tempfile

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

protocol = {
    "unconnected": False,
    "stiffness": [142.0],
    "delay": [0.084],
    "trials": 1,
    "duration": 30.0,
    "discard": 2.0,
}
errors = {}
figure, ax = plt.subplots(layout="constrained")
for strategy, style in (("spring", "--"), ("guard", "-")):
    study = ts.Study.paper().replace(protocol=protocol, session={"strategy": strategy})
    with tempfile.TemporaryDirectory() as folder:
        trials = ts.rehearse(study, folder).load()
    [trial] = trials.isel(condition=0).transpose("trial", ...).position
    error = np.hypot(*(trial - trials.target).transpose("axis", ...).sel(robot=1))
    errors[strategy] = float(error.max())
    ax.semilogy(trials.time, 1000 * error, style, label=strategy)
ax.set(xlabel="Time, s", ylabel="Distance of robot 1 from the target, mm", title="142 N/m, 84 ms one way")
ax.legend()

# %%

print({strategy: f"{1000 * error:.0f} mm at most" for strategy, error in errors.items()})
assert errors["guard"] < 0.2 * errors["spring"]
