"""
How often is the paper's criterion unsafe?
==========================================

The criteria broadcast over arrays: here 200 000 random dyads in one call. For each the share of the
stiffness that Eq. 5 allows and that is not safe.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

random = np.random.default_rng(1)
mass_ratio, damping_ratio = 10 ** random.uniform(-1, 1, (2, 200_000))
exact = ts.critical_stiffness(1.0, 1.0, mass_ratio, damping_ratio)
paper = ts.critical_stiffness(1.0, 1.0, mass_ratio, damping_ratio, method="paper")
too_much = paper / exact

edges = np.linspace(-1, 1, 41)
counts, *_ = np.histogram2d(np.log10(mass_ratio), np.log10(damping_ratio), [edges, edges])
unsafe, *_ = np.histogram2d(
    np.log10(mass_ratio), np.log10(damping_ratio), [edges, edges], weights=too_much > 1 + 1e-9
)
figure, ax = plt.subplots(layout="constrained")
shown = ax.pcolormesh(10**edges, 10**edges, 100 * (unsafe / counts).T, cmap="cividis")
ax.set(xscale="log", yscale="log", xlabel="Ratio of the masses", ylabel="Ratio of the dampings")
figure.colorbar(shown, label="Dyads for which Eq. 5 is unsafe, %")

# %%

print(f"unsafe for {100 * np.mean(too_much > 1 + 1e-9):.0f} %, at worst by a factor of {too_much.max():.1f}")
assert np.all(too_much > 1 - 1e-9)  # it never errs to the safe side
same = ts.critical_stiffness(1.0, 2.0, 1.0, 2.0, method="paper") / ts.critical_stiffness(1.0, 2.0, 1.0, 2.0)
assert abs(same - 1) < 1e-9  # identical robots: it is exact
