"""The stability map: over stiffness and delay, what each promise of the network allows."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from telespring._core import LONGEST_DELAY, STIFFEST
from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.decision.decide import decide
from telespring.decision.question import Question
from telespring.model import Network, Study
from telespring.paper.published import EXPERIMENT_DELAYS, EXPERIMENT_STIFFNESSES
from telespring.paper.reference import MAP_POINTS, MAP_WIDTH, classify
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section
from telespring.rehearsal.traces import read_traces
from telespring.show import figures
from telespring.show.quantities import format_time
from telespring.show.screens.questions import sampling_clause
from telespring.theory.criteria import maximum_delay
from telespring.theory.verdicts import delay_limit, verdicts

__all__ = ["SECTION", "find_map"]

#: Over ranges of operators a limit takes milliseconds: one in so many stiffnesses is judged.
_RANGE_STEP = 6
#: Delays at which the limit for a varying delay is drawn.
_VARYING_POINTS = 80


def find_map(scene: Scene) -> Findings:
    """Compute the stability map of the study's axes; limits are the worst over any ranges of operators."""
    study, axes, base = scene.study, scene.axes, scene.reference
    widest, longest, mark = MAP_WIDTH * base.stiffness, 2.4 * base.delay, scene.mark
    if mark is not None:
        # As far as the study itself needs, with room around it.
        widest = max(widest, min(1.15 * mark.stiffness, STIFFEST))
        longest = max(longest, 1.15 * mark.longest_delay)
    stiffness = np.linspace(0.0, widest, MAP_POINTS + 1)[1:]
    boundaries = []
    for axis in axes:
        printed = None
        if scene.of_the_paper and axis.is_plain:
            printed = np.asarray(maximum_delay(*axis.parameters, stiffness, method="paper"), dtype=float)
        boundaries.append(figures.MapAxis(axis.name, stiffness, axis.maximum_delay(stiffness), printed))
    judged = verdicts(study.dyad, study.stiffness, base.delay, operator_range=study.operator_ranges)
    any_network, any_constant, varying = (
        math.nan if bound is None else bound
        for bound in (
            judged.tier(name).stiffness_bound
            for name in ("any network", "any constant delay", "bounded varying delay")
        )
    )
    bounded = None
    if math.isfinite(varying):
        # Without sampling the bound is a constant over the age of the oldest sample.
        product = varying * base.delay
        bounded = (stiffness, product / stiffness)
    is_sampled = mark is not None and study.network.sample_period > 0.0
    drawn = _sampled_limits(study, longest) if is_sampled else (any_network, bounded)
    conditions = [
        (k, delay)
        for k in (EXPERIMENT_STIFFNESSES if scene.of_the_paper else ())
        for delay in EXPERIMENT_DELAYS
    ]
    status, region = None, None
    stable_for = "operators in the middle" if study.operator_ranges is not None else "all axes"
    if mark is not None:
        question = Question.of_study(study, traces=read_traces(study, scene.modules).texts)
        status = decide(question, study.stiffness, uncertainty=study.uncertainty).status
        region = _judged_delays(question, study, stiffness, longest)
        stable_for = _judged_for(question)
    svg = figures.to_svg(
        figures.tier_map(
            boundaries,
            any_network=drawn[0],
            any_constant=any_constant,
            bounded=drawn[1],
            conditions=conditions,
            extent=(widest, longest),
            mark=mark,
            stable_for=stable_for,
            judged=region,
            verdict=status,
            is_sampled=is_sampled,
        ),
        "map",
        "Stability over stiffness and delay",
        "The region where every constant delay is stable on all axes lies under the boundaries of the axes, "
        "which fall as the stiffness rises. Vertical lines mark the stiffness allowed on any network and "
        "under any constant delay; a falling curve marks the limit for a bounded varying delay. "
        + ("" if mark is None else "A star marks this study."),
    )
    numbers = {
        "axes": [
            {
                "axis": boundary.name,
                "stiffness": stiffness[::20].tolist(),
                "maximum_delay": [finite_or_none(delay) for delay in boundary.exact[::20]],
                "maximum_delay_paper": (
                    None
                    if boundary.printed is None
                    else [finite_or_none(delay) for delay in boundary.printed[::20]]
                ),
                "largest_difference": _paper_boundary_error(boundary),
            }
            for boundary in boundaries
        ],
        "mark": None if mark is None else asdict(mark) | {"status": status},
        "any_network": finite_or_none(any_network),
        "any_constant_delay": finite_or_none(any_constant),
        "bounded_varying_delay_product": None if bounded is None else float(bounded[0][0] * bounded[1][0]),
        "conditions": [
            {
                "stiffness": k,
                "delay": delay,
                "verdicts": {axis.name: classify(axis, k, delay) for axis in axes},
            }
            for k, delay in conditions
        ],
    }
    return Findings(numbers={"stability_map": numbers}, drawings={"map": svg})


