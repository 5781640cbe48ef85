"""The maps of a study: stability over stiffness and delay, and where the paper's formulas fail."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring.paper import as_printed
from telespring.paper.misprints import RETURNING
from telespring.paper.reference import MAP_POINTS, MAP_WIDTH, classify
from telespring.paper.scene import Found, Scene
from telespring.show import figures
from telespring.theory.axis import Axis, finite_or_none, free_axis
from telespring.theory.criteria import maximum_delay
from telespring.theory.verdicts import verdicts

__all__ = ["find_examples", "find_map"]


def find_map(scene: Scene) -> Found:
    """Draw the study's own map with the verdicts' limits, worst over the ranges of operators if given."""
    study, axes, base = scene.study, scene.axes, scene.reference
    widest, longest = MAP_WIDTH * base.stiffness, 2.4 * base.delay
    stiffness = np.linspace(0.0, widest, MAP_POINTS + 1)[1:]
    shown = []
    for axis in axes:
        printed = None
        if axis.is_plain:
            printed = _printed_delay(axis, stiffness)
        shown.append(figures.MapAxis(axis.name, stiffness, axis.maximum_delay(stiffness), printed))
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
    conditions = [
        (k, delay)
        for k in (as_printed.EXPERIMENT_STIFFNESSES if scene.of_the_paper else ())
        for delay in as_printed.EXPERIMENT_DELAYS
    ]
    svg = figures.to_svg(
        figures.tier_map(
            shown,
            any_network=any_network,
            any_constant=any_constant,
            bounded=bounded,
            conditions=conditions,
            extent=(widest, longest),
            stable_for="operators in the middle" if study.operator_ranges is not None else "all axes",
        ),
        "map",
        "Stability over stiffness and delay",
        "The region where every constant delay shown is stable on all axes lies under "
        "the boundaries of the axes, "
        "which fall as the stiffness rises. Vertical lines mark the stiffness allowed on "
        "any network and under any "
        "constant delay; a falling curve marks the limit for a bounded varying delay.",
    )
    curves = [
        {
            "axis": each.name,
            "stiffness": stiffness[::20].tolist(),
            "maximum_delay": [finite_or_none(v) for v in each.exact[::20]],
            "maximum_delay_paper": (
                None if each.printed is None else [finite_or_none(v) for v in each.printed[::20]]
            ),
            "largest_difference": _largest_difference(each),
        }
        for each in shown
    ]
    numbers = {
        "axes": curves,
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
    return Found(numbers={"stability_map": numbers}, drawings={"map": svg})


def _printed_delay(axis: Axis, stiffness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Eqs. 5 to 9 as printed, s."""
    return np.asarray(maximum_delay(*axis.parameters, stiffness, method="paper"), dtype=float)


def _largest_difference(each: figures.MapAxis) -> float | None:
    """Largest relative difference of the paper's boundary from the exact one, where both are finite."""
    if each.printed is None:
        return None
    both = np.isfinite(each.printed) & np.isfinite(each.exact)
    if not both.any() or (np.isfinite(each.printed) != np.isfinite(each.exact)).any():
        return None
    return float(np.max(np.abs(each.printed[both] / each.exact[both] - 1.0)))


def find_examples(_scene: Scene) -> Found:
    """Draw two dyads on which the paper's formulas fail; they are the same in every study."""
    unequal = free_axis(1.0, 1.0, 1.0, 10.0)
    parameters, returning_stiffness = RETURNING
    returning = free_axis(*parameters)
    panels = []
    numbers: dict[str, Any] = {}
    settings = (
        ("unequal_damping", unequal, "m = 1, 1 kg, b = 1, 10 N·s/m", 40.0, 0.8),
        ("stability_returns", returning, "m = 0.98, 0.30 kg, b = 2.2, 4.6 N·s/m", 16.0, 3.0),
    )
    for key, axis, title, widest, longest in settings:
        stiffness = np.linspace(0.0, widest, 481)[1:]
        columns = [
            figures.MapColumn(float(k), axis.stable_delays(float(k), 1.01 * longest)) for k in stiffness
        ]
        printed = _printed_delay(axis, stiffness)
        panels.append((title, columns, printed))
        numbers[key] = {
            "mass": list(axis.masses),
            "damping": list(axis.dampings),
            "critical_stiffness": axis.critical_stiffness(),
            "critical_stiffness_paper": axis.critical_stiffness("paper"),
            "boundary": [
                {
                    "stiffness": column.stiffness,
                    "stable_delays": [list(interval) for interval in column.stable],
                    "maximum_delay_paper": finite_or_none(float(value)),
                }
                for column, value in list(zip(columns, printed, strict=True))[::16]
            ],
        }
    svg = figures.to_svg(
        figures.region_map(
            panels,
            longest=[each[4] for each in settings],
            marks=[(0.99 * unequal.critical_stiffness("paper"), 0.175), (returning_stiffness, 1.95)],
        ),
        "examples",
        "Two dyads on which the paper's formulas fail",
        "Left: with dampings 1 and 10 the paper calls a hatched region stable that is "
        "not. Right: a dyad whose stable delays are two separate intervals, so that a cross "
        "lies in a stable region above an unstable one.",
    )
    numbers["unequal_damping"]["mark"] = {
        "stiffness": 0.99 * unequal.critical_stiffness("paper"),
        "delay": 0.175,
        "verdict": classify(unequal, 0.99 * unequal.critical_stiffness("paper"), 0.175),
    }
    numbers["stability_returns"]["mark"] = {
        "stiffness": returning_stiffness,
        "delay": 1.95,
        "verdict": classify(returning, returning_stiffness, 1.95),
    }
    return Found(numbers={"examples": numbers}, drawings={"examples": svg})
