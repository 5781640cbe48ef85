"""
Why no Padé approximation
=========================

Textbooks replace a delay by a ratio of polynomials. The ratio of low order overestimates the delay that
a dyad bears, so that what it calls stable is not.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import pade
from scipy.optimize import brentq

import telespring as ts

mass, damping, stiffness = 1.0, 4.0, 10.0


def taylor(delay: float, order: int) -> list[float]:
    """Return the series of exp(-2 delay s) up to twice the order."""
    terms = [1.0]
    for n in range(1, 2 * order + 1):
        terms.append(terms[-1] * -2 * delay / n)
    return terms


def rightmost(delay: float, order: int) -> float:
    """Return the largest real part of the approximated roots, without the one at 0."""
    above, below = pade(taylor(delay, order), order)
    side = np.poly1d([mass, damping, stiffness])
    roots = (side * side * below - stiffness**2 * above).roots
    return float(max(root.real for root in roots if abs(root) > 1e-6))


exact = ts.maximum_delay(mass, damping, mass, damping, stiffness)
orders = np.arange(2, 7)
approximated = [brentq(lambda delay, order=order: rightmost(delay, order), 0.5, 2.5) for order in orders]

figure, ax = plt.subplots(layout="constrained")
ax.plot(orders, approximated, "o-", label="Padé")
ax.axhline(exact, color="black", label="exact")
ax.set(xlabel="Order of the approximation of exp(−2δs)", ylabel="Maximum delay, s", xticks=orders)
ax.set_title(f"m = {mass:g} kg, b = {damping:g} N·s/m, k = {stiffness:g} N/m")
ax.legend()

# %%

print(f"exact {exact:.3f} s, order 2 {approximated[0]:.3f} s")
assert abs(exact - 1.107) < 1e-3
assert approximated[0] > 1.4 * exact  # 44 % too long
assert abs(approximated[-1] / exact - 1) < 0.01
