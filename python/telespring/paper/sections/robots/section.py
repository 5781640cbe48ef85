"""Limits of the study's robots, axis by axis, and the reference values K and Δ of Table III."""

from __future__ import annotations

from typing import Any

from telespring._json import finite_or_none
from telespring.model import DyadAxis
from telespring.paper.published import TABLE_III
from telespring.paper.reference import Reference
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section

__all__ = ["SECTION", "find_robots"]


def find_robots(scene: Scene) -> Findings:
    """Compute K and Δ, as Table III defines them, and the limits of every axis."""
    return Findings(
        numbers={
            "table3": _table_3_numbers(scene.identical_axis, scene.identical_reference, scene.reference),
            "axes": [_table_3_axis_limits(axis, scene.reference) for axis in scene.axes],
        }
    )


SECTION = Section(
    name="robots",
    anchor="robots",
    title="The robots, K and Δ",
    step="Table III",
    find=find_robots,
    holds=(Place("Table III", "table3"),),
)


def _table_3_numbers(identical_axis: DyadAxis, identical: Reference, base: Reference) -> dict[str, Any]:
    return {
        "M": identical_axis.masses[0],
        "B": identical_axis.dampings[0],
        "K": {"ours": identical.stiffness, "printed": TABLE_III.base_stiffness},
        "Delta": {"ours": identical.delay, "printed": TABLE_III.base_delay},
        "K_xy": {
            "ours": base.stiffness,
            "printed": TABLE_III.reference_stiffness,
            "axis": base.stiffness_axis,
        },
        "Delta_xy": {"ours": base.delay, "printed": TABLE_III.reference_delay, "axis": base.delay_axis},
    }


def _table_3_axis_limits(axis: DyadAxis, base: Reference) -> dict[str, Any]:
    return {
        "axis": axis.name,
        "critical_stiffness": finite_or_none(axis.critical_stiffness()),
        "critical_stiffness_paper": DyadAxis(*axis.parameters).critical_stiffness("paper"),
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
