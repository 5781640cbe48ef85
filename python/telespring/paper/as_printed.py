"""Formulas of Du et al. (2025) as they are printed, misprints included.

No decision uses them: the report puts the printed result beside the true one. The printed criteria (Eqs. 5
to 9 as a whole) are `method="paper"` of `telespring.theory.criteria`. Equation numbers are the paper's.
"""

from __future__ import annotations

import cmath

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "cubic_equation_8",
    "delay_equation_9",
    "eta_equation_16",
    "identical_roots_equation_16",
    "loop_in_figure_3",
    "sign_of_equation_9",
]


def cubic_equation_8(m1: float, b1: float, m2: float, b2: float, k: float) -> NDArray[np.float64]:
    """Coefficients of the cubic F(ξ), Eq. 8, highest power first; ξ is the frequency squared."""
    a1, a2 = b1**2 - 2 * k * m1, b2**2 - 2 * k * m2
    return np.array(
        [
            m1**2 * m2**2,
            a1 * m2**2 + a2 * m1**2,
            a1 * a2 + k**2 * (m1**2 + m2**2),
            k**2 * (a1 + a2),
        ]
    )


def sign_of_equation_9(m1: float, b1: float, m2: float, b2: float, k: float, frequency: float) -> float:
    """Quantity B of Eq. 9, (rad/s)², whose sign selects the square root; 0 (for 0/0) without damping."""
    if b1 == 0.0 and b2 == 0.0:
        return 0.0
    return frequency**2 - k * (b1 + b2) / (m1 * b2 + m2 * b1)


def delay_equation_9(m1: float, b1: float, m2: float, b2: float, k: float, frequency: float) -> float:
    """One-way delay (s) as Eqs. 6 and 9 print it, at a frequency (rad/s) where F vanishes."""
    a1 = m1 * frequency**2 - 1j * b1 * frequency - k
    a2 = m2 * frequency**2 - 1j * b2 * frequency - k
    z = float(np.sign(sign_of_equation_9(m1, b1, m2, b2, k, frequency))) * cmath.sqrt(a1 * a2) / k
    # Adding zero turns the -0.0 of a vanishing z into 0.0.
    return -cmath.phase(z) / frequency + 0.0


def loop_in_figure_3(
    mass: float, damping: float, k: float, delay: float, frequency: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Open loop as the caption of Fig. 3 prints it, for two identical robots."""
    s = 1j * frequency
    return np.asarray(-k * np.exp(-delay * s) / (mass * s**2 + damping * s + k) ** 2)


def eta_equation_16(mass: float, damping: float, k: float) -> tuple[float, float]:
    """η₁ (N²·s²/m²) and η₂ (its square) of Eq. 16, for two identical robots; they are printed correctly."""
    eta1 = 2 * mass * k - damping**2
    eta2 = damping**4 - 4 * mass**2 * k**2 - 4 * mass * damping**2 * k
    return eta1, eta2


def identical_roots_equation_16(mass: float, damping: float, k: float) -> tuple[complex, complex]:
    """Roots ξ₂ and ξ₃ by Eq. 16 with its printed prefactor, for two identical robots."""
    eta1, eta2 = eta_equation_16(mass, damping, k)
    root = cmath.sqrt(eta2)
    return (eta1 + root) / (4 * mass**4), (eta1 - root) / (4 * mass**4)
