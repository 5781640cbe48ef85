"""Table II: the number sets of the roots of Eq. 8 over stiffness, for two identical robots."""

from __future__ import annotations

import cmath
import math
from typing import Any

from telespring.paper.as_printed import eta_equation_16
from telespring.paper.published import TABLE_II
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Place, Section

__all__ = ["SECTION", "find_number_sets", "roots_of_identical_robots", "table_2_set"]

#: At a boundary of the table η₂ and the roots vanish up to the rounding of a few terms of size one.
_ROUNDING = 1e-13


def roots_of_identical_robots(
    mass: float, damping: float, stiffness: float
) -> tuple[complex, complex, complex]:
    """Compute ξ₁, ξ₂ and ξ₃, squares of frequencies (rad²/s²), of two identical robots.

    The cubic of Eq. 8 then factors: F = (m²ξ − η₁)(m²ξ² − η₁ξ + 2k²), whose second factor has the
    discriminant η₂.

    Examples
    --------
    >>> [round(root.real, 6) for root in roots_of_identical_robots(1.0, 2.0, 4.0)]
    [4.0, 2.0, 2.0]
    """
    eta1, eta2 = eta_equation_16(mass, damping, stiffness)
    root = cmath.sqrt(eta2)
    return eta1 / mass**2 + 0j, (eta1 + root) / (2 * mass**2), (eta1 - root) / (2 * mass**2)


def table_2_set(value: complex, size: float) -> str:
    """Name the smallest of the table's sets that contains a value: "0", "R+", "R-" or "C" (not real).

    `size` is that of the terms that the value is the sum of, which sets its rounding error.
    """
    if abs(value) <= _ROUNDING * size:
        return "0"
    # Where a discriminant is only rounding, its square root is no larger than that of the rounding.
    if abs(value.imag) > math.sqrt(_ROUNDING) * size:
        return "C"
    return "R+" if value.real > 0 else "R-"


def find_number_sets(scene: Scene) -> Findings:
    """Compute Table II for two identical robots, and compare it with the printed one."""
    if not scene.of_the_paper:
        return Findings()
    mass, damping = scene.identical_axis.masses[0], scene.identical_axis.dampings[0]
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
    # Here the printed table, its number taken in N/m, has η₂ < 0 and the correct one has not.
    disputed = (printed_change + changes) / 2
    rows = [
        {
            "above": above,
            "below": below,
            "stiffness": stiffness,
            **_table_2_row(mass, damping, stiffness),
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
                "between": {"stiffness": disputed, **_table_2_row(mass, damping, disputed)},
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


def _table_2_row(mass: float, damping: float, stiffness: float) -> dict[str, Any]:
    eta1, eta2 = eta_equation_16(mass, damping, stiffness)
    roots = roots_of_identical_robots(mass, damping, stiffness)
    size = damping**2 + 2 * mass * stiffness
    values = (complex(eta1), complex(eta2), *roots)
    sizes = (size, size**2, *(size / mass**2,) * 3)
    sets = {key: table_2_set(value, scale) for key, value, scale in zip(_SETS, values, sizes, strict=True)}
    return {
        # Dimensionless, so that robots of any size can be compared; a zero without its rounding.
        "eta1": 0.0 if sets["eta1_set"] == "0" else eta1 / damping**2,
        "eta2": 0.0 if sets["eta2_set"] == "0" else eta2 / damping**4,
        **sets,
    }
