"""Stability criteria of one axis: robots as masses and dampings, the spring, the delay.

Every function takes the axis as numbers in SI units: masses `m1`, `m2` (kg) and viscous dampings
`b1`, `b2` (N·s/m) of robot and operator together, and as keywords what holds the handles to the
ground, `kh1` and `kh2` (N/m), and a damper beside the virtual spring, `c` (N·s/m). Delays are
one-way (the mean of both ways where they differ). Functions that return one number per axis
broadcast over arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, NamedTuple, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring import _core
from telespring._arrays import Columns, as_number, as_vector, over_arrays
from telespring._errors import InvalidInput
from telespring._types import Axes, AxisValues, FloatArray

__all__ = [
    "Crossing",
    "critical_stiffness",
    "crossings",
    "decay_stiffness",
    "maximum_delay",
    "maximum_stiffness",
    "minimum_damping",
    "stability_map",
    "stable_delays",
    "unstable_root_count",
]

Method: TypeAlias = Literal["exact", "paper"]
# what type checkers know to be one number, as opposed to anything array-like
Scalar: TypeAlias = float


class Crossing(NamedTuple):
    """A pair of roots on the imaginary axis.

    Attributes
    ----------
    delay : float
        The smallest one-way delay at which the pair is there, s; it is there again every π/frequency.
    frequency : float
        Where it meets the axis, rad/s.
    direction : int
        +1 where the pair leaves the stable half-plane as the delay grows, -1 where it returns, 0
        where it only touches.
    """

    delay: float
    frequency: float
    direction: int


def _axes(columns: Columns) -> Axes:
    return tuple(columns[name] for name in ("m1", "b1", "m2", "b2", "kh1", "kh2", "c"))  # type: ignore[return-value]


def _axis(
    m1: ArrayLike, b1: ArrayLike, m2: ArrayLike, b2: ArrayLike, kh1: ArrayLike, kh2: ArrayLike, c: ArrayLike
) -> AxisValues:
    return (
        as_number("m1", m1),
        as_number("b1", b1),
        as_number("m2", m2),
        as_number("b2", b2),
        as_number("kh1", kh1),
        as_number("kh2", kh2),
        as_number("c", c),
    )


def _float_or_array(
    compute: Callable[[Columns], FloatArray], arguments: Mapping[str, ArrayLike]
) -> float | FloatArray:
    found = over_arrays(compute, arguments)
    return found if found.ndim else float(found)


def _is_paper(method: str) -> bool:
    if method not in ("exact", "paper"):
        raise InvalidInput(
            "method", repr(method), 'the methods are "exact" and "paper"', 'Leave it away for "exact".'
        )
    return method == "paper"


@overload
def critical_stiffness(
    m1: Scalar,
    b1: Scalar,
    m2: Scalar,
    b2: Scalar,
    method: Method = "exact",
    *,
    kh1: Scalar = 0.0,
    kh2: Scalar = 0.0,
    c: Scalar = 0.0,
) -> float: ...
@overload
def critical_stiffness(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    method: Method = "exact",
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray: ...
def critical_stiffness(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    method: Method = "exact",
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray:
    """Stiffness below which no constant delay destabilises.

    Parameters
    ----------
    m1, b1, m2, b2 : array_like
        Masses, kg, and viscous dampings, N·s/m.
    method : {"exact", "paper"}
        The exact value, or Eq. 5 of [1]_, which is necessary but not sufficient and knows neither
        operators nor a coupling damper.
    kh1, kh2 : array_like
        Stiffness of each operator to the ground, N/m.
    c : array_like
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    float or ndarray
        Critical stiffness k_m, N/m: the infimum of all stiffnesses for which some delay is
        destabilising. inf where there is none.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named), shapes do not broadcast, or
        `method="paper"` is asked for what the paper does not cover.

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots", Eq. 5; what it misses:
       telespring/references/du2025.toml.

    Examples
    --------
    >>> import telespring as ts
    >>> round(ts.critical_stiffness(0.8334, 7.7257, 0.7776, 7.4208), 6)
    35.615988
    >>> ts.critical_stiffness(1.0, 1.0, 1.0, 10.0, method="paper")
    25.25
    >>> round(ts.critical_stiffness(1.0, 1.0, 1.0, 10.0), 6)
    9.461095
    """
    paper = _is_paper(method)
    return _float_or_array(
        lambda columns: _core.critical_stiffness(_axes(columns), paper),
        {"m1": m1, "b1": b1, "m2": m2, "b2": b2, "kh1": kh1, "kh2": kh2, "c": c},
    )


@overload
def maximum_delay(
    m1: Scalar,
    b1: Scalar,
    m2: Scalar,
    b2: Scalar,
    k: Scalar,
    method: Method = "exact",
    *,
    kh1: Scalar = 0.0,
    kh2: Scalar = 0.0,
    c: Scalar = 0.0,
) -> float: ...
@overload
def maximum_delay(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    method: Method = "exact",
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray: ...
def maximum_delay(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    method: Method = "exact",
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray:
    """Smallest constant one-way delay at which stability is lost.

    Parameters
    ----------
    m1, b1, m2, b2 : array_like
        Masses, kg, and viscous dampings, N·s/m.
    k : array_like
        Stiffness of the virtual spring, N/m.
    method : {"exact", "paper"}
        The exact value, or Eqs. 5 to 9 of [1]_.
    kh1, kh2 : array_like
        Stiffness of each operator to the ground, N/m.
    c : array_like
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    float or ndarray
        Maximum delay δ_m, s: every shorter delay is stable. inf where no constant delay
        destabilises, 0 where the axis is not stable even without delay.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named) or shapes do not broadcast.

    See Also
    --------
    stable_delays : stability can come back at a longer delay.

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots".

    Examples
    --------
    >>> import telespring as ts
    >>> hman_x = (0.8334, 7.7257, 0.7776, 7.4208)
    >>> round(ts.maximum_delay(*hman_x, 71.231976), 4)
    0.1672
    >>> ts.maximum_delay(*hman_x, [20.0, 30.0])
    array([inf, inf])
    """
    paper = _is_paper(method)
    return _float_or_array(
        lambda columns: _core.maximum_delay(_axes(columns), columns["k"], paper),
        {"m1": m1, "b1": b1, "m2": m2, "b2": b2, "kh1": kh1, "kh2": kh2, "c": c, "k": k},
    )


@overload
def maximum_stiffness(
    m1: Scalar,
    b1: Scalar,
    m2: Scalar,
    b2: Scalar,
    delay: Scalar,
    *,
    kh1: Scalar = 0.0,
    kh2: Scalar = 0.0,
    c: Scalar = 0.0,
) -> float: ...
@overload
def maximum_stiffness(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray: ...
def maximum_stiffness(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray:
    """Stiffness below which every stiffness is stable at this delay.

    Parameters
    ----------
    m1, b1, m2, b2 : array_like
        Masses, kg, and viscous dampings, N·s/m.
    delay : array_like
        One-way delay, s.
    kh1, kh2 : array_like
        Stiffness of each operator to the ground, N/m.
    c : array_like
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    float or ndarray
        sup{K : every 0 < k < K is stable at this delay}, N/m; inf at zero delay. Some dyads are
        stable again at a larger stiffness; that is not counted.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named) or shapes do not broadcast.

    Examples
    --------
    >>> import telespring as ts
    >>> hman_x = (0.8334, 7.7257, 0.7776, 7.4208)
    >>> k = ts.maximum_stiffness(*hman_x, 0.1)
    >>> round(ts.maximum_delay(*hman_x, k), 9)
    0.1
    """
    return _float_or_array(
        lambda columns: _core.maximum_stiffness(_axes(columns), columns["delay"]),
        {"m1": m1, "b1": b1, "m2": m2, "b2": b2, "kh1": kh1, "kh2": kh2, "c": c, "delay": delay},
    )


@overload
def minimum_damping(
    m1: Scalar,
    b1: Scalar,
    m2: Scalar,
    b2: Scalar,
    k: Scalar,
    delay: Scalar,
    *,
    kh1: Scalar = 0.0,
    kh2: Scalar = 0.0,
    c: Scalar = 0.0,
) -> float: ...
@overload
def minimum_damping(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray: ...
def minimum_damping(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> float | FloatArray:
    """Smallest damping, added equally to both robots, above which every larger one is stable.

    Parameters
    ----------
    m1, b1, m2, b2 : array_like
        Masses, kg, and viscous dampings, N·s/m.
    k : array_like
        Stiffness of the virtual spring, N/m.
    delay : array_like
        One-way delay, s.
    kh1, kh2 : array_like
        Stiffness of each operator to the ground, N/m.
    c : array_like
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    float or ndarray
        Damping to add to b1 and to b2, N·s/m; 0 where nothing needs to be added.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named) or shapes do not broadcast.

    Examples
    --------
    >>> import telespring as ts
    >>> added = ts.minimum_damping(0.8334, 7.7257, 0.7776, 7.4208, 142.0, 0.1)
    >>> round(ts.maximum_delay(0.8334, 7.7257 + added, 0.7776, 7.4208 + added, 142.0), 9)
    0.1
    """
    return _float_or_array(
        lambda columns: _core.minimum_damping(_axes(columns), columns["k"], columns["delay"]),
        {"m1": m1, "b1": b1, "m2": m2, "b2": b2, "kh1": kh1, "kh2": kh2, "c": c, "k": k, "delay": delay},
    )


def crossings(
    m1: float,
    b1: float,
    m2: float,
    b2: float,
    k: float,
    *,
    kh1: float = 0.0,
    kh2: float = 0.0,
    c: float = 0.0,
) -> list[Crossing]:
    """Every pair of roots that meets the imaginary axis at some delay.

    Parameters
    ----------
    m1, b1, m2, b2 : float
        Masses, kg, and viscous dampings, N·s/m.
    k : float
        Stiffness of the virtual spring, N/m.
    kh1, kh2 : float
        Stiffness of each operator to the ground, N/m.
    c : float
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    list of Crossing
        By delay (s), with frequency (rad/s) and direction; each recurs every π/frequency seconds of
        one-way delay. Empty where no constant delay destabilises.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> [first] = ts.crossings(0.8334, 7.7257, 0.7776, 7.4208, 71.231976)
    >>> round(first.delay, 4), first.direction
    (0.1672, 1)
    """
    found = _core.crossings(_axis(m1, b1, m2, b2, kh1, kh2, c), as_number("k", k))
    return [Crossing(*one) for one in found]


def stable_delays(
    m1: float,
    b1: float,
    m2: float,
    b2: float,
    k: float,
    horizon: float,
    *,
    kh1: float = 0.0,
    kh2: float = 0.0,
    c: float = 0.0,
) -> list[tuple[float, float]]:
    """All constant one-way delays up to a horizon at which the axis is stable.

    Parameters
    ----------
    m1, b1, m2, b2 : float
        Masses, kg, and viscous dampings, N·s/m.
    k : float
        Stiffness of the virtual spring, N/m.
    horizon : float
        Longest delay to look at, s.
    kh1, kh2 : float
        Stiffness of each operator to the ground, N/m.
    c : float
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    list of (float, float)
        Half-open intervals [start, end), s, ascending.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> dyad = (0.97670822, 2.15372614, 0.30379312, 4.59594729)
    >>> [(round(start, 4), round(end, 4)) for start, end in ts.stable_delays(*dyad, 9.174736188, 3.0)]
    [(0.0, 0.8508), (1.7738, 2.1128)]
    """
    return _core.stable_delays(
        _axis(m1, b1, m2, b2, kh1, kh2, c), as_number("k", k), as_number("horizon", horizon)
    )


def decay_stiffness(
    m1: float,
    b1: float,
    m2: float,
    b2: float,
    delay: float,
    decay_rate: float,
    *,
    kh1: float = 0.0,
    kh2: float = 0.0,
    c: float = 0.0,
) -> list[tuple[float, float]]:
    """Stiffnesses at which every motion but the common drift decays at a wanted rate.

    Too soft is slow, too stiff rings.

    Parameters
    ----------
    m1, b1, m2, b2 : float
        Masses, kg, and viscous dampings, N·s/m.
    delay : float
        One-way delay, s.
    decay_rate : float
        The rate σ, 1/s: all roots but s = 0 lie left of -σ.
    kh1, kh2 : float
        Stiffness of each operator to the ground, N/m.
    c : float
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    list of (float, float)
        Ranges of stiffness, N/m, ascending; empty where the rate cannot be had.

    Raises
    ------
    InvalidInput
        Where a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> [(soft, stiff)] = ts.decay_stiffness(0.8334, 7.7257, 0.7776, 7.4208, 0.05, 1.0)
    >>> 0.0 < soft < stiff
    True
    """
    return _core.decay_stiffness(
        _axis(m1, b1, m2, b2, kh1, kh2, c), as_number("delay", delay), as_number("decay_rate", decay_rate)
    )


@overload
def unstable_root_count(
    m1: Scalar,
    b1: Scalar,
    m2: Scalar,
    b2: Scalar,
    k: Scalar,
    delay: Scalar,
    *,
    kh1: Scalar = 0.0,
    kh2: Scalar = 0.0,
    c: Scalar = 0.0,
) -> int: ...
@overload
def unstable_root_count(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> int | NDArray[np.int64]: ...
def unstable_root_count(
    m1: ArrayLike,
    b1: ArrayLike,
    m2: ArrayLike,
    b2: ArrayLike,
    k: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: ArrayLike = 0.0,
    kh2: ArrayLike = 0.0,
    c: ArrayLike = 0.0,
) -> int | NDArray[np.int64]:
    """Count the characteristic roots with positive real part, by the crossings.

    Parameters
    ----------
    m1, b1, m2, b2 : array_like
        Masses, kg, and viscous dampings, N·s/m.
    k : array_like
        Stiffness of the virtual spring, N/m.
    delay : array_like
        One-way delay, s.
    kh1, kh2 : array_like
        Stiffness of each operator to the ground, N/m.
    c : array_like
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    int or ndarray of int
        The count; the rigid-body root s = 0 is not in it, nor is a root on the imaginary axis.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named) or shapes do not broadcast.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.unstable_root_count(0.8334, 7.7257, 0.7776, 7.4208, 71.231976, [0.167, 0.168])
    array([0, 2])
    """
    found = over_arrays(
        lambda columns: _core.unstable_root_count(_axes(columns), columns["k"], columns["delay"]),
        {"m1": m1, "b1": b1, "m2": m2, "b2": b2, "kh1": kh1, "kh2": kh2, "c": c, "k": k, "delay": delay},
    )
    return found if found.ndim else int(found)


def stability_map(
    m1: float,
    b1: float,
    m2: float,
    b2: float,
    k: ArrayLike,
    delay: ArrayLike,
    *,
    kh1: float = 0.0,
    kh2: float = 0.0,
    c: float = 0.0,
) -> NDArray[np.bool_]:
    """Whether one axis is stable, for every stiffness and every delay.

    Parameters
    ----------
    m1, b1, m2, b2 : float
        Masses, kg, and viscous dampings, N·s/m.
    k : array_like, (n,)
        Stiffnesses of the virtual spring, N/m.
    delay : array_like, (d,)
        One-way delays, s.
    kh1, kh2 : float
        Stiffness of each operator to the ground, N/m.
    c : float
        Damping beside the virtual spring, N·s/m.

    Returns
    -------
    ndarray of bool, (n, d)
        A row per stiffness, a column per delay.

    Raises
    ------
    InvalidInput
        Where a value is out of its range (the element is named) or `k` or `delay` has two dimensions.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.stability_map(0.8334, 7.7257, 0.7776, 7.4208, [30.0, 71.2], [0.1, 0.2])
    array([[ True,  True],
           [ True, False]])
    """
    axis = _axis(m1, b1, m2, b2, kh1, kh2, c)
    return _core.stability_map(axis, as_vector("k", k), as_vector("delay", delay))
