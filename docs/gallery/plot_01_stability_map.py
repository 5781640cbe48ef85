"""
How stiff may a spring be at which delay?
=========================================

The map of one dyad: every stiffness with every one-way delay. The boundary is computed, not simulated.
The star is one condition.
"""

import telespring as ts

dyad = ts.hman()  # the robots of Du et al., Table III
ax = ts.plot.stability_map(dyad, mark=(71.2, 0.1))

# %%
# Below the critical stiffness no constant delay destabilises the dyad. Twice that stiffness is stable
# below the maximum delay.

critical = ts.critical_stiffness(dyad)
limit = ts.maximum_delay(dyad, 2 * critical)
print(f"any constant delay: {critical:.2f} N/m; twice that: below {1000 * limit:.1f} ms")

assert 35.61 < critical < 35.62
assert 0.1671 < limit < 0.1672  # the paper prints 167 ms
