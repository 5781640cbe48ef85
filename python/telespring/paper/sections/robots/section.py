"""The study itself: what its spring may have, its robots, and Table III."""

from __future__ import annotations

from typing import Any

from telespring.model import Study
from telespring.paper import as_printed
from telespring.paper.reference import Reference
from telespring.paper.scene import Found, Scene
from telespring.paper.sections.summary.allowed import summarise
from telespring.theory.axis import Axis, finite_or_none, free_axis

__all__ = ["find_allowed", "find_reference"]


def find_allowed(scene: Scene) -> Found:
    """Find what the spring may have over each delay, beside the study as it was read."""
    return Found(
        numbers={"study": _study_numbers(scene.study, scene.axes), "summary": summarise(scene.study)},
    )


def find_reference(scene: Scene) -> Found:
    """Find K and Δ, as Table III defines them, and every axis' limits."""
    return Found(
        numbers={
            "table3": _table3(scene.alike_axis, scene.alike_reference, scene.reference),
            "axes": [_axis_numbers(axis, scene.reference) for axis in scene.axes],
        }
    )


def _study_numbers(study: Study, axes: list[Axis]) -> dict[str, Any]:
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
                "operator_stiffness": list(axis.ground_stiffness),
                "coupling_damping": axis.coupling_damping,
            }
            for axis in axes
        ],
    }


def _table3(ideal_axis: Axis, ideal: Reference, base: Reference) -> dict[str, Any]:
    printed = as_printed.TABLE_III
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
        "critical_stiffness_paper": free_axis(*axis.parameters).critical_stiffness("paper"),
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
