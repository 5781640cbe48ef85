"""The formulas of Du, Kulkarni, Kager and Campolo as they are printed, misprints included.

Nothing is decided with them. They stand here so that the report can put the printed result beside
the true one. Equation and table numbers are the paper's.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "EXPERIMENT_DELAYS",
    "EXPERIMENT_STIFFNESSES",
    "TABLE_II",
    "TABLE_III",
    "PrintedTableIII",
    "cubic_equation_8",
    "delay_equation_9",
    "identical_roots_equation_16",
    "loop_in_figure_3",
    "sign_of_equation_9",
]


@dataclass(frozen=True)
class PrintedTableIII:
    """What Table III prints, in SI units."""

    base_mass: float = 0.8334
    base_damping: float = 7.7257
    base_stiffness: float = 36.0
    base_delay: float = 0.169
    reference_stiffness: float = 36.0
    reference_delay: float = 0.165


TABLE_III = PrintedTableIII()

#: Table II, a row per range of stiffness from small to large: sets of η₁, η₂, ξ₁, ξ₂ and ξ₃.
TABLE_II = (
    ("R-", "R+", "R-", "R-", "R-"),
    ("R-", "0", "R-", "R-", "R-"),
    ("R-", "R-", "R-", "C", "C"),
    ("0", "R-", "0", "C", "C"),
    ("R+", "R-", "R+", "C", "C"),
)

#: Section IV-D: stiffness in N/m and one-way delay in s of the experiment.
EXPERIMENT_STIFFNESSES = (18.0, 36.0, 71.0, 142.0)
EXPERIMENT_DELAYS = (0.0, 0.084, 0.167, 0.334)


def cubic_equation_8(m1: float, b1: float, m2: float, b2: float, k: float) -> NDArray[np.float64]:
    """Give the coefficients of F(xi), Eq. 8, highest power first; xi is the frequency squared."""
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
    """Give the quantity B of Eq. 9, (rad/s)^2, whose sign picks the square root.

    Without any damping its fraction is 0/0 and gives no sign: then 0.
    """
    if b1 == 0.0 and b2 == 0.0:
        return 0.0
    return frequency**2 - k * (b1 + b2) / (m1 * b2 + m2 * b1)


def delay_equation_9(m1: float, b1: float, m2: float, b2: float, k: float, frequency: float) -> float:
    """Give the delay (s) that Eqs. 6 and 9 give at a frequency (rad/s) where F vanishes."""
    a1 = m1 * frequency**2 - 1j * b1 * frequency - k
    a2 = m2 * frequency**2 - 1j * b2 * frequency - k
    z = float(np.sign(sign_of_equation_9(m1, b1, m2, b2, k, frequency))) * cmath.sqrt(a1 * a2) / k
    # Adding zero turns the -0.0 of a vanishing z into 0.0.
    return -cmath.phase(z) / frequency + 0.0


def loop_in_figure_3(
    mass: float, damping: float, k: float, delay: float, frequency: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Give the open loop that the caption of Fig. 3 prints, for two identical robots."""
    s = 1j * frequency
    return np.asarray(-k * np.exp(-delay * s) / (mass * s**2 + damping * s + k) ** 2)


def identical_roots_equation_16(mass: float, damping: float, k: float) -> tuple[complex, complex]:
    """Give the roots xi_2 and xi_3 that Eq. 16 prints, (rad/s)^2 if the prefactor were right."""
    eta1 = 2 * mass * k - damping**2
    root = cmath.sqrt(damping**4 - 4 * mass**2 * k**2 - 4 * mass * damping**2 * k)
    return (eta1 + root) / (4 * mass**4), (eta1 - root) / (4 * mass**4)
