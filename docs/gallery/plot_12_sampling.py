"""
What a slow controller costs
============================

A controller holds its force for a sample period. At 1 kHz that costs next to nothing; at 30 to 60 Hz,
the rate of many arms for learning, it costs most of the stiffness.
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

figure, ax = plt.subplots(layout="constrained")
ax.semilogx(rates, usable, "o-")
ax.set(
    xlabel="Rate of both controllers, Hz",
    ylabel="Usable stiffness, N/m",
    title="The H-MANs, 50 ms one way",
    ylim=(0, None),
)
ax.set_xticks(rates, [f"{rate:g}" for rate in rates])
ax.minorticks_off()

# %%

for rate, stiffness in zip(rates, usable, strict=True):
    print(f"{rate:5g} Hz: {stiffness:5.1f} N/m")
assert np.all(np.diff(usable) < 0)
assert usable[-1] < 0.8 * usable[0]
