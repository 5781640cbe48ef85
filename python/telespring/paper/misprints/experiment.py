"""Misprints in the paper's numbers, figures and text on its own robots."""

from __future__ import annotations

from telespring.model import DyadAxis, hman
from telespring.paper import published
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.theory.spectrum import spectral_abscissa

__all__ = [
    "misprint_of_figure_5h",
    "misprint_of_figure_5j",
    "misprint_of_reference_delay",
    "misprint_of_robot_numbers",
]


def misprint_of_robot_numbers(axes: list[DyadAxis]) -> Misprint:
    """Show that exchanging the robots' numbers changes neither K nor Δ."""
    swapped = [DyadAxis(a.masses[1], a.dampings[1], a.masses[0], a.dampings[0]) for a in axes]
    k = min(axis.critical_stiffness() for axis in axes)
    return Misprint(
        key="robot-numbers",
        where="Section IV-A, first sentence",
        printed="M₁ and B₁ are those of H-MAN₂, M₂ and B₂ those of H-MAN₁.",
        true="Table III says the opposite: M₁ and B₁ belong to H-MAN₁. We follow Table III.",
        consequence=(
            "None for stability: exchanging the robots changes neither K nor Δ. It matters for how far each "
            "robot moves."
        ),
        evidence=(
            Evidence("K with Table III's numbering", k, "N/m"),
            Evidence(
                "K with the robots exchanged", min(axis.critical_stiffness() for axis in swapped), "N/m"
            ),
            Evidence(
                "Δ with Table III's numbering", min(float(axis.maximum_delay(2 * k)) for axis in axes), "s"
            ),
            Evidence(
                "Δ with the robots exchanged", min(float(axis.maximum_delay(2 * k)) for axis in swapped), "s"
            ),
        ),
    )


def misprint_of_reference_delay(axes: list[DyadAxis]) -> Misprint:
    """Compare the delays from K, rounded and unrounded, with those printed and used."""
    table = published.TABLE_III
    k = min(axis.critical_stiffness() for axis in axes)
    unrounded = min(float(axis.maximum_delay(2 * k)) for axis in axes)
    rounded = min(float(axis.maximum_delay(2 * table.reference_stiffness)) for axis in axes)
    return Misprint(
        key="reference-delay",
        where="Table III, Δ of both axes",
        printed="Δ_xy = 165 ms; Section IV-D and Fig. 8 use 84, 167 and 334 ms.",
        true=(
            "The unrounded K gives the delays of the experiment; K rounded to 36 N/m gives shorter ones. "
            "Neither gives 165 ms."
        ),
        consequence=(
            "Anyone who repeats the experiment from Table III uses other delays than the paper did."
        ),
        evidence=(
            Evidence("Δ_xy printed in Table III", table.reference_delay, "s"),
            Evidence("Δ_xy from the unrounded K", unrounded, "s"),
            Evidence("Δ_xy from K rounded to the printed value", rounded, "s"),
            Evidence("half of the unrounded Δ_xy (printed 84 ms)", 0.5 * unrounded, "s"),
            Evidence("half of Table III's Δ_xy", 0.5 * table.reference_delay, "s"),
            Evidence("the unrounded K", k, "N/m"),
        ),
    )


def misprint_of_figure_5h(axes: list[DyadAxis], reference: float) -> Misprint:
    """Show which axis is marginal at 2K and Δ."""
    return Misprint(
        key="figure-5h",
        where="Section IV-A on Fig. 5(h)",
        printed="The response along y neither diverges nor converges; the one along x is strictly stable.",
        true="The caption is right and the text is wrong: x is marginal, y is stable.",
        consequence="The text points the reader to the wrong axis.",
        evidence=tuple(
            Evidence(
                f"maximum delay of axis {axis.name} at 2K", float(axis.maximum_delay(2 * reference)), "s"
            )
            for axis in axes
        ),
    )


def misprint_of_figure_5j(axes: list[DyadAxis], reference: float) -> Misprint:
    """Show that one axis is still stable at 4K and 0.5Δ."""
    delay = 0.5 * min(float(axis.maximum_delay(2 * reference)) for axis in axes)
    dyad = hman()
    return Misprint(
        key="figure-5j",
        where="Fig. 5(j), its caption and Section IV-A",
        printed="At 4K the system is unstable under all delays from 0.5Δ to 2Δ.",
        true="At 0.5Δ axis x is unstable, but axis y is still stable.",
        consequence=(
            "The dyad as a whole is unstable, so the sentence is true, but the plot along y does not show it."
        ),
        evidence=(
            Evidence("0.5Δ", delay, "s"),
            *(
                Evidence(
                    f"maximum delay of axis {axis.name} at 4K", float(axis.maximum_delay(4 * reference)), "s"
                )
                for axis in axes
            ),
            *(
                Evidence(
                    f"largest real part of a root at 0.5Δ, axis {axis.name}",
                    float(spectral_abscissa(dyad, 4 * reference, delay, axis=axis.index)),
                    "1/s",
                )
                for axis in axes
            ),
        ),
    )
