"""
What a predictor does to stability
==================================

A side can use where its partner will be instead of where it was. On a bare spring a straight line helps
at short delays and harms at long ones.
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
