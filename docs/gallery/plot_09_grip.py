"""
Does a firm grip help?
======================

A hand is a spring to the ground, and that helps: if it had no mass, no constant delay could destabilise the
dyad from some grip on. But a hand has a mass, and that takes most of the gain away again. With a light grip
the dyad even bears less delay than with free handles.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

stiffness = 142.0  # N/m, of the virtual spring
grips = np.linspace(0.0, 300.0, 601)  # N/m, both hands alike
axis = ts.hman()["x"]
(m1, m2), (b1, b2) = axis.masses, axis.dampings

figure, ax = plt.subplots(layout="constrained")
limits = {}
for hand, style in ((0.0, "-"), (0.5, "--"), (1.0, "-.")):
    limits[hand] = ts.maximum_delay(m1 + hand, b1, m2 + hand, b2, stiffness, kh1=grips, kh2=grips)
    ax.plot(grips, 1000 * limits[hand], style, label=f"each hand {hand:g} kg")
ax.set(xlabel="Stiffness of both hands, N/m", ylabel="Maximum one-way delay, ms", ylim=(50, 100))
ax.set_title(f"The H-MANs' x axis, {stiffness:g} N/m")
ax.legend()

# %%
# `telespring decide --grip 50:300` asks for all grips of a range at once, and holds for the worst of
# them.

for hand, limit in limits.items():
    print(f"hand of {hand:g} kg: slack {1000 * limit[0]:.1f} ms, at 300 N/m {1000 * limit[-1]:.1f} ms")
assert np.isinf(limits[0.0][-1])
assert np.isfinite(limits[1.0]).all()
assert limits[1.0][0] < limits[0.5][0] < limits[0.0][0]  # the last one is that of free handles
assert all(np.all(np.diff(limit[np.isfinite(limit)]) > 0) for limit in limits.values())
