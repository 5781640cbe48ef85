"""Misprints of the paper: where it prints something that does not follow from its own Eq. 1.

Every number is computed when the report is made: printed values by the formulas in
`telespring.paper.as_printed`, correct values by the package.
"""

from __future__ import annotations

from telespring.model import DyadAxis, hman
from telespring.paper import published
from telespring.paper.misprints import experiment, formulas, methods, statements
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.paper.misprints.statements import RETURNING, held_partner_growth

__all__ = ["RETURNING", "Evidence", "Misprint", "held_partner_growth", "misprints"]


def misprints() -> list[Misprint]:
    """List all misprints in the paper's order, proven on the paper's own robots or on a small example."""
    dyad = hman()
    axes = list(dyad)
    reference = min(axis.critical_stiffness() for axis in axes)
    base_robot = published.TABLE_III.base_mass, published.TABLE_III.base_damping
    base = DyadAxis(*base_robot, *base_robot)
    return [
        formulas.misprint_in_equation_2(axes[1], 2 * reference),
        statements.wrong_statement_on_rigid_body_root(dyad, axes[0], 2 * reference),
        statements.wrong_statement_on_equation_5(),
        statements.wrong_statement_on_returning_stability(),
        formulas.misprint_in_equation_9(base),
        statements.wrong_statement_on_maximum_delay(dyad, axes[0], 2 * reference),
        formulas.misprint_in_loop_of_figure_3(base),
        formulas.misprint_in_letters_of_section_3(base),
        experiment.misprint_of_robot_numbers(axes),
        experiment.misprint_of_reference_delay(axes),
        experiment.misprint_of_figure_5h(axes, reference),
        experiment.misprint_of_figure_5j(axes, reference),
        methods.wrong_statement_on_free_handles(),
        statements.wrong_statement_on_varying_delay(base),
        formulas.misprint_in_conjugate_polynomial(axes[0], 2 * reference),
        formulas.misprint_in_equation_16(base),
        formulas.misprint_in_table_2(base),
        methods.wrong_statement_on_weights(),
        methods.wrong_statement_on_spot_velocity(),
    ]
