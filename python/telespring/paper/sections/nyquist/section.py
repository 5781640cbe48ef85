"""Fig. 3: Nyquist loci over stiffness and delay."""

from __future__ import annotations

import numpy as np

from telespring.paper.reference import classify, label_setting
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.show import figures
from telespring.theory.response import nyquist
from telespring.theory.spectrum import spectral_abscissa

__all__ = ["SECTION", "find_nyquist"]


def find_nyquist(scene: Scene) -> Findings:
    """Draw nine loci of two identical robots and count their encirclements of −1."""
    dyad, axis, base = scene.identical, scene.identical_axis, scene.identical_reference
    grid, rows = [], []
    letters = iter("abcdefghi")
    for stiffness_factor in (0.5, 1.0, 2.0):
        stiffness = stiffness_factor * base.stiffness
        drawn = []
        for delay_factor in (0.5, 1.0, 2.0):
            delay = delay_factor * base.delay
            locus = nyquist(dyad, stiffness, delay)
            verdict = classify(axis, stiffness, delay)
            count = None if verdict == "marginal" else locus.encirclements
            note = {
                "stable": "stable",
                "marginal": "marginal",
                "unstable": f"{count} turns, unstable",
            }[verdict]
            drawn.append(
                figures.NyquistPanel(
                    setting=label_setting(stiffness_factor, delay_factor),
                    locus=np.asarray(locus.locus),
                    verdict=verdict,
                    note=note,
                )
            )
            rows.append(
                {
                    "panel": next(letters),
                    "stiffness_factor": stiffness_factor,
                    "delay_factor": delay_factor,
                    "stiffness": stiffness,
                    "delay": delay,
                    "verdict": verdict,
                    "encirclements": count,
                    "peak_loop_gain": float(np.abs(locus.locus).max()),
                    "spectral_abscissa": float(spectral_abscissa(dyad, stiffness, delay)),
                }
            )
        grid.append(drawn)
    svg = figures.to_svg(
        figures.nyquist_figure(grid),
        "nyquist",
        "Nyquist loci of two identical robots",
        "Nine loci of L for stiffness 0.5K, K and 2K and delay 0.5Δ, Δ and 2Δ. All start "
        "at −1, the rigid-body "
        "root. " + " ".join(f"({row['panel']}) {row['verdict']}." for row in rows),
    )
    return Findings(numbers={"nyquist": {"panels": rows}}, drawings={"nyquist": svg})


SECTION = Section(
    name="nyquist",
    anchor="figure3",
    title="Nyquist loci",
    step="Fig. 3, Nyquist loci",
    find=find_nyquist,
    holds=(Place("Fig. 3", "figure-nyquist"),),
    mentions=("robots",),
)