SECTION = Section(
    name="map",
    anchor="map",
    title="The stability map",
    step="stability map",
    find=find_map,
    computed_after="responses",
)


def _later(question: Question) -> float:
    """Return by how much the ages in use may exceed the delay of the network, s."""
    assert question.stated is not None  # it comes with a study
    pairs = zip(question.network.buffered, question.stated.delay, strict=True)
    return round(max(0.0, *(oldest - delay for oldest, delay in pairs)), 9)


def _judged_delays(question: Question, study: Study, stiffness: FloatArray, longest: float) -> FloatArray:
    """Return the delay, s, up to which the answer would be stable at each stiffness, also if it varies.

    With the study's controllers and for every operator, as far as the ages in use may exceed the delay. It is
    0 where nothing bounds them, or nothing is judged.
    """
    network, ranges = question.network, study.operator_ranges
    if question.unjudged or not question.is_bounded:
        return np.zeros_like(stiffness)
    at = np.union1d(stiffness[:: 1 if ranges is None else _RANGE_STEP], [study.stiffness, stiffness[-1]])
    limits = np.array([delay_limit(study.dyad, float(k), network, ranges).delay for k in at])
    limits = np.minimum(limits - _later(question), 4.0 * longest)
    # Sampled controllers have steps: a line between two limits keeps below both.
    padded = np.pad(limits, 1, mode="edge")
    lower = np.minimum(np.minimum(padded[:-2], padded[2:]), limits)
    shown: FloatArray = np.maximum(np.interp(stiffness, at, lower), 0.0)
    return shown


def _sampled_limits(study: Study, longest: float) -> tuple[float, tuple[FloatArray, FloatArray] | None]:
    """Return what sampled controllers allow on any network, N/m, and under a bounded delay: N/m and s."""
    own = study.network
    points = _VARYING_POINTS // (1 if study.operator_ranges is None else 2)
    delays = np.linspace(0.0, min(longest, LONGEST_DELAY), points)
    found = [
        verdicts(
            study.dyad,
            study.stiffness,
            Network(float(delay), sample_period=own.sample_period, computing_time=own.computing_time),
            operator_range=study.operator_ranges,
        )
        for delay in delays
    ]
    bounds = [judged.tier("bounded varying delay").stiffness_bound for judged in found]
    any_network = found[0].tier("any network").stiffness_bound
    varying = None
    if None not in bounds:
        varying = np.array([bound for bound in bounds if bound is not None]), delays
    return math.nan if any_network is None else any_network, varying


def _judged_for(question: Question) -> str:
    """Say in the legend what the shaded region holds for."""
    extra = _later(question)
    return ", ".join(
        [
            "every operator" if question.operator_ranges is not None else "all axes",
            *([f"also {format_time(extra, 6)} later"] if extra > 0.0 else []),
            sampling_clause(question.network.sample_period),
        ]
    )


def _paper_boundary_error(boundary: figures.MapAxis) -> float | None:
    """Largest relative difference of the paper's boundary from the exact one, where both are finite."""
    if boundary.printed is None:
        return None
    both = np.isfinite(boundary.printed) & np.isfinite(boundary.exact)
    if not both.any() or (np.isfinite(boundary.printed) != np.isfinite(boundary.exact)).any():
        return None
    return float(np.max(np.abs(boundary.printed[both] / boundary.exact[both] - 1.0)))
