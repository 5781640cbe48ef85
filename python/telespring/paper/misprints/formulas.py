"""Misprints in the paper's formulas."""

from __future__ import annotations

import math

import numpy as np

from telespring.model import Dyad, DyadAxis, Robot
from telespring.paper import as_printed
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.theory.criteria import critical_stiffness
from telespring.theory.response import open_loop

__all__ = [
    "misprint_in_conjugate_polynomial",
    "misprint_in_equation_2",
    "misprint_in_equation_9",
    "misprint_in_equation_16",
    "misprint_in_letters_of_section_3",
    "misprint_in_loop_of_figure_3",
    "misprint_in_table_2",
]


def misprint_in_equation_2(axis: DyadAxis, k: float) -> Misprint:
    """Compare the printed and the corrected diagonal of Eq. 2 with Eq. 1, solved at one frequency."""
    m1, b1, m2, b2 = axis.parameters
    frequency, delay = 10.0, 0.1
    s = 1j * frequency
    p1, p2 = m1 * s**2 + b1 * s + k, m2 * s**2 + b2 * s + k
    across = k * np.exp(-delay * s)
    chi = p1 * p2 - across**2
    solved = np.linalg.solve(np.array([[p1, -across], [-across, p2]]), np.array([1.0, 0.0]))[0]
    return Misprint(
        key="equation-2",
        where="Eq. 2 and Appendix A1",
        printed="X₁/F₁ = (m₁s² + b₁s + k)/χ and X₂/F₂ = (m₂s² + b₂s + k)/χ",
        true="The diagonal is swapped: X₁/F₁ = (m₂s² + b₂s + k)/χ and X₂/F₂ = (m₁s² + b₁s + k)/χ.",
        consequence="With unequal robots, each gets the other's mobility.",
        evidence=(
            Evidence(f"|X₁/F₁| on axis {axis.name}, Eq. 1 solved as a linear system", abs(solved), "m/N"),
            Evidence("the same, corrected diagonal", abs(p2 / chi), "m/N"),
            Evidence("the same, as printed", abs(p1 / chi), "m/N"),
            Evidence("frequency", frequency, "rad/s"),
            Evidence("stiffness", k, "N/m"),
            Evidence("one-way delay", delay, "s"),
        ),
    )


def misprint_in_equation_9(base: DyadAxis) -> Misprint:
    """Show that the sign in Eq. 9 vanishes for two identical robots at 2K."""
    # Two identical robots at twice the critical stiffness have B = 0 exactly; here without rounding.
    exact = DyadAxis(1.0, 2.0, 1.0, 2.0)
    k = 4.0
    frequency = math.sqrt((2 * 1.0 * k - 2.0**2) / 1.0**2)
    k_base = 2 * base.critical_stiffness()
    at_base = base.crossings(k_base)[0].frequency
    return Misprint(
        key="equation-9",
        where="Eq. 9",
        printed="z = sign(B) √(A₁A₂)/k with B = ω² − k(b₁+b₂)/(m₁b₂+m₂b₁)",
        true=(
            "At B = 0 the sign is 0, and so is z. This is not a rare case: two identical robots at k = b²/m, "
            "twice the critical stiffness, have B = 0, and that is where the paper defines Δ. The delay is "
            "((−arg(P₁P₂/k²)) mod 2π)/(2ω), which needs no sign."
        ),
        consequence=(
            "At the paper's own base point the printed formula returns zero, or rounding decides the result."
        ),
        evidence=(
            Evidence(
                "B for m = 1 kg, b = 2 N·s/m, k = 4 N/m",
                as_printed.sign_of_equation_9(*exact.parameters, k, frequency),
                "rad²/s²",
            ),
            Evidence(
                "delay by the printed formula there",
                as_printed.delay_equation_9(*exact.parameters, k, frequency),
                "s",
            ),
            Evidence("correct delay, π/(2ω)", float(exact.maximum_delay(k)), "s"),
            Evidence(
                "B/ω² for the base robot at 2K (rounding only)",
                as_printed.sign_of_equation_9(*base.parameters, k_base, at_base) / at_base**2,
                "1",
            ),
            Evidence("correct Δ of the base robot, πM/(2B)", float(base.maximum_delay(k_base)), "s"),
        ),
    )


def misprint_in_loop_of_figure_3(base: DyadAxis) -> Misprint:
    """Evaluate the printed loop of the caption and the correct one at 2K."""
    k = 2 * base.critical_stiffness()
    mass, damping = base.masses[0], base.dampings[0]
    frequency = np.linspace(0.0, 60.0, 6001)
    delay = float(base.maximum_delay(k))
    printed = as_printed.loop_in_figure_3(mass, damping, k, 2 * delay, frequency)
    pair = Dyad(Robot([mass], [damping]), Robot([mass], [damping]))
    true = np.asarray(open_loop(pair, k, delay, frequency).value)
    return Misprint(
        key="figure-3",
        where="Caption of Fig. 3",
        printed="L(s) = −k e^(−δs)/(P₁P₂)",
        true="L(s) = −k² e^(−2δs)/(P₁P₂), from Eq. 3",
        consequence="The printed L is not dimensionless, and its locus is nowhere near −1 at any delay.",
        evidence=(
            Evidence("largest |L| at 2K as printed", float(np.abs(printed).max()), "m/N"),
            Evidence("L(0) at 2K as printed", float(printed[0].real), "m/N"),
            Evidence("largest |L| at 2K, correct", float(np.abs(true).max()), "1"),
            Evidence("L(0), correct", float(true[0].real), "1"),
            Evidence("stiffness 2K", k, "N/m"),
        ),
    )


