"""
Stability can return at a longer delay
======================================

The stable delays of a dyad are a union of intervals. This one is stable below 851 ms, unstable up to
1774 ms, and stable again up to 2113 ms.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

axis = ts.DyadAxis(0.97670822, 2.15372614, 0.30379312, 4.59594729)
stiffness = 9.174736188
intervals = axis.stable_delays(stiffness, 3.0)

delays = np.linspace(0.0, 3.0, 601)
stiffnesses = np.linspace(8.0, 12.0, 300)
stable = axis.stability_map(stiffnesses, delays)

figure, ax = plt.subplots(layout="constrained")
ax.contourf(delays, stiffnesses, stable, levels=[0.5, 1.5], colors=["tab:blue"], alpha=0.3)
ax.axhline(stiffness, color="black", linewidth=0.8)
for start, end in intervals:
    label = f"stable from {start:.3f} to {end:.3f} s"
    ax.plot([start, end], [stiffness, stiffness], linewidth=5, solid_capstyle="butt", label=label)
ax.set(xlabel="One-way delay, s", ylabel="Stiffness, N/m", title=f"Shaded: stable. Line: {stiffness:.2f} N/m")
ax.legend()

# %%

print([(round(start, 3), round(end, 3)) for start, end in intervals])
assert len(intervals) == 2
for delay, count in ((0.5, 0), (1.2, 2), (1.9, 0), (2.5, 2)):
    assert axis.unstable_root_count(stiffness, delay) == count
