"""Reference stiffness K and delay Δ of a study: the paper draws its figures at multiples of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from telespring._errors import InvalidInput
from telespring.model import Dyad, DyadAxis, Robot

__all__ = [
    "FACTORS",
    "FACTOR_LABELS",
    "MAP_POINTS",
    "MAP_WIDTH",
    "Reference",
    "check_figure_ranges",
    "classify",
    "label_setting",
    "reference_of",
]

#: Multiples of K at which the paper draws its figures, and how multiples of K and Δ are written.
FACTORS = (0.5, 1.0, 2.0, 4.0)
FACTOR_LABELS = {0.0: "0", 0.5: "0.5", 1.0: "", 2.0: "2", 4.0: "4"}

#: The map has this many stiffnesses, up to this multiple of K, the largest of all figures, or as far as the
#: study's own stiffness needs.
MAP_POINTS = 600
MAP_WIDTH = 4.6

#: Extreme multiples in the figures: of K, of Δ, and of the first robot's mass and damping.
_STIFFNESS_FACTORS = (MAP_WIDTH / MAP_POINTS, MAP_WIDTH)
_DELAY_FACTOR = 2.0
_ROBOT_FACTORS = (0.5, 4.0)

#: The ranges in which the core computes: N/m, s, kg and N·s/m.
_STIFFNESS_RANGE = (1e-6, 1e7)
_LONGEST_DELAY = 100.0
_MASS_RANGE = (1e-4, 1e4)
_LARGEST_DAMPING = 1e6


@dataclass(frozen=True)
class Reference:
    """Reference stiffness K (N/m) and delay Δ (s, at 2K) of some axes, Eq. 11, and the axes that set them."""

    stiffness: float
    delay: float
    stiffness_axis: str
    delay_axis: str


def reference_of(axes: list[DyadAxis]) -> Reference:
    """Compute K and Δ of Eq. 11 from the exact critical stiffness; every axis must be damped.

    Operators can make every stiffness safe. Then Eq. 5 with the same masses and dampings gives K, and Δ is
    0.1 s, so that the figures can still be drawn.
    """
    stiffness, stiffness_axis = _reference_stiffness_of(axes)
    delays = {axis.name: float(axis.maximum_delay(2 * stiffness)) for axis in axes}
    delay_axis = min(delays, key=lambda name: delays[name])
    delay = delays[delay_axis]
    return Reference(stiffness, delay if math.isfinite(delay) else 0.1, stiffness_axis, delay_axis)


def label_setting(stiffness_factor: float, delay_factor: float) -> str:
    """Write a stiffness and a delay as multiples of K and Δ, as in "k = 2K, δ = 0.5Δ"."""
    delay = f"δ = {FACTOR_LABELS[delay_factor]}{'Δ' if delay_factor else ''}"
    return f"k = {FACTOR_LABELS[stiffness_factor]}K, {delay}"


def classify(axis: DyadAxis, stiffness: float, delay: float) -> str:
    """Return "stable", "unstable", or "marginal" if the delay is a crossing up to rounding (1e-9)."""
    for crossing in axis.crossings(stiffness):
        spacing = math.pi / crossing.frequency
        turns = round((delay - crossing.delay) / spacing)
        if turns >= 0 and abs(delay - crossing.delay - turns * spacing) <= 1e-9 * delay:
            return "marginal"
    return "stable" if axis.is_stable(stiffness, delay) else "unstable"


def check_figure_ranges(dyad: Dyad, axes: list[DyadAxis], identical: DyadAxis) -> None:
    """Refuse robots for which a figure would exceed the ranges of the core, naming the mass or damping."""
    for side, robot in enumerate(dyad.robots, start=1):
        for i, damping in enumerate(robot.damping):
            if damping == 0.0:
                raise InvalidInput(
                    f"robot{side}.damping[{i}]",
                    "0",
                    "the report needs a damping above 0 N·s/m on every axis, because K is 0 without it",
                    "Give the measured damping, or use `telespring decide`.",
                )
    # Fig. 4 varies the first robot on its first axis.
    mass, damping = float(dyad.robots[0].mass[0]), float(dyad.robots[0].damping[0])
    least, most = _MASS_RANGE[0] / _ROBOT_FACTORS[0], _MASS_RANGE[1] / _ROBOT_FACTORS[1]
    if not least <= mass <= most:
        raise InvalidInput(
            "robot1.mass[0]",
            f"{mass:g}",
            f"the report also draws half and four times this mass, so it takes {least:g} to {most:g} kg",
            "Check the unit (kg), or use `telespring decide`.",
        )
    if damping > _LARGEST_DAMPING / _ROBOT_FACTORS[1]:
        raise InvalidInput(
            "robot1.damping[0]",
            f"{damping:g}",
            f"the report also draws four times this damping, so it takes up to "
            f"{_LARGEST_DAMPING / _ROBOT_FACTORS[1]:g} N·s/m",
            "Check the unit (N·s/m), or use `telespring decide`.",
        )
    for group, robots in ((axes, dyad.robots), ([identical], dyad.robots[:1])):
        stiffness, name = _reference_stiffness_of(group)
        low, high = (factor * stiffness for factor in _STIFFNESS_FACTORS)
        axis = next(axis for axis in group if axis.name == name)
        if low < _STIFFNESS_RANGE[0] or high > _STIFFNESS_RANGE[1]:
            least, most = (
                bound / factor for bound, factor in zip(_STIFFNESS_RANGE, _STIFFNESS_FACTORS, strict=True)
            )
            raise _refuse_damping(
                robots,
                axis,
                low < _STIFFNESS_RANGE[0],
                f"with it the critical stiffness of axis {name} is {stiffness:.3g} N/m, but the report needs "
                f"one from {least:.3g} to {most:.3g} N/m to draw its multiples",
            )
        reference = reference_of(group)
        if _DELAY_FACTOR * reference.delay > _LONGEST_DELAY:
            raise _refuse_damping(
                robots,
                next(axis for axis in group if axis.name == reference.delay_axis),
                True,
                f"with it Δ of axis {reference.delay_axis} is {reference.delay:.3g} s, but "
                f"the report, which draws up to 2Δ, takes at most {_LONGEST_DELAY / _DELAY_FACTOR:g} s",
            )


def _reference_stiffness_of(axes: list[DyadAxis]) -> tuple[float, str]:
    critical = {axis.name: axis.critical_stiffness() for axis in axes}
    name = min(critical, key=critical.__getitem__)
    if math.isinf(critical[name]):
        return min(DyadAxis(*axis.parameters).critical_stiffness("paper") for axis in axes), name
    return critical[name], name


def _refuse_damping(robots: Sequence[Robot], axis: DyadAxis, too_little: bool, allowed: str) -> InvalidInput:
    """Refuse, for the figures, the damping of the robot that is further out of range on that axis."""
    dampings = [float(robot.damping[axis.index]) for robot in robots]
    side = dampings.index(min(dampings) if too_little else max(dampings))
    return InvalidInput(
        f"robot{side + 1}.damping[{axis.index}]",
        f"{dampings[side]:g}",
        allowed,
        f"Check the unit (N·s/m) and give {'more' if too_little else 'less'} damping, or use "
        "`telespring decide`.",
    )
