"""The truth that accuracies are measured against; shares no code and no method with the core."""

from __future__ import annotations

from collections.abc import Sequence

import mpmath
import numpy as np
from case import RATE, Case
from numpy.typing import NDArray

Positions = NDArray[np.float64]  # (robot, time)


def trajectories(cases: Sequence[Case], refine: int = 1) -> list[Positions]:
    """Positions by the matrix exponential of the stacked method of steps, in extended precision.

    With S the shift by one delay, y' = (A + B S) y; over one step h that divides the delay the
    exact solution is y(t + h) = sum over m of E_m y(t - m delay), where E_m is the coefficient of
    S^m in exp(h (A + B S)). The constant force is a fifth state that never changes. `refine` makes
    the steps so many times shorter: the two results differ by the rounding error of both.
    """
    found: list[Positions | None] = [None] * len(cases)
    for delay in {case.delay for case in cases}:
        chosen = [i for i, case in enumerate(cases) if case.delay == delay]
        for i, positions in zip(chosen, _same_delay([cases[i] for i in chosen], refine), strict=True):
            found[i] = positions
    return [positions for positions in found if positions is not None]


def _same_delay(cases: Sequence[Case], refine: int) -> list[Positions]:
    delay, count = cases[0].delay, cases[0].count
    # output period and delay are both whole numbers of steps
    per_output = next(
        n for n in range(refine, 64 * refine, refine) if abs((s := delay * RATE * n) - round(s)) < 1e-9
    )
    lag = round(delay * RATE * per_output)
    # the delay as it is stored, not as it is printed
    step = np.longdouble(delay) / lag if lag else 1 / (np.longdouble(RATE) * per_output)

    now = np.zeros((len(cases), 5, 5), dtype=np.longdouble)
    past = np.zeros_like(now)
    for i, case in enumerate(cases):
        m1, b1, m2, b2, k = (np.longdouble(x) for x in (case.m1, case.b1, case.m2, case.b2, case.k))
        now[i, 0, 1] = now[i, 2, 3] = 1
        now[i, 1, [0, 1, 4]] = -k / m1, -b1 / m1, 1 / m1
        now[i, 3, [2, 3, 4]] = -k / m2, -b2 / m2, -1 / m2
        past[i, 1, 2], past[i, 3, 0] = k / m1, k / m2
    if not lag:
        now, past = now + past, np.zeros_like(past)

    # Taylor series of the exponential, each term a polynomial in the shift
    terms = 26
    unit = np.broadcast_to(np.eye(5, dtype=np.longdouble), now.shape)
    term = np.zeros((terms, *now.shape), dtype=np.longdouble)
    term[0] = unit
    total = term.copy()
    for power in range(1, terms):
        shifted = np.zeros_like(term)
        shifted[1:] = np.einsum("cij,mcjk->mcik", past, term[:-1])
        term = (np.einsum("cij,mcjk->mcik", now, term) + shifted) * step / power
        total += term
    size = np.abs(total).max(axis=(1, 2, 3))
    total = total[: int(np.flatnonzero(size > 1e-24)[-1]) + 1]

    steps = (count - 1) * per_output
    y = np.zeros((steps + 1, len(cases), 5), dtype=np.longdouble)
    y[0, :, 4] = 1
    for n in range(steps):
        reach = min(len(total), n // lag + 1) if lag else 1
        states = y[n - lag * np.arange(reach)]
        y[n + 1] = np.einsum("mcij,mcj->ci", total[:reach], states)
    outputs = y[::per_output].astype(np.float64)
    return [np.ascontiguousarray(outputs[:, i, [0, 2]].T) for i in range(len(cases))]


def characteristic(case: Case, s: mpmath.mpc) -> mpmath.mpc:
    """The characteristic function divided by s, at the working precision of mpmath."""
    m1, b1, m2, b2, k = (mpmath.mpf(x) for x in (case.m1, case.b1, case.m2, case.b2, case.k))
    p1, p2 = m1 * s**2 + b1 * s + k, m2 * s**2 + b2 * s + k
    return (p1 * p2 - k**2 * mpmath.exp(-2 * mpmath.mpf(case.delay) * s)) / s


def refined_root(case: Case, start: complex) -> complex:
    """The root next to `start`, to 40 digits."""
    with mpmath.workdps(40):
        return complex(mpmath.findroot(lambda s: characteristic(case, s), mpmath.mpc(start)))


def squared_frequencies(
    m1: float, b1: float, m2: float, b2: float, k: float, digits: int = 50
) -> list[float]:
    """The positive roots of |P1 P2|² = k⁴ in ω², with the root at 0 divided out."""
    with mpmath.workdps(digits):
        m1, b1, m2, b2, k = (mpmath.mpf(x) for x in (m1, b1, m2, b2, k))
        # |P|² = m² y² + e y + k²
        e1, e2 = b1**2 - 2 * m1 * k, b2**2 - 2 * m2 * k
        cubic = [
            (m1 * m2) ** 2,
            m1**2 * e2 + m2**2 * e1,
            (m1**2 + m2**2) * k**2 + e1 * e2,
            (e1 + e2) * k**2,
        ]
        roots = mpmath.polyroots(cubic, maxsteps=500, extraprec=4 * digits)
        tiny = mpmath.mpf(10) ** (-digits // 3)
        return sorted(r.real for r in roots if abs(r.imag) < tiny * abs(r) and r.real > 0)


def maximum_delay(m1: float, b1: float, m2: float, b2: float, k: float) -> float:
    """The smallest delay over all crossings, s."""
    with mpmath.workdps(50):
        delays = []
        for y in squared_frequencies(m1, b1, m2, b2, k):
            w = mpmath.sqrt(y)
            p = (mpmath.mpc(k - m1 * y, b1 * w)) * (mpmath.mpc(k - m2 * y, b2 * w))
            delays.append((-mpmath.arg(p)) % (2 * mpmath.pi) / (2 * w))
        return float(min(delays, default=mpmath.inf))


def critical_stiffness(m1: float, b1: float, m2: float, b2: float) -> float:
    """The stiffness above which |P1 P2|² = k⁴ has a positive root, N/m, by bisection on the count.

    Bisection is right with free handles: every larger stiffness has such a root too.
    """
    with mpmath.workdps(50):
        # Eq. 5 is an upper bound, and half the smaller b²/m a lower one
        high = mpmath.mpf(b1**2 + b2**2) / (2 * (m1 + m2)) * (1 + mpmath.mpf(10) ** -20)
        low = min(mpmath.mpf(b1) ** 2 / (2 * m1), mpmath.mpf(b2) ** 2 / (2 * m2)) * (
            1 - mpmath.mpf(10) ** -20
        )
        while high - low > 1e-15 * high:
            middle = (low + high) / 2
            if squared_frequencies(m1, b1, m2, b2, middle):
                high = middle
            else:
                low = middle
        return float((low + high) / 2)


def unstable_roots(case: Case) -> int:
    """The number of roots right of the imaginary axis: every crossing up to the delay, with its sign."""
    args = (case.m1, case.b1, case.m2, case.b2, case.k)
    frequencies = squared_frequencies(*args)
    pairs = 0
    with mpmath.workdps(50):
        # the highest frequency leaves, and directions alternate
        for place, y in enumerate(reversed(frequencies)):
            w = mpmath.sqrt(y)
            p = mpmath.mpc(case.k - case.m1 * y, case.b1 * w) * mpmath.mpc(case.k - case.m2 * y, case.b2 * w)
            first = (-mpmath.arg(p)) % (2 * mpmath.pi) / (2 * w)
            times = max(0, int(mpmath.ceil((case.delay - first) * w / mpmath.pi)))
            pairs += times if place % 2 == 0 else -times
    return 2 * pairs
