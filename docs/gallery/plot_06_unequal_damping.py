"""
Where the paper's critical stiffness is unsafe
==============================================

Eq. 5 of Du et al. is meant to give the stiffness below which no constant delay destabilises a dyad. It is
a necessary condition, not a sufficient one: for robots of equal mass it fails as soon as one damping
exceeds 1 + √2 times the other.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

ratios = np.linspace(1.0, 12.0, 400)  # b2/b1
exact = ts.critical_stiffness(1.0, 1.0, 1.0, ratios)
paper = ts.critical_stiffness(1.0, 1.0, 1.0, ratios, method="paper")

figure, ax = plt.subplots(layout="constrained")
ax.plot(ratios, paper, "--", label="Eq. 5")
ax.plot(ratios, exact, label="exact")
ax.fill_between(ratios, exact, paper, alpha=0.2, label="called safe by Eq. 5, but is not")
ax.axvline(1 + np.sqrt(2), color="gray", linestyle=":", label="1 + √2")
ax.set(
    xlabel="Ratio of the dampings b₂/b₁",
    ylabel="Critical stiffness, N/m",
    title="Both masses 1 kg, b₁ = 1 N·s/m",
)
ax.legend()

# %%
# At a ratio of 10 the paper says 25.25 N/m, and 9.46 N/m is true: below the paper's value a delay of
# 172 ms destabilises the dyad.

first_wrong = ratios[np.argmax(paper > exact * (1 + 1e-9))]
lost = ts.maximum_delay(1.0, 1.0, 1.0, 10.0, 0.99 * 25.25)
print(f"Eq. 5 is unsafe above a ratio of {first_wrong:.2f}; at 24.9975 N/m lost at {1000 * lost:.1f} ms")
assert abs(first_wrong - (1 + np.sqrt(2))) < 0.03
assert ts.unstable_root_count(1.0, 1.0, 1.0, 10.0, 24.9975, 0.18) == 2
