"""
What a predictor does to stability
==================================

Each side knows where its partner was. It can also predict where the partner is now. With a bare spring a
straight-line prediction allows a stiffer spring at short delays, and only a softer one at long delays.
"""

import telespring as ts

dyad = ts.hman()
kalman = {"kind": "kalman", "model": "constant-acceleration", "process": 100.0, "position": 1e-4}
ax = ts.plot.prediction_map(dyad, ["hold", "linear", kalman], points=60)

# %%

for delay in (0.02, 0.167):
    held, linear = (ts.maximum_stiffness(dyad, delay, predictor=each) for each in ("hold", "linear"))
    print(f"{1000 * delay:.0f} ms: held {held:.0f} N/m, linear {linear:.0f} N/m")
assert ts.maximum_stiffness(dyad, 0.02, predictor="linear") > ts.maximum_stiffness(dyad, 0.02)
assert ts.maximum_delay(dyad, 71.0, predictor="linear") < ts.maximum_delay(dyad, 71.0)
