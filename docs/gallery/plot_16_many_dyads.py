"""
How often is the paper's criterion unsafe?
==========================================

Four million dyads in a second or two. Each is drawn, with what two people add to the handles, judged by
Eq. 5 and exactly, counted and forgotten. Only the counts of each cell of the map are kept, so that a billion
dyads need no more memory, only minutes.
"""

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

ratios = {"mass_ratio": (0.1, 10.0), "damping_ratio": (0.1, 10.0)}
people = {"operator_mass": 1.0, "operator_damping": 5.0}  # at most, kg and N·s/m
survey = ts.survey_dyads(4_000_000, **ratios, **people)
share = survey.unsafe / survey.dyads
worst = ts.unsafe_quantile(survey, 0.95)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained", sharey=True)
maps = (
    (left, 100 * share, "Dyads for which Eq. 5 is unsafe, %", {"vmin": 0, "vmax": 100}),
    (right, worst, "Eq. 5 / exact stiffness, 95th percentile", {"vmin": 1}),
)
for ax, values, title, scale in maps:
    drawn = ax.pcolormesh(survey.damping_ratio, survey.mass_ratio, values, cmap="cividis", **scale)
    ax.set(xscale="log", yscale="log", title=title, xlabel="Damping of robot 2 / robot 1")
    ax.set_xticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
    figure.colorbar(drawn, ax=ax)
left.set_yticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
left.set_ylabel("Mass of robot 2 / robot 1")

# %%
# Eq. 5 never gives too small a stiffness. Where robots and people are equal it is exact; for equal robots in
# the hands of unequal people it is not always safe. A ratio of 2 says that Eq. 5 allows twice the stiffness
# that is safe.

dyads, unsafe = int(survey.dyads.sum()), int(survey.unsafe.sum())
largest = float(survey.largest.max())
print(f"{dyads:,} dyads: unsafe for {unsafe / dyads:.1%}, with a ratio of {largest:.1f} at worst")
for name, damping_ratio in (("equal robots", 1.0), ("equal masses, ten times the damping", 10.0)):
    cell = {"mass_ratio": 1.0, "damping_ratio": damping_ratio, "method": "nearest"}
    quantiles = [float(ts.unsafe_quantile(survey, each).sel(**cell)) for each in (0.5, 0.95)]
    print(f"{name}: unsafe for {float(share.sel(**cell)):.0%}, median ratio {quantiles[0]:.2f}, ", end="")
    print(f"95th percentile {quantiles[1]:.2f}")
    assert 1.0 <= quantiles[0] <= quantiles[1]

assert dyads >= 4_000_000
assert 0.3 < unsafe / dyads < 0.5
assert float(share.sel(mass_ratio=1.0, damping_ratio=1.0, method="nearest")) < 0.1
assert float(share.sel(mass_ratio=1.0, damping_ratio=10.0, method="nearest")) > 0.9

# %%
# The criteria broadcast over arrays, too. A hundred thousand dyads of the same population, drawn by NumPy and
# judged that way, have the same share.

random = np.random.default_rng(1)
size = 100_000
m1, b1 = (np.exp(random.uniform(*np.log(ends), size)) for ends in ((0.5, 5.0), (1.0, 20.0)))
m2, b2 = (each * 10 ** random.uniform(-1, 1, size) for each in (m1, b1))
masses = [each + random.uniform(0, people["operator_mass"], size) for each in (m1, m2)]
dampings = [each + random.uniform(0, people["operator_damping"], size) for each in (b1, b2)]
robots = (masses[0], dampings[0], masses[1], dampings[1])
exact, paper = ts.critical_stiffness(*robots), ts.critical_stiffness(*robots, method="paper")
assert np.all(paper > exact * (1 - 1e-9))
assert abs(np.mean(paper > exact * (1 + 1e-9)) - unsafe / dyads) < 0.01
