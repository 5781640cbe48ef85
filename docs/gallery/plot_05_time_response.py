"""
Stable and unstable, in time
============================

Two people push the robots towards each other with 1 N. Below the maximum delay of 167.2 ms the swing dies
out; above it the swing grows, as fast as the rightmost root says.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

dyad, stiffness = ts.hman(), 71.23197587212911
push = [[1.0, 0.0], [-1.0, 0.0]]  # N, [robot][axis]
motions = {delay: ts.simulate(dyad, stiffness, delay, push, 10.0) for delay in (0.12, 0.167, 0.2)}

figure, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 7), layout="constrained")
for ax, (delay, motion) in zip(axes, motions.items(), strict=True):
    x = 1000 * motion.position.sel(axis="x")
    ax.plot(motion.time, x.sel(robot=1), label="robot 1")
    ax.plot(motion.time, x.sel(robot=2), "--", label="robot 2")
    growth = ts.spectral_abscissa(dyad, stiffness, delay, axis="x")
    ax.set(
        ylabel="Position, mm",
        title=f"{1000 * delay:.0f} ms: rightmost root at {growth:+.3f} 1/s".replace("-", "−"),
    )
axes[-1].set_xlabel("Time, s")
axes[0].legend()

# %%
# The envelope of the distance between the robots grows at the rate of the root.

difference = motions[0.2].position.sel(axis="x", robot=1) - motions[0.2].position.sel(axis="x", robot=2)
swing = difference - difference.mean()
peaks = [float(abs(swing.sel(time=slice(start, start + 2.0))).max()) for start in (4.0, 8.0)]
rate = np.log(peaks[1] / peaks[0]) / 4.0
print(f"measured {rate:+.2f} 1/s, root {ts.spectral_abscissa(dyad, stiffness, 0.2, axis='x'):+.2f} 1/s")
assert abs(rate - ts.spectral_abscissa(dyad, stiffness, 0.2, axis="x")) < 0.15
assert float(abs(motions[0.12].velocity).sel(time=10.0, axis="x").max()) < 1e-3
