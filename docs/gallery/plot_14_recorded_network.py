"""
What a recorded network allows
==============================

Twenty seconds of round trips show how long each side should wait before it uses a sample, and how stiff the
spring between the paper's two H-MANs may then be. The best wait is the shortest at which nearly all samples
are in time and the limit is nearly the largest.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

here = Path(__file__).parent if "__file__" in globals() else Path.cwd()
root = next(folder for folder in (here, *here.parents) if (folder / "examples" / "round-trips.csv").exists())
trace = ts.read_trace(root / "examples" / "round-trips.csv", round_trip=True)
found = ts.assess_trace(trace)
best = found.recommended

figure, (above, below) = plt.subplots(2, 1, figsize=(7, 6), layout="constrained")
above.plot(trace.time, 1000 * trace.delay, ".", markersize=2)
above.axhline(1000 * best.delay, color="black", label=f"play-out {1000 * best.delay:.0f} ms")
above.set(xlabel="Time, s", ylabel="Delay one way, ms")
above.legend()
waits = [1000 * choice.delay for choice in found.playouts]
limits = [choice.stiffness_limit for choice in found.playouts]
below.plot(waits, limits, "o-")
below.plot(1000 * best.delay, best.stiffness_limit, "*", color="black", markersize=14, label="recommended")
below.set(xlabel="Play-out delay, ms", ylabel="Stiffness limit, N/m", ylim=(0, 1.1 * max(limits)))
below.legend(loc="lower right")

# %%

print(f"wait {1000 * best.delay:.0f} ms, use up to {found.stiffness:.1f} N/m: 5 % below '{best.tier}'")
assert np.isnan(trace.delay).sum() == 5  # lost packets
assert best.stiffness_limit >= 0.95 * max(choice.stiffness_limit for choice in found.playouts)
