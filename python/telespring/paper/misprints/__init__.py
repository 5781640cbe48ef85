"""Misprints of the paper: where it prints something that does not follow from its own Eq. 1.

Every number is computed when the report is made: printed values by the formulas in
`telespring.paper.as_printed`, correct values by the package.
"""

from __future__ import annotations

from telespring.model import DyadAxis, hman
from telespring.paper import published
from telespring.paper.misprints import experiment, formulas, statements
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.paper.misprints.statements import RETURNING, held_partner_growth

__all__ = ["RETURNING", "Evidence", "Misprint", "held_partner_growth", "misprints"]


def misprints() -> list[Misprint]:
    """List all misprints in the paper's order, proven on the paper's own robots or on a small example."""
    dyad = hman()
    axes = [dyad[name] for name in dyad.axes]
    reference = min(axis.critical_stiffness() for axis in axes)
    base_robot = published.TABLE_III.base_mass, published.TABLE_III.base_damping
    base = DyadAxis(*base_robot, *base_robot)
    return [
        formulas.diagonal_of_equation_2(axes[1], 2 * reference),
        statements.rigid_body_root(dyad, axes[0], 2 * reference),
        statements.equation_5_is_not_sufficient(),
        statements.stability_returns(),
        formulas.sign_in_equation_9(base),
        statements.less_or_equal(dyad, axes[0], 2 * reference),
        formulas.loop_of_figure_3(base),
        formulas.letters_of_section_3(base),
        experiment.numbers_of_the_robots(axes),
        experiment.reference_delay(axes),
        experiment.figure_5h(axes, reference),
        experiment.figure_5j(axes, reference),
        statements.constant_delay_only(base),
        formulas.conjugate_polynomial(axes[0], 2 * reference),
        formulas.equation_16(base),
        formulas.table_2(base),
    ]
