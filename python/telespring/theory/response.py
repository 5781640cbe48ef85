"""Frequency response of one axis: transfer matrix, magnitude and phase, and the Nyquist locus.

Everything is expressed in P_i(s) = m_i s² + (b_i + c) s + k + kh_i, the delays of both directions and
chi(s) = P1 P2 - (k + c s)² exp(-T s), T the round trip. Phases are continuous in frequency and start
from ω → 0, for any choice of frequencies.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

import telespring._core as core
from telespring._arrays import as_vector, unmasked
from telespring._core import FrequencyGrid, FrequencyMargin, FrequencyResponse, Nyquist, ResponseCurve
from telespring._errors import InvalidInput
from telespring._labelled import is_labelled
from telespring._types import ComplexArray, Delay

if TYPE_CHECKING:
    from telespring.model import Dyad

__all__ = [
    "FrequencyGrid",
    "FrequencyMargin",
    "FrequencyResponse",
    "Nyquist",
    "ResponseCurve",
    "frequency_grid",
    "frequency_response",
    "mobility_matrix",
    "nyquist",
    "open_loop",
    "partner_response",
    "transfer_matrix",
]

Convention: TypeAlias = Literal["exact", "paper"]


def _evaluate_over_s_plane(s: ArrayLike, compute: Callable[[ComplexArray], ComplexArray]) -> ComplexArray:
    try:
        given = np.asarray(unmasked(s))
        if given.dtype.kind not in "biufc":
            raise TypeError
        points = given.astype(np.complex128, copy=False)
    except (TypeError, ValueError):
        raise InvalidInput(
            "s",
            repr(s)[:60],
            "a complex number or an array of them is required",
            "Convert it, for instance with numpy.asarray(..., dtype=complex).",
        ) from None
    flat = compute(np.ascontiguousarray(points).reshape(-1))
    matrices: ComplexArray = flat.reshape((*points.shape, 2, 2))
    if not is_labelled(s):
        return matrices
    import xarray as xr

    labelled: Any = s.to_xarray() if hasattr(s, "to_xarray") else s
    robots = {"output": [1, 2], "input": [1, 2]}
    coords, dims = {**labelled.coords, **robots}, (*labelled.dims, "output", "input")
    return cast("ComplexArray", xr.DataArray(matrices, coords=coords, dims=dims))


def transfer_matrix(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    s: ArrayLike,
    axis: int | str = 0,
    convention: Convention = "exact",
) -> ComplexArray:
    """Positions of both robots under the forces on them, as a matrix of transfer functions.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    s : array_like of complex
        Points of the complex plane, 1/s.
    axis : int or str
        The axis by its index or its name.
    convention : {"exact", "paper"}
        X1/F1 = P2/chi and X2/F2 = P1/chi according to the equations of motion, or Eq. 2 of [1]_ as
        printed, with the diagonal swapped.

    Returns
    -------
    ndarray of complex, s.shape + (2, 2)
        [..., output, input], m/N; index 0 is robot 1.

    Raises
    ------
    InvalidInput
        If a value is out of its range or `s` is a pole (0 for free handles).

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots", Eq. 2.

    Examples
    --------
    >>> import telespring as ts
    >>> dyad = ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(2.0, 5.0))
    >>> s = 3j
    >>> matrix = ts.transfer_matrix(dyad, 10.0, 0.0, s)
    >>> ours = (s**2 + 4 * s + 10) * matrix[0, 0] - 10 * matrix[1, 0]  # robot 1 under a unit force
    >>> bool(abs(ours - 1) < 1e-14)
    True
    """
    of = (dyad, stiffness, delay, axis)
    return _evaluate_over_s_plane(s, lambda points: core.transfer_matrix(of, points, convention))


def mobility_matrix(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    s: ArrayLike,
    axis: int | str = 0,
) -> ComplexArray:
    """Velocities of both robots under the forces on them: s times `transfer_matrix`.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    s : array_like of complex
        Points of the complex plane, 1/s.
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    ndarray of complex, s.shape + (2, 2)
        [..., output, input], (m/s)/N. Finite at s = 0 for free handles too: both drift at
        1/(b1 + b2 + 2 δ k) under a unit force, δ the mean one-way delay.

    Raises
    ------
    InvalidInput
        If a value is out of its range or `s` is a pole.

    Examples
    --------
    >>> import telespring as ts
    >>> dyad = ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(2.0, 5.0))
    >>> drift = ts.mobility_matrix(dyad, 10.0, 0.1, 0.0)[0, 0]
    >>> bool(abs(drift - 1 / (4 + 5 + 2 * 0.1 * 10)) < 1e-15)
    True
    """
    of = (dyad, stiffness, delay, axis)
    return _evaluate_over_s_plane(s, lambda points: core.mobility_matrix(of, points))


def frequency_response(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    frequency: ArrayLike | None = None,
    axis: int | str = 0,
    convention: Convention = "exact",
) -> FrequencyResponse:
    """Transfer matrix, magnitude and phase over angular frequencies.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    frequency : array_like, (n,), optional
        Angular frequencies, rad/s, in any order. By default a `frequency_grid` from a tenth of the slowest
        to ten times the fastest of the rates b/m, √((k + kh)/m) and 1/T of both sides.
    axis : int or str
        The axis by its index or its name.
    convention : {"exact", "paper"}
        The diagonal according to the equations of motion, or as printed in Eq. 2 of [1]_.

    Returns
    -------
    FrequencyResponse
        Matrices, magnitudes and continuous phases.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a frequency is a pole (0 for free handles).

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots", Eq. 2.

    Examples
    --------
    >>> import telespring as ts
    >>> response = ts.frequency_response(ts.hman(), 71.2, 0.1, [1e-6, 5.0])
    >>> response.value.shape, round(float(response.phase[0, 0, 0]), 5)
    ((2, 2, 2), -1.5708)
    """
    of = (dyad, stiffness, delay, axis)
    if frequency is None:
        frequency = _default_grid(dyad, stiffness, delay, axis).frequency
    return core.frequency_response(of, as_vector("frequency", frequency), convention)


def _default_grid(dyad: Dyad, stiffness: float, delay: Delay, axis: int | str) -> FrequencyGrid:
    core.frequency_response((dyad, stiffness, delay, axis), np.ones(1), "exact")  # refuses what is wrong
    side = dyad.axis(axis)
    masses, dampings, ground = (np.array(v) for v in (side.masses, side.dampings, side.ground_stiffness))
    round_trip = float(np.broadcast_to(delay, 2).sum())
    rates = np.array([*(dampings / masses), *np.sqrt((stiffness + ground) / masses), round_trip])
    rates[-1] = 1.0 / round_trip if round_trip else 0.0
    rates = rates[rates > 0.0]
    return frequency_grid(dyad, stiffness, delay, 0.1 * rates.min(), 10.0 * rates.max(), axis)


def open_loop(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    frequency: ArrayLike | None = None,
    axis: int | str = 0,
) -> ResponseCurve:
    """Open loop L = -(k + c s)² exp(-T s)/(P1 P2) over angular frequencies.

    The locus of `nyquist` and of Fig. 3 of [1]_, whose caption lacks a factor k exp(-δ s). Its phase
    starts at +π; the critical phase is -π.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    frequency : array_like, (n,), optional
        Angular frequencies, rad/s; by default those of `frequency_response`.
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    ResponseCurve
        L, its magnitude and its continuous phase.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a frequency is a pole (an undamped side).

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots", Fig. 3.

    Examples
    --------
    >>> import telespring as ts
    >>> float(ts.open_loop(ts.hman(), 71.2, 0.167, 0.0).value[0].real)  # free handles
    -1.0
    """
    if frequency is None:
        frequency = _default_grid(dyad, stiffness, delay, axis).frequency
    return core.open_loop((dyad, stiffness, delay, axis), as_vector("frequency", frequency))


def partner_response(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    frequency: ArrayLike | None = None,
    axis: int | str = 0,
    robot: int = 0,
) -> ResponseCurve:
    """Response of one robot to its partner: X_i/X_j = (k + c s) exp(-s δ)/P_i, δ the delay towards it.

    Magnitude ratio and phase shift as in Fig. 4 of [1]_. For identical robots its square is -L, so
    that it exceeds 1 exactly where the stiffness exceeds b²/(2m).

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    frequency : array_like, (n,), optional
        Angular frequencies, rad/s; by default those of `frequency_response`.
    axis : int or str
        The axis by its index or its name.
    robot : int
        Which robot follows: 0 is robot 1, 1 is robot 2.

    Returns
    -------
    ResponseCurve
        The ratio, its magnitude and its continuous phase.

    Raises
    ------
    InvalidInput
        If a value is out of its range or a frequency is a pole (an undamped side).

    References
    ----------
    .. [1] M. Du, S. R. Kulkarni, S. Kager, D. Campolo, "Stability Criteria and Motor Performance in
       Delayed Haptic Dyadic Interactions Mediated by Robots", Fig. 4.

    Examples
    --------
    >>> import telespring as ts
    >>> pair = ts.Dyad(ts.Robot(1.0, 4.0), ts.Robot(1.0, 4.0))
    >>> curve = ts.partner_response(pair, 16.0, 0.1, [0.0, 2.8])  # k = b²/m
    >>> float(curve.magnitude[0]), bool(curve.magnitude[1] > 1)
    (1.0, True)
    """
    of = (dyad, stiffness, delay, axis)
    if frequency is None:
        frequency = _default_grid(dyad, stiffness, delay, axis).frequency
    return core.partner_response(of, robot, as_vector("frequency", frequency))


def frequency_grid(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    low: float,
    high: float,
    axis: int | str = 0,
    resolution: float = 0.1,
    limit: int = 100_000,
) -> FrequencyGrid:
    """Angular frequencies dense enough that every response is smooth from point to point.

    Between neighbours no factor of the responses changes by more than about `resolution`, so that no
    resonance, however narrow, falls between two points.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    low, high : float
        Both ends, rad/s, 0 ≤ low < high.
    axis : int or str
        The axis by its index or its name.
    resolution : float
        Largest relative change between neighbours, and largest turn of the round trip, rad; 1e-3 to 1.
    limit : int
        Largest number of points.

    Returns
    -------
    FrequencyGrid
        The frequencies and whether they meet the resolution.

    Raises
    ------
    InvalidInput
        If a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> grid = ts.frequency_grid(ts.hman(), 71.2, 0.167, 0.1, 100.0)
    >>> grid.status, float(grid.frequency[0]), float(grid.frequency[-1])
    ('resolved', 0.1, 100.0)
    """
    return core.frequency_grid((dyad, stiffness, delay, axis), low, high, resolution, limit)


def nyquist(dyad: Dyad, stiffness: float, delay: Delay, axis: int | str = 0) -> Nyquist:
    """Nyquist locus, its encirclements of -1 and the margins.

    With free handles the locus starts at -1 for all parameters, so that counting encirclements directly is
    undefined. Here the rigid-body root is divided out, and the count is proven by following the argument of
    the characteristic function instead of the plotted points.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward).
    axis : int or str
        The axis by its index or its name.

    Returns
    -------
    Nyquist
        Locus, count, margins, and the status of the count.

    Raises
    ------
    InvalidInput
        If a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> nyquist = ts.nyquist(ts.hman(), 71.231976, 0.15)
    >>> nyquist.stable, round(0.15 + nyquist.delay_margin.value, 6)
    (True, 0.167186)
    >>> ts.nyquist(ts.hman(), 71.231976, 0.18).encirclements
    2
    """
    return core.nyquist((dyad, stiffness, delay, axis))
