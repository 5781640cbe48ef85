"""
How stiff may a spring be at which delay?
=========================================

The map of one dyad: every stiffness with every one-way delay. The region is exact; it is not simulated.
"""

import telespring as ts

dyad = ts.hman()  # the paper's two robots
ax = ts.plot.stability_map(dyad, mark=(71.2, 0.1))

# %%
# Below the critical stiffness no constant delay destabilises the dyad; twice of it is stable up to a delay.
limit = ts.maximum_delay(dyad, 2 * ts.critical_stiffness(dyad))
print(f"2 k_m is stable below {1000 * limit:.1f} ms")
assert 0.1671 < limit < 0.1672
