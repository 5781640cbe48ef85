"""Where the paper prints something else than what follows from its own Eq. 1, with the numbers.

Every number is computed when the study runs: what is printed by the formulas in
`telespring.paper`, what is true by the package.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import telespring as ts
from telespring import paper
from telespring.axes import Axis, axes_of, finite_or_none, free_axis

__all__ = ["Evidence", "Misprint", "misprints"]


@dataclass(frozen=True)
class Evidence:
    """One computed number; `unit` is SI, "1" for a pure number."""

    label: str
    value: float | None
    unit: str


@dataclass(frozen=True)
class Misprint:
    """One place in the paper.

    Attributes
    ----------
    key
        A word to find it by.
    where
        Equation, figure, table or section of the paper.
    printed, true
        What stands there, and what is right.
    consequence
        What a reader who trusts the print would do wrongly.
    evidence
        The numbers that show it.
    """

    key: str
    where: str
    printed: str
    true: str
    consequence: str
    evidence: tuple[Evidence, ...]

    def to_json(self) -> dict[str, Any]:
        """Plain data for `study.json`."""
        return {
            "key": self.key,
            "where": self.where,
            "printed": self.printed,
            "true": self.true,
            "consequence": self.consequence,
            "evidence": [
                {"label": each.label, "value": each.value, "unit": each.unit} for each in self.evidence
            ],
        }


def misprints() -> list[Misprint]:
    """All of them, in the paper's order, shown on the paper's own robots or the smallest example."""
    dyad = ts.hman()
    axes = axes_of(dyad)
    reference = min(axis.critical_stiffness() for axis in axes)
    base = free_axis(
        paper.TABLE_III.base_mass,
        paper.TABLE_III.base_damping,
        paper.TABLE_III.base_mass,
        paper.TABLE_III.base_damping,
    )
    return [
        _diagonal_of_equation_2(axes[1], 2 * reference),
        _rigid_body_root(dyad, axes[0], 2 * reference),
        _equation_5_is_not_sufficient(),
        _stability_returns(),
        _sign_in_equation_9(base),
        _less_or_equal(dyad, axes[0], 2 * reference),
        _loop_of_figure_3(base),
        _letters_of_section_3(base),
        _numbers_of_the_robots(axes),
        _reference_delay(axes),
        _figure_5h(axes, reference),
        _figure_5j(axes, reference),
        _constant_delay_only(base),
        _conjugate_polynomial(axes[0], 2 * reference),
        _equation_16(base),
        _table_2(base),
    ]


def _dyad(m1: float, b1: float, m2: float, b2: float) -> ts.Dyad:
    return ts.Dyad(ts.Robot([m1], [b1]), ts.Robot([m2], [b2]))


def _diagonal_of_equation_2(axis: Axis, k: float) -> Misprint:
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
        consequence="With unequal robots each robot is given the other's mobility.",
        evidence=(
            Evidence(f"|X₁/F₁| on axis {axis.name}, Eq. 1 solved as a linear system", abs(solved), "m/N"),
            Evidence("the same, corrected diagonal", abs(p2 / chi), "m/N"),
            Evidence("the same, as printed", abs(p1 / chi), "m/N"),
            Evidence("at the frequency", frequency, "rad/s"),
            Evidence("with the stiffness", k, "N/m"),
            Evidence("and the one-way delay", delay, "s"),
        ),
    )


def _rigid_body_root(dyad: ts.Dyad, axis: Axis, k: float) -> Misprint:
    m1, b1, m2, b2 = axis.parameters
    delay = 0.5 * float(axis.maximum_delay(k))
    slope = k * (b1 + b2) + 2 * delay * k**2
    step = 1e-6

    def characteristic(s: float) -> float:
        return (m1 * s**2 + b1 * s + k) * (m2 * s**2 + b2 * s + k) - k**2 * math.exp(-2 * delay * s)

    return Misprint(
        key="rigid-body-root",
        where="Section II, Fig. 3",
        printed="Stability is read off the Nyquist plot's turns about −1, without more ado.",
        true=(
            "χ(0) = 0 for every parameter: both robots can be carried off together. The locus passes through "
            "−1 at ω = 0, so the count means nothing until that root is divided out. "
            "Stable means: s = 0 is a simple root and every other root lies in the open left half-plane."
        ),
        consequence="A program that counts turns naively calls every free dyad marginal or unstable.",
        evidence=(
            Evidence("χ(0)", characteristic(0.0), "N²/m²"),
            Evidence("χ′(0) = k(b₁+b₂) + 2δk², not zero, so the root is simple", slope, "N²·s/m²"),
            Evidence("χ′(0) by a difference quotient", characteristic(step) / step, "N²·s/m²"),
            Evidence(
                f"largest real part of the other roots, axis {axis.name}",
                float(ts.spectral_abscissa(dyad, k, delay, axis=axis.index)),
                "1/s",
            ),
            Evidence("with the stiffness", k, "N/m"),
            Evidence("and the one-way delay", delay, "s"),
        ),
    )


def _equation_5_is_not_sufficient() -> Misprint:
    m1, b1, m2, b2 = 1.0, 1.0, 1.0, 10.0
    axis = free_axis(m1, b1, m2, b2)
    printed = axis.critical_stiffness("paper")
    k = 0.99 * printed
    lost = float(axis.maximum_delay(k))
    delay = 0.175
    roots = np.roots(paper.cubic_equation_8(m1, b1, m2, b2, k))
    positive = [r for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0]
    return Misprint(
        key="equation-5",
        where="Eq. 5 and the proof in Appendix A1",
        printed="Delay-independent stable if k ≤ (b₁²+b₂²)/(2(m₁+m₂)); a positive root of F needs F(0) < 0.",
        true=(
            "The bound only says F(0) ≥ 0. F can still have two positive roots, so the "
            "converse in the proof is "
            "false. Delay-independent if and only if F has no positive root. For equal "
            "masses Eq. 5 fails as soon as one damping exceeds the other by the factor 1+√2."
        ),
        consequence="A spring that the paper calls safe at every delay makes unequal robots unstable.",
        evidence=(
            Evidence("masses of both robots", m1, "kg"),
            Evidence("damping of robot 1", b1, "N·s/m"),
            Evidence("damping of robot 2", b2, "N·s/m"),
            Evidence("critical stiffness by Eq. 5", printed, "N/m"),
            Evidence("exact critical stiffness", axis.critical_stiffness(), "N/m"),
            Evidence("at the stiffness 0.99 of Eq. 5", k, "N/m"),
            Evidence("F has positive roots, in number", float(len(positive)), "1"),
            Evidence("stability is lost at the delay", lost, "s"),
            Evidence("at the longer delay", delay, "s"),
            Evidence(
                "the largest real part of a root is",
                float(ts.spectral_abscissa(_dyad(m1, b1, m2, b2), k, delay)),
                "1/s",
            ),
            Evidence("damping ratio from which Eq. 5 fails, equal masses", 1 + math.sqrt(2), "1"),
        ),
    )


#: Masses (kg), dampings (N·s/m) and stiffness (N/m) of a dyad that is stable again at longer delay.
RETURNING = ((0.97670822, 2.15372614, 0.30379312, 4.59594729), 9.174736188)


def _stability_returns() -> Misprint:
    parameters, k = RETURNING
    axis = free_axis(*parameters)
    intervals = axis.stable_delays(k, 3.0)
    (_, lost), (back, lost_again) = intervals[0], intervals[1]
    between, again = 0.5 * (lost + back), 0.5 * (back + lost_again)
    dyad = _dyad(*parameters)
    return Misprint(
        key="equation-4",
        where="Section II below Eq. 3, Eqs. 4 and 6",
        printed="The system becomes unstable when δ ≥ δₘ.",
        true=(
            "δₘ ends the first stable interval. F can have up to three positive roots, "
            "some of which lead roots back, so the stable delays are a union of intervals."
        ),
        consequence="A dyad that is stable at its actual delay is refused.",
        evidence=(
            Evidence("first stable interval ends at", lost, "s"),
            Evidence("stability returns at", back, "s"),
            Evidence("and is lost again at", lost_again, "s"),
            Evidence(
                "largest real part of a root between the intervals",
                float(ts.spectral_abscissa(dyad, k, between)),
                "1/s",
            ),
            Evidence(
                "largest real part inside the second interval",
                float(ts.spectral_abscissa(dyad, k, again)),
                "1/s",
            ),
            Evidence("with the stiffness", k, "N/m"),
            Evidence("below which no delay should matter, by Eq. 5", axis.critical_stiffness("paper"), "N/m"),
        ),
    )


def _sign_in_equation_9(base: Axis) -> Misprint:
    # Two identical robots at twice the critical stiffness have B = 0 exactly; here without rounding.
    exact = free_axis(1.0, 2.0, 1.0, 2.0)
    k = 4.0
    frequency = math.sqrt((2 * 1.0 * k - 2.0**2) / 1.0**2)
    k_base = 2 * base.critical_stiffness()
    at_base = base.crossings(k_base)[0]["frequency"]
    return Misprint(
        key="equation-9",
        where="Eq. 9",
        printed="z = sign(B) √(A₁A₂)/k with B = ω² − k(b₁+b₂)/(m₁b₂+m₂b₁)",
        true=(
            "At B = 0 the sign is 0 and so is z. This is no rare case: two identical "
            "robots at k = b²/m, twice the "
            "critical stiffness, have B = 0, and that is where the paper takes Δ. The delay is "
            "((−arg(P₁P₂/k²)) mod 2π)/(2ω), which needs no sign."
        ),
        consequence=(
            "At the paper's own base point the printed formula returns zero, or is decided by rounding."
        ),
        evidence=(
            Evidence(
                "B for m = 1 kg, b = 2 N·s/m, k = 4 N/m",
                paper.sign_of_equation_9(*exact.parameters, k, frequency),
                "rad²/s²",
            ),
            Evidence(
                "delay by the printed formula there",
                paper.delay_equation_9(*exact.parameters, k, frequency),
                "s",
            ),
            Evidence("delay in truth, π/(2ω)", float(exact.maximum_delay(k)), "s"),
            Evidence(
                "B/ω² for the base robot at 2K, rounding only",
                paper.sign_of_equation_9(*base.parameters, k_base, at_base) / at_base**2,
                "1",
            ),
            Evidence("Δ of the base robot in truth, πM/(2B)", float(base.maximum_delay(k_base)), "s"),
        ),
    )


def _less_or_equal(dyad: ts.Dyad, axis: Axis, k: float) -> Misprint:
    delay = float(axis.maximum_delay(k))
    roots = ts.characteristic_roots(dyad, k, delay, count=2, axis=axis.index)
    return Misprint(
        key="conjecture-2",
        where="Section III, conjecture 2",
        printed="The system is stable when k > kₘ and δ ≤ δₘ.",
        true=(
            "Only δ < δₘ: at δₘ itself a pair of roots lies on the imaginary axis, and an "
            "oscillation never ends."
        ),
        consequence="The marginal case is counted as stable; Section II says unstable (δ ≥ δₘ).",
        evidence=(
            Evidence(f"δₘ of axis {axis.name}", delay, "s"),
            Evidence(
                "real part of the rightmost pair there, 0 up to rounding", float(np.real(roots[0])), "1/s"
            ),
            Evidence("its frequency", float(abs(np.imag(roots[0]))), "rad/s"),
            Evidence("with the stiffness", k, "N/m"),
        ),
    )


def _loop_of_figure_3(base: Axis) -> Misprint:
    k = 2 * base.critical_stiffness()
    mass, damping = base.masses[0], base.dampings[0]
    frequency = np.linspace(0.0, 60.0, 6001)
    printed = paper.loop_in_figure_3(mass, damping, k, 2 * float(base.maximum_delay(k)), frequency)
    return Misprint(
        key="figure-3",
        where="Caption of Fig. 3",
        printed="L(s) = −k e^(−δs)/(P₁P₂)",
        true="L(s) = −k² e^(−2δs)/(P₁P₂), from Eq. 3",
        consequence="As printed L is not a pure number, and its locus comes nowhere near −1 at any delay.",
        evidence=(
            Evidence("largest |L| at 2K as printed", float(np.abs(printed).max()), "m/N"),
            Evidence("L(0) at 2K as printed", float(printed[0].real), "m/N"),
            Evidence("L(0) in truth", -1.0 * k**2 / k**2, "1"),
            Evidence("with the stiffness 2K", k, "N/m"),
        ),
    )


def _letters_of_section_3(base: Axis) -> Misprint:
    damping, mass = base.dampings[0], base.masses[0]
    stiffness = base.critical_stiffness()
    as_mass = float(ts.critical_stiffness(stiffness, damping, stiffness, damping, method="paper"))
    return Misprint(
        key="section-3-letters",
        where="Section III, second paragraph",
        printed="K = S(K, B, K, B) and Δ = D(K, B, K, B, 2K)",
        true="K = S(M, B, M, B) and Δ = D(M, B, M, B, 2K), as the caption of Fig. 3 has it",
        consequence="K would be defined by itself, a stiffness standing for a mass.",
        evidence=(
            Evidence("S(M, B, M, B)", stiffness, "N/m"),
            Evidence("S(K, B, K, B) with that K in the place of a mass in kg", as_mass, "N/m"),
            Evidence("M", mass, "kg"),
            Evidence("B", damping, "N·s/m"),
        ),
    )


def _numbers_of_the_robots(axes: list[Axis]) -> Misprint:
    swapped = [free_axis(a.masses[1], a.dampings[1], a.masses[0], a.dampings[0]) for a in axes]
    k = min(axis.critical_stiffness() for axis in axes)
    return Misprint(
        key="robot-numbers",
        where="Section IV-A, first sentence",
        printed="M₁, B₁ are those of H-MAN₂ and M₂, B₂ those of H-MAN₁.",
        true="Table III has it the other way round: M₁, B₁ belong to H-MAN₁. We follow Table III.",
        consequence=(
            "None for stability: exchanging the robots changes neither K nor Δ. It matters "
            "for who moves how far."
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


def _reference_delay(axes: list[Axis]) -> Misprint:
    table = paper.TABLE_III
    k = min(axis.critical_stiffness() for axis in axes)
    unrounded = min(float(axis.maximum_delay(2 * k)) for axis in axes)
    rounded = min(float(axis.maximum_delay(2 * table.reference_stiffness)) for axis in axes)
    return Misprint(
        key="reference-delay",
        where="Table III, Δ of both axes",
        printed="Δ_xy = 165 ms; Section IV-D and Fig. 8 use 84, 167 and 334 ms.",
        true=(
            "The unrounded K gives the delays of the experiment, K rounded to 36 N/m gives "
            "less. Neither gives 165 ms."
        ),
        consequence=(
            "Repeating the experiment from Table III sets delays that differ from those that were used."
        ),
        evidence=(
            Evidence("Δ_xy printed in Table III", table.reference_delay, "s"),
            Evidence("Δ_xy from the unrounded K", unrounded, "s"),
            Evidence("Δ_xy from K rounded to the printed value", rounded, "s"),
            Evidence("half of the unrounded Δ_xy (printed 84 ms)", 0.5 * unrounded, "s"),
            Evidence("half of Table III's", 0.5 * table.reference_delay, "s"),
            Evidence("unrounded K", k, "N/m"),
        ),
    )


def _figure_5h(axes: list[Axis], reference: float) -> Misprint:
    return Misprint(
        key="figure-5h",
        where="Section IV-A on Fig. 5(h)",
        printed="The response along y neither diverges nor converges, the one along x is strictly stable.",
        true="The caption is right, the text is not: x is marginal, y is stable.",
        consequence="The reader watches the wrong axis.",
        evidence=tuple(
            Evidence(
                f"maximum delay of axis {axis.name} at 2K", float(axis.maximum_delay(2 * reference)), "s"
            )
            for axis in axes
        ),
    )


def _figure_5j(axes: list[Axis], reference: float) -> Misprint:
    delay = 0.5 * min(float(axis.maximum_delay(2 * reference)) for axis in axes)
    dyad = ts.hman()
    return Misprint(
        key="figure-5j",
        where="Fig. 5(j), its caption and Section IV-A",
        printed="At 4K the system is unstable under all delays from 0.5Δ to 2Δ.",
        true="At 0.5Δ axis x is unstable but axis y is still stable.",
        consequence=(
            "The dyad as a whole is unstable, so the sentence holds; the plot along y does not show it."
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
                    float(ts.spectral_abscissa(dyad, 4 * reference, delay, axis=axis.index)),
                    "1/s",
                )
                for axis in axes
            ),
        ),
    )


def held_partner_growth(mass: float, damping: float, stiffness: float) -> tuple[float, float]:
    """How two identical robots grow apart when each sample is held until the distance turns.

    The partner's position in use is the one at the last hold, so the delay rises from 0 to the length
    of the hold and falls back: it is bounded, but not constant. Each robot then swings about the held
    position like m x'' + b x' + k x = k x_held, and the hold ends at the end of the swing.

    Parameters
    ----------
    mass, damping, stiffness
        kg, N·s/m and N/m; the stiffness above b²/(4m), so that the held robot overshoots.

    Returns
    -------
    hold, growth
        Length of each hold (s), and the factor by which the distance grows from hold to hold.
    """
    decay = damping / (2 * mass)
    turning = math.sqrt(stiffness / mass - decay**2)
    hold = math.pi / turning
    # From d at rest, drawn to -d: the overshoot beyond -d is 2 d exp(-decay hold).
    return hold, 1 + 2 * math.exp(-decay * hold)


def _constant_delay_only(base: Axis) -> Misprint:
    mass, damping = base.masses[0], base.dampings[0]
    k = base.critical_stiffness()
    hold, growth = held_partner_growth(mass, damping, k)
    near_hold, near_growth = held_partner_growth(mass, damping, 0.6 * k)
    return Misprint(
        key="constant-delay-only",
        where="Section VI",
        printed="k ≤ kₘ ensures robustness against unpredictable network delays.",
        true=(
            "Only against any constant delay. A delay that varies drives identical robots unstable at every "
            "k > b²/(4m), half of kₘ: it is enough that each position received is held "
            "until the robots have swung."
        ),
        consequence=(
            "A real network, whose delay varies, makes a spring unstable that the paper calls robust."
        ),
        evidence=(
            Evidence("kₘ of the base robot", k, "N/m"),
            Evidence("b²/(4m), safe on any network", damping**2 / (4 * mass), "N/m"),
            Evidence("at kₘ, each position held for", hold, "s"),
            Evidence("the distance grows per hold by the factor", growth, "1"),
            Evidence("which is a growth rate of", math.log(growth) / hold, "1/s"),
            Evidence("at 0.6 of kₘ, each position held for", near_hold, "s"),
            Evidence("the factor per hold is", near_growth, "1"),
            Evidence(
                "maximum constant delay at 0.6 of kₘ (none: no value)",
                finite_or_none(float(base.maximum_delay(0.6 * k))),
                "s",
            ),
        ),
    )


def _conjugate_polynomial(axis: Axis, k: float) -> Misprint:
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
        true="ā = (m₁s² − b₁s + k)(m₂s² − b₂s + k) z² − k²: the factor s² does not belong there.",
        consequence="Eliminating z from the printed pair does not give Eq. 8.",
        evidence=(
            Evidence("|ā| by its definition z²a(−s, 1/z)", float(abs(defined)), "N²/m²"),
            Evidence("|ā| without s²", float(abs(product * z**2 - k**2)), "N²/m²"),
            Evidence("|ā| as printed, in mixed units", float(abs(product * s**2 * z**2 - k**2)), "1"),
            Evidence("at s = jω with ω", 5.0, "rad/s"),
            Evidence("with the stiffness", k, "N/m"),
        ),
    )


def _equation_16(base: Axis) -> Misprint:
    k = 2 * base.critical_stiffness()
    mass, damping = base.masses[0], base.dampings[0]
    printed, _ = paper.identical_roots_equation_16(mass, damping, k)
    roots = np.roots(paper.cubic_equation_8(*base.parameters, k))
    pair = max(roots, key=lambda root: root.imag)
    corrected = printed * 4 * mass**4 / (2 * mass**2)
    return Misprint(
        key="equation-16",
        where="Eq. 16",
        printed="ξ₂,₃ = (η₁ ± √η₂)/(4m⁴)",
        true="ξ₂,₃ = (η₁ ± √η₂)/(2m²)",
        consequence="The printed values are no roots of F.",
        evidence=(
            Evidence("|ξ₂| of the base robot at 2K, root of Eq. 8", float(abs(pair)), "rad²/s²"),
            Evidence("with the prefactor 1/(2m²)", float(abs(corrected)), "rad²/s²"),
            Evidence("with the printed prefactor", float(abs(printed)), "rad²/s²"),
        ),
    )


def _table_2(base: Axis) -> Misprint:
    mass, damping = base.masses[0], base.dampings[0]
    true = (math.sqrt(2) - 1) * damping**2 / (2 * mass)
    printed = math.sqrt(2 * damping**2 - damping**2) / (2 * mass)

    def eta2(k: float) -> float:
        return damping**4 - 4 * mass**2 * k**2 - 4 * mass * damping**2 * k

    return Misprint(
        key="table-2",
        where="Table II and its footnote",
        printed="η₂ changes sign at k = √(2b²−b²)/(2m).",
        true="At k = (√2−1) b²/(2m): the root covers the 2 alone, and b² stands outside it.",
        consequence="The printed value is b/(2m), which is not even a stiffness.",
        evidence=(
            Evidence("k as it should be, base robot", true, "N/m"),
            Evidence("η₂/b⁴ there, 0 up to rounding", eta2(true) / damping**4, "1"),
            Evidence("k as printed, in 1/s", printed, "1/s"),
            Evidence("η₂/b⁴ there", eta2(printed) / damping**4, "1"),
        ),
    )
