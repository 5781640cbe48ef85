"""Robots drawn from their uncertainty: each draw depends on the seed and its number only."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from statistics import NormalDist
from typing import Any

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring.decision.uncertainty import LIGHTEST

__all__ = ["drawn_robots", "require_uncertainty"]

_NORMAL = NormalDist()
#: Attempts at a physical robot; one in a thousand failing at once is a very uncertain robot.
_ATTEMPTS = 1000


def require_uncertainty(studies: Iterable[Study]) -> None:
    """Refuse studies of which nothing can be drawn."""
    if all(study.uncertainty == (None, None) for study in studies):
        raise InvalidInput(
            "draws",
            "",
            "the robots' uncertainty is required: robot1.mass_sd and robot1.damping_sd, or those of robot 2",
            "Use robot files that `telespring identify` wrote, or add the standard deviations to the study.",
        )


def drawn_robots(study: Study, seed: int, draw: int) -> dict[str, dict[str, Any]]:
    """Draw masses and dampings of both robots, as `Study.replace` takes them.

    They are jointly normal on each axis, with the standard deviations and the correlation of the study;
    robots and axes are independent. A draw with a mass below 0.0001 kg or a damping below 0 is repeated.
    """
    changes: dict[str, dict[str, Any]] = {}
    for index, (robot, known) in enumerate(zip(study.dyad.robots, study.uncertainty, strict=True)):
        if known is None:
            continue
        masses, dampings = [], []
        for axis, (mass, damping) in enumerate(zip(robot.mass, robot.damping, strict=True)):
            deviations = float(known.mass_sd[axis]), float(known.damping_sd[axis])
            place = f"{seed} {draw} {index} {axis}"
            drawn = _draw(float(mass), float(damping), *deviations, float(known.correlation[axis]), place)
            masses.append(drawn[0])
            dampings.append(drawn[1])
        changes[f"robot{index + 1}"] = {"mass": masses, "damping": dampings}
    return changes


def _draw(
    mass: float, damping: float, mass_sd: float, damping_sd: float, correlation: float, place: str
) -> tuple[float, float]:
    for attempt in range(_ATTEMPTS):
        first, second = _standard_normals(f"draw {place} {attempt}")
        second = correlation * first + math.sqrt(max(0.0, 1.0 - correlation**2)) * second
        drawn = mass + mass_sd * first, damping + damping_sd * second
        if drawn[0] >= LIGHTEST and drawn[1] >= 0.0:
            return drawn
    raise InvalidInput(
        "draws",
        f"{mass:g} ± {mass_sd:g} kg, {damping:g} ± {damping_sd:g} N·s/m",
        "hardly any draw is a robot: its standard deviations are too large",
        "Check mass_sd and damping_sd.",
    )


def _standard_normals(text: str) -> tuple[float, float]:
    """Return two standard normal numbers that depend on a text only, not on a library's generator."""
    digest = hashlib.blake2b(text.encode(), digest_size=16).digest()
    # The middles of 2^53 equal parts, never 0 or 1.
    first, second = ((int.from_bytes(half, "little") >> 11) + 0.5 for half in (digest[:8], digest[8:]))
    return _NORMAL.inv_cdf(first / 2.0**53), _NORMAL.inv_cdf(second / 2.0**53)
