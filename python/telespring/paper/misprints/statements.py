"""Misprints in the paper's statements on stability."""

from __future__ import annotations

import math

import numpy as np

from telespring._json import finite_or_none
from telespring.model import Dyad, DyadAxis, Robot
from telespring.paper import as_printed
from telespring.paper.misprints.record import Evidence, Misprint
from telespring.references import read_reference
from telespring.theory.spectrum import characteristic_roots, spectral_abscissa

__all__ = [
    "RETURNING",
    "held_partner_growth",
    "wrong_statement_on_equation_5",
    "wrong_statement_on_maximum_delay",
    "wrong_statement_on_returning_stability",
    "wrong_statement_on_rigid_body_root",
    "wrong_statement_on_varying_delay",
]


def _misprint_example(key: str) -> tuple[tuple[float, float, float, float], float]:
    """Parameters m1, b1, m2, b2 and stiffness of the example that the references give for a misprint."""
    example = next(m["example"] for m in read_reference("du2025")["misprint"] if m["report"] == key)
    return (example["m1"], example["b1"], example["m2"], example["b2"]), example["k"]


#: Masses (kg), dampings (N·s/m) and stiffness (N/m) of a dyad that is stable again at a longer delay.
RETURNING = _misprint_example("equation-4")


def _misprint_example_dyad(m1: float, b1: float, m2: float, b2: float) -> Dyad:
    return Dyad(Robot([m1], [b1]), Robot([m2], [b2]))


def wrong_statement_on_rigid_body_root(dyad: Dyad, axis: DyadAxis, k: float) -> Misprint:
    """Show that s = 0 is a root, and a simple one."""
    m1, b1, m2, b2 = axis.parameters
    delay = 0.5 * float(axis.maximum_delay(k))
    slope = k * (b1 + b2) + 2 * delay * k**2
    step = 1e-6

    def characteristic(s: float) -> float:
        return (m1 * s**2 + b1 * s + k) * (m2 * s**2 + b2 * s + k) - k**2 * math.exp(-2 * delay * s)

    return Misprint(
        key="rigid-body-root",
        where="Section II, Fig. 3",
        printed="Stability is read directly from the encirclements of −1 by the Nyquist locus.",
        true=(
            "χ(0) = 0 for all parameters: the pair has a rigid-body mode. The locus passes through −1 "
            "at ω = 0, so the count is meaningless until that root is divided out. Stable means that s = 0 "
            "is a simple root and every other root lies in the open left half-plane."
        ),
        consequence="A program that just counts encirclements calls every free dyad marginal or unstable.",
        evidence=(
            Evidence("χ(0)", characteristic(0.0), "N²/m²"),
            Evidence("χ′(0) = k(b₁+b₂) + 2δk², not zero, so the root is simple", slope, "N²·s/m²"),
            Evidence("χ′(0) by a finite difference", characteristic(step) / step, "N²·s/m²"),
            Evidence(
                f"largest real part of the other roots, axis {axis.name}",
                float(spectral_abscissa(dyad, k, delay, axis=axis.index)),
                "1/s",
            ),
            Evidence("stiffness", k, "N/m"),
            Evidence("one-way delay", delay, "s"),
        ),
    )


def wrong_statement_on_equation_5() -> Misprint:
    """Show a dyad that is unstable at a stiffness that Eq. 5 allows."""
    m1, b1, m2, b2 = 1.0, 1.0, 1.0, 10.0
    axis = DyadAxis(m1, b1, m2, b2)
    printed = axis.critical_stiffness("paper")
    k = 0.99 * printed
    lost = float(axis.maximum_delay(k))
    delay = 0.175
    roots = np.roots(as_printed.cubic_equation_8(m1, b1, m2, b2, k))
    positive = [r for r in roots if abs(r.imag) < 1e-9 * abs(r) and r.real > 0]
    return Misprint(
        key="equation-5",
        where="Eq. 5 and the proof in Appendix A1",
        printed="Delay-independent stable if k ≤ (b₁²+b₂²)/(2(m₁+m₂)); a positive root of F needs F(0) < 0.",
        true=(
            "The bound only implies F(0) ≥ 0. F can still have two positive roots, so the converse in the "
            "proof is false. Stability is delay-independent if and only if F has no positive root. For equal "
            "masses Eq. 5 fails as soon as one damping is more than 1+√2 times the other."
        ),
        consequence="Unequal robots are unstable with a spring that the paper calls stable at every delay.",
        evidence=(
            Evidence("masses of both robots", m1, "kg"),
            Evidence("damping of robot 1", b1, "N·s/m"),
            Evidence("damping of robot 2", b2, "N·s/m"),
            Evidence("critical stiffness by Eq. 5", printed, "N/m"),
            Evidence("exact critical stiffness", axis.critical_stiffness(), "N/m"),
            Evidence("stiffness, 0.99 of Eq. 5", k, "N/m"),
            Evidence("number of positive roots of F", float(len(positive)), "1"),
            Evidence("stability is lost at a delay of", lost, "s"),
            Evidence("a longer delay", delay, "s"),
            Evidence(
                "largest real part of a root at that delay",
                float(spectral_abscissa(_misprint_example_dyad(m1, b1, m2, b2), k, delay)),
                "1/s",
            ),
            Evidence("damping ratio above which Eq. 5 fails, equal masses", 1 + math.sqrt(2), "1"),
        ),
    )


