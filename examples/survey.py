"""Where the paper's critical stiffness is unsafe: a map over mass and damping ratios, and by how much.

    python examples/survey.py [DYADS] [FILE.png]

Ten million dyads take a few seconds; a billion, minutes. Nothing is stored but counts.
"""

from __future__ import annotations

import sys

import matplotlib.pyplot as plt
import numpy as np

import telespring as ts

dyads = int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**7
file = sys.argv[2] if len(sys.argv) > 2 else "survey.png"

survey = ts.survey_dyads(dyads)
share = survey.unsafe / survey.dyads
worst = ts.unsafe_quantile(survey, 0.95)

figure, axes = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained", sharey=True)
for axis, values, title, scale in (
    (axes[0], share, "share of dyads with Eq. 5 above the exact stiffness", {"vmin": 0.0, "vmax": 1.0}),
    (axes[1], worst, "Eq. 5 over the exact stiffness, 95 % quantile", {"norm": "log"}),
):
    drawn = axis.pcolormesh(survey.damping_ratio, survey.mass_ratio, values, cmap="cividis", **scale)
    axis.set(xscale="log", yscale="log", title=title, xlabel="damping of robot 2 / robot 1")
    figure.colorbar(drawn, ax=axis)
axes[0].set_ylabel("mass of robot 2 / robot 1")
figure.suptitle(f"{int(survey.dyads.sum()):,} dyads, free handles")
figure.savefig(file, dpi=150)

# Equal robots are safe, and swapping the robots changes nothing but chance.
middle = share.sel(mass_ratio=1.0, damping_ratio=1.0, method="nearest")
mirrored = share.values[::-1, ::-1]
assert float(middle) < 0.01
assert float(np.abs(share.values - mirrored).mean()) < 0.02
whole = float(survey.unsafe.sum() / survey.dyads.sum())
print(f"unsafe: {whole:.1%}; largest ratio {float(survey.largest.max()):.1f}")
print(f"figure: {file}")
