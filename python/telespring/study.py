"""The paper's sections II to IV-A on a study's robots: numbers first, then figures, then files.

`analyse` computes, `write` puts `report.html` and `study.json` into a folder. The keys of
`study.json` are listed in `docs/study-json.md`; everything in it is in SI units, and a value that is
infinite or does not exist is null.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import telespring as ts
from telespring import figures, paper
from telespring.axes import Axis, axes_of, finite_or_none, free_axis
from telespring.files import replacing
from telespring.misprints import misprints
from telespring.reference import Reference, classify, reference_of, refuse_what_cannot_be_drawn
from telespring.report import render
from telespring.stability_maps import example_maps, tier_map
from telespring.summary import summarise

__all__ = ["STEPS", "Analysis", "analyse", "write"]

#: The names of the steps, in order, as `progress` is told them.
STEPS = (
    "what the dyad may use",
    "Table III",
    "Fig. 3, Nyquist loci",
    "Fig. 4, frequency response",
    "Fig. 5, responses",
    "stability maps",
    "misprints",
    "report",
)

_FACTORS = (0.5, 1.0, 2.0, 4.0)
_WORDS = {0.0: "0", 0.5: "0.5", 1.0: "", 2.0: "2", 4.0: "4"}


@dataclass(frozen=True)
class Analysis:
    """What a study's analysis found.

    Attributes
    ----------
    numbers
        The content of `study.json`.
    html
        The report, one page with nothing loaded from elsewhere.
    """

    numbers: dict[str, Any]
    html: str


def analyse(study: ts.Study, progress: Callable[[str], None] | None = None) -> Analysis:
    """Run the paper's sections II to IV-A on a study's robots.

    Parameters
    ----------
    study
        Robots, coupling and network, as `telespring.Study.read` gives them.
    progress
        Called with the name of each step (one of `STEPS`) as it begins; nothing is called unless given.

    Returns
    -------
    Analysis
        Numbers and page. The same study gives the same bytes.

    Raises
    ------
    telespring.InvalidInput
        Where the robots allow no such study: one has no damping, or so much or so little that a figure
        would leave the ranges in which the core computes.
    """
    begin = progress or _say_nothing
    dyad = study.dyad
    axes = axes_of(dyad)
    # The paper's one-axis studies: two robots alike, both as robot 1 on its first axis, handles free.
    mass, damping = float(dyad.robots[0].mass[0]), float(dyad.robots[0].damping[0])
    ideal = ts.Dyad(ts.Robot([mass], [damping]), ts.Robot([mass], [damping]))
    ideal_axis = free_axis(mass, damping, mass, damping)
    refuse_what_cannot_be_drawn(dyad, axes, ideal_axis)
    ideal_base = reference_of([ideal_axis])
    base = reference_of(axes)
    drawings: dict[str, str] = {}

    begin(STEPS[0])
    numbers: dict[str, Any] = {
        "schema": "telespring study 1",
        "study": _study_numbers(study, axes),
        "summary": summarise(study),
    }
    begin(STEPS[1])
    numbers["table3"] = _table3(ideal_axis, ideal_base, base)
    numbers["axes"] = [_axis_numbers(axis, base) for axis in axes]
    begin(STEPS[2])
    numbers["nyquist"], drawings["nyquist"] = _nyquist(ideal, ideal_axis, ideal_base)
    begin(STEPS[3])
    numbers["frequency_response"], drawings["frequency"] = _frequency(mass, damping, ideal_base)
    begin(STEPS[4])
    numbers["responses"], drawings["responses"] = _responses(dyad, axes, base)
    begin(STEPS[5])
    numbers["stability_map"], drawings["map"] = tier_map(study, axes, base)
    numbers["examples"], drawings["examples"] = example_maps()
    begin(STEPS[6])
    numbers["misprints"] = [each.to_json() for each in misprints()]
    begin(STEPS[7])
    return Analysis(numbers=numbers, html=render(numbers, drawings))


def _say_nothing(step: str) -> None:
    """Take the place of a progress bar that nobody asked for."""


def write(analysis: Analysis, folder: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Write `report.html` and `study.json` into `folder`.

    Both are written whole and flushed to the disk beside their places before either is moved there, so
    that no page stands beside another study's numbers.

    Parameters
    ----------
    analysis
        What `analyse` returned.
    folder
        Made where it is missing.

    Returns
    -------
    report, numbers
        The two paths.

    Raises
    ------
    OSError
        Where the folder cannot be written.
    """
    text = json.dumps(analysis.numbers, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    report, numbers = Path(folder) / "report.html", Path(folder) / "study.json"
    with replacing(report) as report_beside, replacing(numbers) as numbers_beside:
        for beside, content in ((report_beside, analysis.html), (numbers_beside, text)):
            with beside.open("wb") as file:
                file.write(content.encode())
                file.flush()
                os.fsync(file.fileno())
    return report, numbers


def _setting(stiffness_factor: float, delay_factor: float) -> str:
    delay = f"δ = {_WORDS[delay_factor]}{'Δ' if delay_factor else ''}"
    return f"k = {_WORDS[stiffness_factor]}K, {delay}"


def _study_numbers(study: ts.Study, axes: list[Axis]) -> dict[str, Any]:
    return {
        "name": study.name,
        "stiffness": study.stiffness,
        "delay": {"forward": study.delay[0], "backward": study.delay[1]},
        "operator_ranges": study.operator_ranges is not None,
        "jitter": study.network.jitter,
        "max_gap": study.network.max_gap,
        "sample_period": study.network.sample_period,
        "computing_time": study.network.computing_time,
        "axes": [
            {
                "axis": axis.name,
                "mass": list(axis.masses),
                "damping": list(axis.dampings),
                "operator_stiffness": list(axis.ground_stiffnesses),
                "coupling_damping": axis.coupling_damping,
            }
            for axis in axes
        ],
    }


def _table3(ideal_axis: Axis, ideal: Reference, base: Reference) -> dict[str, Any]:
    printed = paper.TABLE_III
    return {
        "M": ideal_axis.masses[0],
        "B": ideal_axis.dampings[0],
        "K": {"ours": ideal.stiffness, "printed": printed.base_stiffness},
        "Delta": {"ours": ideal.delay, "printed": printed.base_delay},
        "K_xy": {
            "ours": base.stiffness,
            "printed": printed.reference_stiffness,
            "axis": base.stiffness_axis,
        },
        "Delta_xy": {"ours": base.delay, "printed": printed.reference_delay, "axis": base.delay_axis},
    }


def _axis_numbers(axis: Axis, base: Reference) -> dict[str, Any]:
    return {
        "axis": axis.name,
        "critical_stiffness": finite_or_none(axis.critical_stiffness()),
        "critical_stiffness_paper": axis.critical_stiffness("paper"),
        "maximum_delay": [
            {
                "factor": factor,
                "stiffness": factor * base.stiffness,
                "delay": finite_or_none(float(axis.maximum_delay(factor * base.stiffness))),
            }
            # Below the critical stiffness there is none; at it rounding would decide.
            for factor in (2.0, 4.0)
        ],
    }


def _nyquist(ideal: ts.Dyad, axis: Axis, base: Reference) -> tuple[dict[str, Any], str]:
    grid, rows = [], []
    letters = iter("abcdefghi")
    for stiffness_factor in (0.5, 1.0, 2.0):
        stiffness = stiffness_factor * base.stiffness
        drawn = []
        for delay_factor in (0.5, 1.0, 2.0):
            delay = delay_factor * base.delay
            found = ts.nyquist(ideal, stiffness, delay)
            verdict = classify(axis, stiffness, delay)
            count = None if verdict == "marginal" else found.encirclements
            note = {
                "stable": "stable",
                "marginal": "marginal",
                "unstable": f"{count} turns, unstable",
            }[verdict]
            drawn.append(
                figures.NyquistPanel(
                    setting=_setting(stiffness_factor, delay_factor),
                    locus=np.asarray(found.locus),
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
                    "peak_loop_gain": float(np.abs(found.locus).max()),
                    "spectral_abscissa": float(ts.spectral_abscissa(ideal, stiffness, delay)),
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
    return {"panels": rows}, svg


def _frequency(mass: float, damping: float, base: Reference) -> tuple[dict[str, Any], str]:
    frequency = np.geomspace(0.5, 60.0, 600)
    nominal = {"k": base.stiffness, "δ": base.delay, "m": mass, "b": damping}
    # At K no delay matters; what delay does shows above it.
    varied_delay = {**nominal, "k": 2 * base.stiffness}
    names = {"k": "K", "δ": "Δ", "m": "M", "b": "B"}
    titles = {"k": "stiffness", "δ": "delay", "m": "inertia", "b": "damping"}
    families, rows = [], []
    for symbol in nominal:
        curves = []
        for factor in (0.0, 0.5, 1.0, 2.0) if symbol == "δ" else _FACTORS:
            value = {**(varied_delay if symbol == "δ" else nominal), symbol: factor * nominal[symbol]}
            axis = free_axis(value["m"], value["b"], value["m"], value["b"])
            pair = ts.Dyad(ts.Robot([value["m"]], [value["b"]]), ts.Robot([value["m"]], [value["b"]]))
            # What robot 1 does per motion of robot 2 is one crossing, k e^(−δs)/P.
            curve = ts.partner_response(pair, value["k"], value["δ"], frequency)
            magnitude = np.asarray(curve.magnitude)
            crossing = _gain_crossing(axis, value["k"], value["δ"])
            label = f"{_WORDS[factor]}{names[symbol]}" if factor else "0"
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
        "Magnitude and phase of one crossing under stiffness, delay, inertia and damping",
        "Magnitude of the motion of one robot per motion of the other above its phase. "
        "More stiffness or inertia "
        "or less damping lifts the magnitude above one; more delay only lowers the "
        "phase. A dot marks where the "
        "magnitude falls through one; the dyad is stable where the phase there is above −180 degree.",
    )
    return {
        "nominal": {"K": base.stiffness, "Delta": base.delay, "M": mass, "B": damping},
        "curves": rows,
    }, svg


def _gain_crossing(axis: Axis, stiffness: float, delay: float) -> tuple[float, float] | None:
    """Frequency (rad/s) and phase (degree) where the magnitude falls through 1, if it does."""
    found = axis.crossings(stiffness)
    if not found:
        return None
    frequency = max(each["frequency"] for each in found)
    mass, damping = axis.masses[0], axis.dampings[0]
    if frequency < 1e-3 * math.sqrt(stiffness / mass):
        # At the critical stiffness itself the crossing sits at rest; rounding may lift it off zero.
        return None
    lag = math.atan2(damping * frequency, stiffness - mass * frequency**2) + delay * frequency
    return frequency, -math.degrees(lag)


def _responses(dyad: ts.Dyad, axes: list[Axis], base: Reference) -> tuple[dict[str, Any], str]:
    # Long enough for the marginal case of Fig. 5(h) to show that it neither grows nor dies.
    duration = 25.0 * base.delay
    samples = 801
    rate = (samples - 1) / duration
    forces = [[1.0] * len(axes), [-1.0] * len(axes)]
    grid, rows = [], []
    letters = iter("abcdefghijkl")
    for stiffness_factor in _FACTORS:
        stiffness = stiffness_factor * base.stiffness
        drawn = []
        for delay_factor in (0.0, 0.5, 1.0, 2.0):
            delay = delay_factor * base.delay
            found = ts.simulate(dyad, stiffness, delay, forces, duration, rate=rate)
            time = np.asarray(found["time"])
            position = np.asarray(found["position"])
            # The paper's figure has no column without delay.
            letter = next(letters) if delay_factor else ""
            verdicts = [classify(axis, stiffness, delay) for axis in axes]
            drawn.append(
                figures.ResponsePanel(
                    letter, _setting(stiffness_factor, delay_factor), time, position, verdicts
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
                            ts.spectral_abscissa(dyad, stiffness, delay, axis=axis.index)
                        ),
                        "largest_distance": float(
                            np.nanmax(np.abs(position[:, 0, axis.index] - position[:, 1, axis.index]))
                        ),
                        "rest_distance": 1.0 / stiffness if axis.ground_stiffnesses == (0.0, 0.0) else None,
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
    return {"duration": duration, "force": 1.0, "panels": rows}, svg
