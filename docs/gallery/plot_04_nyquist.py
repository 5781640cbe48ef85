"""
Why does the Nyquist locus pass through −1?
===========================================

Two free handles can be moved together without stretching the spring. So s = 0 is always a root, and the
locus always passes through −1 at ω = 0. Stability depends on the other roots: the encirclements are counted
without this one.
"""

import matplotlib.pyplot as plt

import telespring as ts

dyad, stiffness = ts.hman(), 71.23197587212911
figure, axes = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
for ax, delay in zip(axes, (0.1, 0.25), strict=True):
    ts.plot.nyquist(dyad, stiffness, delay, axis="x", ax=ax)
    ax.set_title(f"{1000 * delay:.0f} ms one way", loc="left")  # the verdict stands on the right

# %%

counts = [ts.nyquist(dyad, stiffness, delay, axis="x").unstable_roots for delay in (0.1, 0.25)]
print("roots in the right half-plane:", counts)
assert counts == [0, 2]
