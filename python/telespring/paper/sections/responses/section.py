"""Fig. 5: both robots' positions after opposite steps of force."""

from __future__ import annotations

import numpy as np

from telespring.paper.reference import FACTORS, classify, label_setting
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.show import figures
from telespring.theory.simulation import simulate
from telespring.theory.spectrum import spectral_abscissa

__all__ = ["SECTION", "find_responses"]


def find_responses(scene: Scene) -> Findings:
    """Simulate opposite steps of force at sixteen combinations of stiffness and delay."""
    dyad, axes, base = scene.dyad, scene.axes, scene.reference
    # Long enough to show that the marginal case of Fig. 5(h) neither grows nor decays.
    duration = 25.0 * base.delay
    samples = 801
    rate = (samples - 1) / duration
    forces = [[1.0] * len(axes), [-1.0] * len(axes)]
    grid, rows = [], []
    letters = iter("abcdefghijkl")
    for stiffness_factor in FACTORS:
        stiffness = stiffness_factor * base.stiffness
        drawn = []
        for delay_factor in (0.0, 0.5, 1.0, 2.0):
            delay = delay_factor * base.delay
            motion = simulate(dyad, stiffness, delay, forces, duration, rate=rate)
            time = np.asarray(motion["time"])
            position = np.asarray(motion["position"])
            # The paper's figure has no column without delay.
            letter = next(letters) if delay_factor else ""
            verdicts = [classify(axis, stiffness, delay) for axis in axes]
            drawn.append(
                figures.ResponsePanel(
                    letter, label_setting(stiffness_factor, delay_factor), time, position, verdicts
                )
            )
            for axis, verdict in zip(axes, verdicts, strict=True):
                rows.append(
                    {
                        "panel": letter,
                        "axis": axis.name,
                        "stiffness_factor": stiffness_factor,
                        "delay_factor": delay_factor,
                        "stiffness": stiffness,
                        "delay": delay,
                        "verdict": verdict,
                        "spectral_abscissa": float(
                            spectral_abscissa(dyad, stiffness, delay, axis=axis.index)
                        ),
                        "largest_distance": float(
                            np.nanmax(np.abs(position[:, 0, axis.index] - position[:, 1, axis.index]))
                        ),
                        "rest_distance": 1.0 / stiffness if axis.ground_stiffness == (0.0, 0.0) else None,
                    }
                )
        grid.append(drawn)
    svg = figures.to_svg(
        figures.response_figure([axis.name for axis in axes], grid),
        "responses",
        "Positions after opposite unit steps of force",
        "Sixteen panels: stiffness 0.5K, K, 2K and 4K by delay 0, 0.5Δ, Δ and 2Δ. "
        + " ".join(
            f"k = {row['stiffness_factor']:g}K, delay {row['delay_factor']:g}Δ, axis "
            f"{row['axis']}: {row['verdict']}."
            for row in rows
        ),
    )
    return Findings(
        numbers={"responses": {"duration": duration, "force": 1.0, "panels": rows}},
        drawings={"responses": svg},
    )


SECTION = Section(
    name="responses",
    anchor="figure5",
    title="Responses in time",
    step="Fig. 5, responses",
    find=find_responses,
    holds=(Place("Fig. 5", "figure-responses"),),
    mentions=("robots",),
)
