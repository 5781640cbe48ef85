"""
Which motion becomes unstable?
==============================

The characteristic roots of one axis while the delay grows. A pair of roots crosses the imaginary axis at
the maximum delay; its imaginary part is the frequency at which the dyad would begin to swing.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

dyad, stiffness = ts.hman(), 71.23197587212911
x = dyad["x"]
limit = x.maximum_delay(stiffness)

figure, ax = plt.subplots(layout="constrained")
delays = np.linspace(0.02, 0.4, 120)
for delay in delays:
    roots = ts.characteristic_roots(dyad, stiffness, delay, count=8, axis="x")
    shown = ax.scatter(
        roots.real, roots.imag, c=np.full(len(roots), 1000 * delay), s=6, cmap="cividis", vmin=20, vmax=400
    )
ax.axvline(0.0, color="black", linewidth=0.8)
[crossing] = [each for each in x.crossings(stiffness) if abs(each.delay - limit) < 1e-9]
ax.plot([0, 0], [crossing.frequency, -crossing.frequency], "o", markerfacecolor="none", markersize=10)
ax.set(xlabel="Real part, 1/s", ylabel="Imaginary part, rad/s", xlim=(-12, 2), ylim=(-45, 45))
ax.set_title(f"Crossing at {1000 * limit:.1f} ms with {crossing.frequency:.2f} rad/s")
figure.colorbar(shown, label="One-way delay, ms")

# %%
# A certificate says that no root was missed: the argument principle counts as many as were found. Just
# below the maximum delay all of them are in the left half-plane, just above it a pair is not.

for factor, is_stable in ((0.999, True), (1.001, False)):
    found = ts.certified_roots(dyad, stiffness, factor * limit, axis="x")
    assert found.certificate == "complete"
    assert (found.roots[0].real < 0) == is_stable
