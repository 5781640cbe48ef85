"""
What does jitter cost?
======================

Each of the five verdicts makes its own assumption about the network, and allows its own stiffness. Jitter
makes the delay vary. The verdict for a constant delay then holds only behind a playout buffer, which waits
for the latest packet.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

dyad = ts.hman()
jitters = np.linspace(0.0, 0.05, 11)  # s
bounds: dict[str, list[float]] = {}
for jitter in jitters:
    judged = ts.verdicts(dyad, 71.2, ts.Network(0.1, jitter=jitter))
    for verdict in judged.tiers:
        bounds.setdefault(verdict.tier, []).append(verdict.stiffness_bound)

figure, ax = plt.subplots(layout="constrained")
styles = {
    "constant delay": ":",
    "age in a range": "-",
    "bounded varying delay": "--",
    "any constant delay": "-.",
    "any network": (0, (6, 2)),
}  # from the top down
for tier, style in styles.items():
    name = "constant delay, behind a buffer" if tier == "constant delay" else tier
    ax.plot(1000 * jitters, bounds[tier], linestyle=style, label=name)
ax.set(
    xlabel="Jitter, ms", ylabel="Stiffness allowed, N/m", title="The H-MANs, 100 ms one way", ylim=(0, None)
)
figure.legend(loc="outside lower center", ncols=2)

# %%
# "Age in a range" lies between the verdict for one constant delay and the one for any variation. It
# needs no buffer.

assert set(styles) == set(bounds)
assert np.all(np.diff(bounds["age in a range"]) < 0)
for between, below, above in zip(
    bounds["age in a range"], bounds["bounded varying delay"], bounds["constant delay"], strict=True
):
    assert below < between <= above * (1 + 1e-6)
assert bounds["any network"][0] == bounds["any network"][-1]  # it does not ask for the delay