def misprint_in_letters_of_section_3(base: DyadAxis) -> Misprint:
    """Evaluate S with its arguments as printed and as meant."""
    damping, mass = base.dampings[0], base.masses[0]
    stiffness = base.critical_stiffness()
    as_mass = float(critical_stiffness(stiffness, damping, stiffness, damping, method="paper"))
    return Misprint(
        key="section-3-letters",
        where="Section III, second paragraph",
        printed="K = S(K, B, K, B) and Δ = D(K, B, K, B, 2K)",
        true="K = S(M, B, M, B) and Δ = D(M, B, M, B, 2K), as in the caption of Fig. 3",
        consequence="K would be defined in terms of itself, with a stiffness in the place of a mass.",
        evidence=(
            Evidence("S(M, B, M, B)", stiffness, "N/m"),
            Evidence("S(K, B, K, B) with that K taken as a mass in kg", as_mass, "N/m"),
            Evidence("M", mass, "kg"),
            Evidence("B", damping, "N·s/m"),
        ),
    )


def misprint_in_conjugate_polynomial(axis: DyadAxis, k: float) -> Misprint:
    """Evaluate ā by its definition, and with and without the factor s²."""
    m1, b1, m2, b2 = axis.parameters
    s, z = 5j, np.exp(-1j)

    def a(at: complex, shift: complex) -> complex:
        return (m1 * at**2 + b1 * at + k) * (m2 * at**2 + b2 * at + k) - k**2 * shift**2

    defined = z**2 * a(-s, 1 / z)
    product = (m1 * s**2 - b1 * s + k) * (m2 * s**2 - b2 * s + k)
    return Misprint(
        key="conjugate-polynomial",
        where="Appendix A1, ā(s, z)",
        printed="ā = (m₁s² − b₁s + k)(m₂s² − b₂s + k) s² z² − k²",
        true="ā = (m₁s² − b₁s + k)(m₂s² − b₂s + k) z² − k²: the factor s² is wrong.",
        consequence="Eliminating z from the printed pair does not give Eq. 8.",
        evidence=(
            Evidence("|ā| by its definition z²a(−s, 1/z)", float(abs(defined)), "N²/m²"),
            Evidence("|ā| without s²", float(abs(product * z**2 - k**2)), "N²/m²"),
            Evidence("|ā| as printed, in mixed units", float(abs(product * s**2 * z**2 - k**2)), "1"),
            Evidence("ω, with s = jω", 5.0, "rad/s"),
            Evidence("stiffness", k, "N/m"),
        ),
    )


def misprint_in_equation_16(base: DyadAxis) -> Misprint:
    """Compare both prefactors of Eq. 16 with a root of Eq. 8."""
    k = 2 * base.critical_stiffness()
    mass, damping = base.masses[0], base.dampings[0]
    printed, _ = as_printed.identical_roots_equation_16(mass, damping, k)
    roots = np.roots(as_printed.cubic_equation_8(*base.parameters, k))
    pair = max(roots, key=lambda root: root.imag)
    corrected = printed * 4 * mass**4 / (2 * mass**2)
    return Misprint(
        key="equation-16",
        where="Eq. 16",
        printed="ξ₂,₃ = (η₁ ± √η₂)/(4m⁴)",
        true="ξ₂,₃ = (η₁ ± √η₂)/(2m²)",
        consequence="The printed values are not roots of F.",
        evidence=(
            Evidence("|ξ₂| of the base robot at 2K, root of Eq. 8", float(abs(pair)), "rad²/s²"),
            Evidence("with the prefactor 1/(2m²)", float(abs(corrected)), "rad²/s²"),
            Evidence("with the printed prefactor", float(abs(printed)), "rad²/s²"),
        ),
    )


def misprint_in_table_2(base: DyadAxis) -> Misprint:
    """Evaluate η₂ where Table II has its sign change, and where it really changes."""
    mass, damping = base.masses[0], base.dampings[0]
    true = (math.sqrt(2) - 1) * damping**2 / (2 * mass)
    printed = math.sqrt(2 * damping**2 - damping**2) / (2 * mass)

    return Misprint(
        key="table-2",
        where="Table II and its footnote",
        printed="η₂ changes sign at k = √(2b²−b²)/(2m).",
        true="It changes at k = (√2−1) b²/(2m): the root covers only the 2, and b² is outside it.",
        consequence="The printed value is b/(2m), which is not even a stiffness.",
        evidence=(
            Evidence("correct k, base robot", true, "N/m"),
            Evidence(
                "η₂/b⁴ there, 0 up to rounding",
                as_printed.eta_equation_16(mass, damping, true)[1] / damping**4,
                "1",
            ),
            Evidence("printed k, in 1/s", printed, "1/s"),
            Evidence("η₂/b⁴ there", as_printed.eta_equation_16(mass, damping, printed)[1] / damping**4, "1"),
        ),
    )
