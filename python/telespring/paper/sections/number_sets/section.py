"""Table II: to which number sets the roots of Eq. 8 belong as the stiffness rises, two robots alike."""

from __future__ import annotations

import cmath
import math
from typing import Any

from telespring.paper.published import TABLE_II
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section

__all__ = ["SECTION", "find_number_sets", "number_set", "roots_of_robots_alike"]

#: η₂ and the roots vanish at a boundary of the table up to rounding of some terms of size one.
_ROUNDING = 1e-13


def roots_of_robots_alike(mass: float, damping: float, stiffness: float) -> tuple[complex, complex, complex]:
    """Give ξ₁, ξ₂ and ξ₃ of two robots alike.

    The cubic of Eq. 8 then falls apart: F = (m²ξ − η₁)(m²ξ² − η₁ξ + 2k²), whose second factor has the
    discriminant η₂.

    Parameters
    ----------
    mass, damping
        Of each robot, kg and N·s/m.
    stiffness
        N/m.

    Returns
    -------
    tuple of complex
        Squares of frequencies, rad²/s².

    Examples
    --------
    >>> [round(root.real, 6) for root in roots_of_robots_alike(1.0, 2.0, 4.0)]
    [4.0, 2.0, 2.0]
    """
    eta1, eta2 = _eta(mass, damping, stiffness)
    root = cmath.sqrt(eta2)
    return eta1 / mass**2 + 0j, (eta1 + root) / (2 * mass**2), (eta1 - root) / (2 * mass**2)


def number_set(value: complex, size: float) -> str:
    """Name the smallest of the table's sets that holds a value: "0", "R+", "R-" or "C".

    Parameters
    ----------
    value
        A number.
    size
        The size of the terms that it was added up from, by which rounding is judged.

    Returns
    -------
    str
        "C" where it is not real.
    """
    if abs(value) <= _ROUNDING * size:
        return "0"
    # The square root of a discriminant that vanishes but for rounding is no larger than that of rounding.
    if abs(value.imag) > math.sqrt(_ROUNDING) * size:
        return "C"
    return "R+" if value.real > 0 else "R-"


def find_number_sets(scene: Scene) -> Findings:
    """Compute Table II on two robots alike, beside the printed one."""
    mass, damping = scene.alike_axis.masses[0], scene.alike_axis.dampings[0]
    critical = damping**2 / (2 * mass)
    changes = (math.sqrt(2) - 1) * critical
    # In the middle of each open range, at its boundaries, and at twice the critical stiffness.
    settings = (
        (0.0, changes, changes / 2),
        (changes, changes, changes),
        (changes, critical, (changes + critical) / 2),
        (critical, critical, critical),
        (critical, None, 2 * critical),
    )
    printed_change = math.sqrt(2 * damping**2 - damping**2) / (2 * mass)
    # Where the printed table has η₂ < 0, and the true one does not, if the number is taken in N/m.
    disputed = (printed_change + changes) / 2
    rows = [
        {
            "above": above,
            "below": below,
            "stiffness": stiffness,
            **_row(mass, damping, stiffness),
            "printed": dict(zip(_SETS, printed, strict=True)),
        }
        for (above, below, stiffness), printed in zip(settings, TABLE_II, strict=True)
    ]
    return Findings(
        numbers={
            "table2": {
                "mass": mass,
                "damping": damping,
                "rows": rows,
                "sign_change": {"ours": changes, "printed": printed_change},
                "between": {"stiffness": disputed, **_row(mass, damping, disputed)},
            }
        }
    )


SECTION = Section(
    name="number_sets",
    anchor="table2",
    title="Roots of two identical robots",
    step="Table II",
    find=find_number_sets,
    holds=(Place("Table II", "number-sets"),),
    mentions=("misprints",),
    computed_after="robots",
)


_SETS = ("eta1_set", "eta2_set", "xi1_set", "xi2_set", "xi3_set")


def _eta(mass: float, damping: float, stiffness: float) -> tuple[float, float]:
    """η₁ (N²·s²/m²) and η₂ (its square) of Eq. 16."""
    eta1 = 2 * mass * stiffness - damping**2
    eta2 = damping**4 - 4 * mass**2 * stiffness**2 - 4 * mass * damping**2 * stiffness
    return eta1, eta2


def _row(mass: float, damping: float, stiffness: float) -> dict[str, Any]:
    eta1, eta2 = _eta(mass, damping, stiffness)
    roots = roots_of_robots_alike(mass, damping, stiffness)
    size = damping**2 + 2 * mass * stiffness
    found = (complex(eta1), complex(eta2), *roots)
    sizes = (size, size**2, *(size / mass**2,) * 3)
    sets = {key: number_set(value, each) for key, value, each in zip(_SETS, found, sizes, strict=True)}
    return {
        # As pure numbers, so that robots of every size can be compared; a zero without its rounding.
        "eta1": 0.0 if sets["eta1_set"] == "0" else eta1 / damping**2,
        "eta2": 0.0 if sets["eta2_set"] == "0" else eta2 / damping**4,
        **sets,
    }