def wrong_statement_on_returning_stability() -> Misprint:
    """Show a dyad that is stable again at a longer delay."""
    parameters, k = RETURNING
    axis = DyadAxis(*parameters)
    intervals = axis.stable_delays(k, 3.0)
    (_, lost), (back, lost_again) = intervals[0], intervals[1]
    between, again = 0.5 * (lost + back), 0.5 * (back + lost_again)
    dyad = _misprint_example_dyad(*parameters)
    return Misprint(
        key="equation-4",
        where="Section II below Eq. 3, Eqs. 4 and 6",
        printed="The system becomes unstable when δ ≥ δₘ.",
        true=(
            "δₘ is only the end of the first stable interval. F can have up to three positive roots, and at "
            "some of them roots return to the left half-plane, so the stable delays are a union of intervals."
        ),
        consequence="A dyad that is stable at its actual delay is rejected.",
        evidence=(
            Evidence("end of the first stable interval", lost, "s"),
            Evidence("stability returns at", back, "s"),
            Evidence("stability is lost again at", lost_again, "s"),
            Evidence(
                "largest real part of a root between the intervals",
                float(spectral_abscissa(dyad, k, between)),
                "1/s",
            ),
            Evidence(
                "largest real part of a root in the second interval",
                float(spectral_abscissa(dyad, k, again)),
                "1/s",
            ),
            Evidence("stiffness", k, "N/m"),
            Evidence("critical stiffness by Eq. 5", axis.critical_stiffness("paper"), "N/m"),
        ),
    )


def wrong_statement_on_maximum_delay(dyad: Dyad, axis: DyadAxis, k: float) -> Misprint:
    """Show that a pair of roots lies on the imaginary axis at the maximum delay itself."""
    delay = float(axis.maximum_delay(k))
    roots = characteristic_roots(dyad, k, delay, count=2, axis=axis.index)
    return Misprint(
        key="conjecture-2",
        where="Section III, conjecture 2",
        printed="The system is stable when k > kₘ and δ ≤ δₘ.",
        true=(
            "Only for δ < δₘ: at δₘ itself a pair of roots lies on the imaginary axis, and the oscillation "
            "never decays."
        ),
        consequence="The marginal case counts as stable; Section II calls it unstable (δ ≥ δₘ).",
        evidence=(
            Evidence(f"δₘ of axis {axis.name}", delay, "s"),
            Evidence(
                "real part of the rightmost pair there, 0 up to rounding", float(np.real(roots[0])), "1/s"
            ),
            Evidence("its frequency", float(abs(np.imag(roots[0]))), "rad/s"),
            Evidence("stiffness", k, "N/m"),
        ),
    )


def held_partner_growth(mass: float, damping: float, stiffness: float) -> tuple[float, float]:
    """Return the length of each hold (s) and the growth of the distance per hold, of half a swing each.

    The delay then rises from 0 to the length of the hold and falls back to 0: it is bounded, but not
    constant. Each robot swings about the held position, m x'' + b x' + k x = k x_held, and the hold ends
    at the turning point of the swing. The stiffness must exceed b²/(4m), so that the robot overshoots.
    """
    decay = damping / (2 * mass)
    frequency = math.sqrt(stiffness / mass - decay**2)
    hold = math.pi / frequency
    # From d at rest, drawn to -d: the overshoot beyond -d is 2 d exp(-decay hold).
    return hold, 1 + 2 * math.exp(-decay * hold)


def wrong_statement_on_varying_delay(base: DyadAxis) -> Misprint:
    """Show the growth under a varying delay at a stiffness that every constant delay allows."""
    mass, damping = base.masses[0], base.dampings[0]
    k = base.critical_stiffness()
    hold, growth = held_partner_growth(mass, damping, k)
    near_hold, near_growth = held_partner_growth(mass, damping, 0.6 * k)
    return Misprint(
        key="constant-delay-only",
        where="Section VI",
        printed="k ≤ kₘ ensures robustness against unpredictable network delays.",
        true=(
            "Only against constant delays. A varying delay can destabilise identical robots at every "
            "k > b²/(4m), half of kₘ: it is enough to hold each received position until the robots have "
            "swung past it."
        ),
        consequence=(
            "On a real network, whose delay varies, a spring that the paper calls robust can be unstable."
        ),
        evidence=(
            Evidence("kₘ of the base robot", k, "N/m"),
            Evidence("b²/(4m), stable on any network", damping**2 / (4 * mass), "N/m"),
            Evidence("at kₘ, hold each position for", hold, "s"),
            Evidence("growth of the distance per hold", growth, "1"),
            Evidence("growth rate", math.log(growth) / hold, "1/s"),
            Evidence("at 0.6 of kₘ, hold each position for", near_hold, "s"),
            Evidence("growth of the distance per hold at 0.6 of kₘ", near_growth, "1"),
            Evidence(
                "maximum constant delay at 0.6 of kₘ",
                finite_or_none(float(base.maximum_delay(0.6 * k))),
                "s",
            ),
        ),
    )
