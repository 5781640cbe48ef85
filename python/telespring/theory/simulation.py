"""Simulation of the ideal continuous dyad at constant delay, exact for the linear model."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

import telespring._core as core
from telespring._arrays import as_number, as_numbers, as_vector, quoted_value
from telespring._errors import ApproximationWarning, InvalidInput
from telespring._types import Delay, FloatArray, SimulationStatus

if TYPE_CHECKING:
    import xarray as xr

    from telespring.model import Dyad

__all__ = ["Sampled", "Signal", "Sine", "Trajectory", "simulate", "simulate_array"]


@dataclass(frozen=True)
class Sine:
    """A sine of time: amplitude · sin(angular_frequency · t + phase).

    Parameters
    ----------
    amplitude : float
        N as a force.
    angular_frequency : float
        rad/s.
    phase : float
        At t = 0, rad.
    """

    amplitude: float
    angular_frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "angular_frequency", "phase"):
            object.__setattr__(self, name, as_number(name, getattr(self, name)))


@dataclass(frozen=True, eq=False)
class Sampled:
    """A signal sampled at t = i/rate, i = 0, 1, ...; the last value is held.

    Parameters
    ----------
    values : array_like
        Samples, N as a force.
    rate : float
        Samples per second, Hz.
    hold : {"linear", "zero"}
        Straight lines between samples, or each value held until the next (what a digital controller
        applies).
    """

    values: FloatArray
    rate: float
    hold: Literal["linear", "zero"] = "linear"

    def __init__(self, values: ArrayLike, rate: float, hold: Literal["linear", "zero"] = "linear") -> None:
        object.__setattr__(self, "values", np.ascontiguousarray(as_numbers("values", values)).reshape(-1))
        object.__setattr__(self, "rate", as_number("rate", rate))
        object.__setattr__(self, "hold", hold)


@dataclass(frozen=True)
class Signal:
    """A function of time that jumps or bends at declared times.

    Parameters
    ----------
    function : callable
        ``function(t)`` with t in s.
    breakpoints : iterable of float
        Times at which it is not smooth, s.
    """

    function: Callable[[float], float]
    breakpoints: tuple[float, ...] = ()

    def __init__(self, function: Callable[[float], float], breakpoints: Iterable[float] = ()) -> None:
        if not callable(function):
            raise InvalidInput(
                "function", quoted_value(function), "a function of time is required", "Pass a callable."
            )
        object.__setattr__(self, "function", function)
        given: Any = breakpoints
        times = list(given) if isinstance(given, Iterable) else given
        object.__setattr__(self, "breakpoints", tuple(as_vector("breakpoints", times).tolist()))


Force: TypeAlias = float | Sine | Sequence[Sine] | Sampled | Signal | Callable[[float], float]
Past: TypeAlias = float | tuple[float, float] | Signal | Callable[[float], float]


class Trajectory(NamedTuple):
    """A simulation as arrays.

    Attributes
    ----------
    time : ndarray
        s.
    position, velocity : ndarray
        m and m/s, (time, robot, axis); velocity is None unless requested.
    diverged_at : tuple of float or None
        Per axis the time, s, at which a position exceeded 1e12 m, or None. All arrays end before the first
        of these.
    force_error, history_error : ndarray
        Approximation error of functions of time, N and m, (robot, axis): the largest average over 10 ms of
        the distance from the function; 0 for all others.
    status : str
        "completed", "diverged", or "not resolved" if such an error exceeds 1e-9 of the largest value.
    """

    time: FloatArray
    position: FloatArray
    velocity: FloatArray | None
    diverged_at: tuple[float | None, ...]
    force_error: FloatArray
    history_error: FloatArray
    status: SimulationStatus


def simulate_array(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    forces: Sequence[Sequence[Force]],
    duration: float,
    rate: float = 1000.0,
    history: Sequence[Sequence[Past]] | None = None,
    *,
    velocities: bool = True,
) -> Trajectory:
    """Simulate the dyad and return plain arrays; `simulate` returns the same with labels and units.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward); never rounded to a sample.
    forces : nested sequence
        ``forces[robot][axis]``, as in `simulate`.
    duration : float
        s.
    rate : float
        Outputs per second, Hz; accuracy does not depend on it.
    history : nested sequence, optional
        ``history[robot][axis]``, as in `simulate`.
    velocities : bool
        Whether to return velocities too.

    Returns
    -------
    Trajectory
        Views of (robot, axis, time) blocks, so that one axis of one robot is contiguous.

    Raises
    ------
    InvalidInput
        If a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> push = [[1.0, 0.0], [-1.0, 0.0]]
    >>> ts.simulate_array(ts.hman(), 71.2, 0.167, push, 10.0).position.shape
    (10001, 2, 2)
    """
    position, velocity, diverged, force_fit, history_fit = core.simulate(
        dyad,
        stiffness,
        delay,
        _forces_or_history_by_robot("forces", forces),
        duration,
        rate,
        None if history is None else _forces_or_history_by_robot("history", history),
        velocities,
    )
    time = np.arange(position.shape[2]) / rate
    divergences = [at for at in diverged if at is not None]
    if divergences:
        time = time[time < min(divergences)]
    kept = slice(0, len(time))
    return Trajectory(
        time,
        position.transpose(2, 0, 1)[kept],
        None if velocity is None else velocity.transpose(2, 0, 1)[kept],
        tuple(diverged),
        np.array(force_fit[0]).T,
        np.array(history_fit[0]).T,
        _status(divergences, {"force": force_fit, "history": history_fit}),
    )


def _status(
    divergences: list[float], fits: dict[Literal["force", "history"], tuple[list[list[float]], bool]]
) -> SimulationStatus:
    unresolved = [signal for signal, (_, is_resolved) in fits.items() if not is_resolved]
    for signal in unresolved:
        errors, _ = fits[signal]
        warnings.warn(
            f"a {signal} is approximated only to {np.max(errors):.1e} {'N' if signal == 'force' else 'm'} "
            f"({signal}_error): give a Signal with the times at which it is not smooth, or a Sampled signal",
            ApproximationWarning,
            stacklevel=4,
        )
    return "diverged" if divergences else "not resolved" if unresolved else "completed"


def _forces_or_history_by_robot(name: str, values: Sequence[Sequence[Any]]) -> list[list[Any]]:
    try:
        return [list(robot) for robot in values]
    except TypeError:
        raise InvalidInput(
            name,
            repr(values),
            "two lists are required, one per robot, each with one entry per axis",
            "Write them as [[robot 1's axes], [robot 2's axes]].",
        ) from None


def simulate(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    forces: Sequence[Sequence[Force]],
    duration: float,
    rate: float = 1000.0,
    history: Sequence[Sequence[Past]] | None = None,
) -> xr.Dataset:
    """Simulate the ideal continuous dyad under given forces.

    Parameters
    ----------
    dyad : Dyad
        Robots and operators.
    stiffness : float
        Stiffness of the virtual spring, N/m.
    delay : float or (float, float)
        One-way delay, s, or the pair (forward, backward); never rounded to a sample.
    forces : nested sequence
        ``forces[robot][axis]``, N: a number (a step at t = 0), a `Sine` or a list of them (their
        sum), a `Sampled` signal, or a function of time, as `Signal` if it jumps or bends.
        Functions are approximated by polynomials; how far is in ``force_error``. Jumps and kinks are
        found, if slowly; a feature shorter than 1 ms (a millionth of a duration above 1000 s) can be missed
        unless a breakpoint is beside it.
    duration : float
        s.
    rate : float
        Outputs per second, Hz; accuracy does not depend on it.
    history : nested sequence, optional
        ``history[robot][axis]``, m, for t <= 0: a number (at rest there), a pair (position, velocity)
        (at rest until it starts with that velocity), or a function of time. At rest at 0 if absent.

    Returns
    -------
    xarray.Dataset
        ``position`` (m) and ``velocity`` (m/s) over (time, robot, axis), ``force_error`` (N),
        ``history_error`` (m) over (robot, axis). ``attrs["status"]`` is "completed", "diverged" (then
        ``attrs["diverged_at"]`` is the time, s, and the outputs end before it) or "not resolved" (an
        error of a function exceeds 1e-9 of its largest value).

    Raises
    ------
    InvalidInput
        If a value is out of its range, or a function returns another value when called again.

    Warns
    -----
    ApproximationWarning
        If the status would be "not resolved".

    Notes
    -----
    Taylor series on steps that divide the delay: relative error below 1e-11 for steps, sines and
    sampled signals. A function is followed to 1e-13 of its largest value, or to its own rounding.

    Examples
    --------
    Two people push against each other with 1 N along x.

    >>> import telespring as ts
    >>> result = ts.simulate(ts.hman(), 71.2, 0.05, [[1.0, 0.0], [-1.0, 0.0]], duration=10.0)
    >>> result.position.sel(time=10.0, axis="x").values.round(3).tolist()
    [0.007, -0.007]
    >>> result.attrs["status"], result.position.attrs["units"]
    ('completed', 'm')
    """
    import xarray as xr

    trajectory = simulate_array(dyad, stiffness, delay, forces, duration, rate, history)
    assert trajectory.velocity is not None
    signal, pair = ("time", "robot", "axis"), ("robot", "axis")
    forward, backward = np.broadcast_to(delay, 2).tolist()
    attributes: dict[str, Any] = {
        "status": trajectory.status,
        "stiffness": stiffness,
        "delay_forward": forward,
        "delay_backward": backward,
    }
    divergences = [at for at in trajectory.diverged_at if at is not None]
    if divergences:
        attributes["diverged_at"] = min(divergences)
    return xr.Dataset(
        {
            "position": (signal, trajectory.position, {"units": "m"}),
            "velocity": (signal, trajectory.velocity, {"units": "m/s"}),
            "force_error": (pair, trajectory.force_error, {"units": "N"}),
            "history_error": (pair, trajectory.history_error, {"units": "m"}),
        },
        coords={
            "time": ("time", trajectory.time, {"units": "s"}),
            "robot": ("robot", [1, 2]),
            "axis": ("axis", dyad.axes),
        },
        attrs=attributes,
    )
