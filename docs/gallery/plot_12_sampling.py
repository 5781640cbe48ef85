"""
What a slow controller costs
============================

A controller holds its force for a sample period. At 1 kHz that costs little. At 60 Hz it costs a third of
the stiffness that a continuous controller could use, at 30 Hz, the rate of many arms for learning, half.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

dyad = ts.hman()
rates = np.array([1000.0, 500.0, 250.0, 125.0, 60.0, 30.0])
usable = [
    ts.decide(dyad, delay=ts.Network(0.05, sample_period=1 / rate)).limits.delays[0].usable_stiffness
    for rate in rates
]

continuous = ts.decide(dyad, delay=ts.Network(0.05)).limits.delays[0].usable_stiffness

figure, ax = plt.subplots(layout="constrained")
ax.semilogx(rates, usable, "o-", label="sampled")
ax.axhline(continuous, color="black", linestyle="--", label="continuous")
ax.set(
    xlabel="Rate of both controllers, Hz",
    ylabel="Usable stiffness, N/m",
    title="The H-MANs, 50 ms one way",
    ylim=(0, None),
)
ax.set_xticks(rates, [f"{rate:g}" for rate in rates])
ax.minorticks_off()
ax.legend(loc="lower right")

# %%

for rate, stiffness in zip(rates, usable, strict=True):
    print(f"{rate:5g} Hz: {stiffness:5.1f} N/m, {stiffness / continuous:.0%} of the continuous one")
assert np.all(np.diff(usable) < 0)
share = dict(zip(rates, np.divide(usable, continuous), strict=True))
assert share[1000.0] > 0.95
assert abs(share[60.0] - 2 / 3) < 0.05
assert abs(share[30.0] - 1 / 2) < 0.05
