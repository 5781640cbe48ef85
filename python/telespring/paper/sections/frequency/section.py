"""Fig. 4: magnitude and phase of one robot's motion per motion of the other."""

from __future__ import annotations

import math

import numpy as np

from telespring.model import Dyad, DyadAxis, Robot
from telespring.paper.reference import FACTOR_LABELS, FACTORS, classify
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section
from telespring.show import figures
from telespring.theory.response import partner_response

__all__ = ["SECTION", "find_frequency"]


def find_frequency(scene: Scene) -> Findings:
    """Compute the response of one robot to the motion of the other, one parameter varied at a time."""
    base = scene.identical_reference
    mass, damping = scene.identical_axis.masses[0], scene.identical_axis.dampings[0]
    frequency = np.geomspace(0.5, 60.0, 600)
    nominal = {"k": base.stiffness, "δ": base.delay, "m": mass, "b": damping}
    # At K no delay matters; its effect shows above K.
    varied_delay = {**nominal, "k": 2 * base.stiffness}
    names = {"k": "K", "δ": "Δ", "m": "M", "b": "B"}
    titles = {"k": "stiffness", "δ": "delay", "m": "inertia", "b": "damping"}
    families, rows = [], []
    for symbol in nominal:
        curves = []
        for factor in (0.0, 0.5, 1.0, 2.0) if symbol == "δ" else FACTORS:
            value = {**(varied_delay if symbol == "δ" else nominal), symbol: factor * nominal[symbol]}
            axis = DyadAxis(value["m"], value["b"], value["m"], value["b"])
            pair = Dyad(Robot([value["m"]], [value["b"]]), Robot([value["m"]], [value["b"]]))
            # The motion of robot 1 per motion of robot 2 is k e^(−δs)/P.
            curve = partner_response(pair, value["k"], value["δ"], frequency)
            magnitude = np.asarray(curve.magnitude)
            crossing = _partner_gain_crossing(axis, value["k"], value["δ"])
            label = f"{FACTOR_LABELS[factor]}{names[symbol]}" if factor else "0"
            curves.append(
                figures.FrequencyCurve(
                    label=label,
                    magnitude=magnitude,
                    phase=np.degrees(np.asarray(curve.phase)),
                    gain_crossing=crossing,
                )
            )
            rows.append(
                {
                    "varied": titles[symbol],
                    "label": label,
                    "stiffness": value["k"],
                    "delay": value["δ"],
                    "mass": value["m"],
                    "damping": value["b"],
                    "peak_magnitude": float(max(1.0, magnitude.max())),
                    "gain_crossing_frequency": None if crossing is None else crossing[0],
                    "phase_margin": None if crossing is None else math.radians(180.0 + crossing[1]),
                    "verdict": classify(axis, value["k"], value["δ"]),
                }
            )
        at = " at 2K" if symbol == "δ" else ""
        families.append(figures.FrequencyFamily(f"{titles[symbol]} {symbol}{at}", curves))
    svg = figures.to_svg(
        figures.frequency_figure(frequency, families),
        "frequency",
        "Magnitude and phase under stiffness, delay, inertia and damping",
        "Top: magnitude of the motion of one robot per motion of the other. Bottom: phase. "
        "More stiffness or inertia or less damping raises the magnitude above one; more delay only lowers "
        "the phase. A dot marks where the magnitude falls below one; the dyad is stable if the phase there "
        "is above −180 degrees.",
    )
    return Findings(
        numbers={
            "frequency_response": {
                "nominal": {"K": base.stiffness, "Delta": base.delay, "M": mass, "B": damping},
                "curves": rows,
            }
        },
        drawings={"frequency": svg},
    )


SECTION = Section(
    name="frequency",
    anchor="figure4",
    title="Frequency response",
    step="Fig. 4, frequency response",
    find=find_frequency,
    holds=(Place("Fig. 4", "figure-frequency"),),
)


def _partner_gain_crossing(axis: DyadAxis, stiffness: float, delay: float) -> tuple[float, float] | None:
    """Frequency (rad/s) and phase (degree) where the magnitude falls through 1, if it does."""
    crossings = axis.crossings(stiffness)
    if not crossings:
        return None
    frequency = max(crossing.frequency for crossing in crossings)
    mass, damping = axis.masses[0], axis.dampings[0]
    if frequency < 1e-3 * math.sqrt(stiffness / mass):
        # At the critical stiffness itself the crossing is at zero frequency, up to rounding.
        return None
    lag = math.atan2(damping * frequency, stiffness - mass * frequency**2) + delay * frequency
    return frequency, -math.degrees(lag)
