"""Delay differential equations with any right-hand side, solved adaptively."""

from __future__ import annotations

import inspect
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

import telespring._core as core
from telespring._arrays import as_number, as_numbers, as_vector, as_whole_number, quoted_value
from telespring._core import DelaySolution
from telespring._errors import InvalidInput
from telespring._types import DelayValue, FloatArray, OptionValues

__all__ = ["DelaySolution", "solve_dde"]

RightHandSide: TypeAlias = Callable[[float, FloatArray, FloatArray], ArrayLike]
Delay: TypeAlias = float | Callable[[float], float] | Callable[[float, FloatArray], float]


def _delay_takes_state(function: Callable[..., Any], field: str) -> bool:
    """Whether a delay is a function of t and y rather than of t alone."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return False
    for arguments in ((0.0,), (0.0, 0.0)):
        try:
            signature.bind(*arguments)
        except TypeError:
            continue
        return len(arguments) == 2
    raise InvalidInput(
        field,
        repr(function),
        "a delay is a number, a function of t, or a function of t and y",
        "Give the function one or two arguments.",
    )


def _dde_delays(delays: Delay | Sequence[Delay]) -> list[DelayValue]:
    given: Iterable[Delay] = delays if isinstance(delays, Sequence | np.ndarray) else [delays]
    out: list[DelayValue] = []
    for i, delay in enumerate(given):
        if callable(delay):
            out.append((delay, _delay_takes_state(delay, f"delays[{i}]")))
        else:
            out.append(as_number(f"delays[{i}]", delay))
    return out


def solve_dde(
    rhs: RightHandSide,
    delays: Delay | Sequence[Delay],
    history: Callable[[float], ArrayLike] | ArrayLike,
    t_span: tuple[float, float],
    rtol: ArrayLike = 1e-6,
    atol: ArrayLike = 1e-9,
    *,
    initial: ArrayLike | None = None,
    breakpoints: Iterable[float | tuple[float, int]] = (),
    max_steps: int = 100_000,
    initial_step: float | None = None,
    max_step: float | None = None,
) -> DelaySolution:
    """Solve y'(t) = rhs(t, y(t), [y(t - τ1), y(t - τ2), ...]).

    Parameters
    ----------
    rhs : callable
        ``rhs(t, y, delayed)`` returns y'; ``delayed[j]`` is y at t - τ_j, a row per delay.
    delays : float, callable, or a sequence of them
        Each delay is a number, a function of t, or a function of t and y.
    history : callable or array_like
        ``history(t)`` gives y for t up to the start of the span; an array is a constant history.
    t_span : (float, float)
        Start and end.
    rtol, atol : float or array_like
        The local error of component i is held below ``atol[i] + rtol[i] * abs(y[i])``; rtol is at
        least 1e-13.
    initial : array_like, optional
        y at the start, where it differs from the end of the history.
    breakpoints : iterable of float or (float, int)
        Times at which the history, the right-hand side or a delay is not smooth, each alone (a
        switch, order 1) or with the lowest derivative of y that may jump there (0 is y itself,
        before the start only). Steps end on them exactly.
    max_steps : int
        Largest number of steps, rejected ones included.
    initial_step, max_step : float, optional
        First and longest step.

    Returns
    -------
    DelaySolution
        Dense output and the status of the computation; early termination is a status, not an exception.

    Raises
    ------
    InvalidInput
        If an argument is out of its range.
    Exception
        Exceptions of `rhs`, `history` or a delay pass through unchanged.

    See Also
    --------
    simulate : the linear dyad at constant delay, exact and much faster.

    Notes
    -----
    Explicit Runge-Kutta pair of Dormand and Prince with continuous extension, ending steps on break
    points, which travel through the delays; see [1]_, section II.17.

    References
    ----------
    .. [1] E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed.,
       1993.

    Examples
    --------
    y' = -y(t - 1) from y = 1 is 1 - t up to t = 1, and -1/2 at t = 2.

    >>> import telespring as ts
    >>> solution = ts.solve_dde(lambda t, y, delayed: -delayed[0], [1.0], [1.0], (0.0, 2.0), 1e-10, 1e-12)
    >>> solution.status
    'completed'
    >>> [round(float(value), 9) for value in solution([0.5, 2.0])[:, 0]]
    [0.5, -0.5]
    """
    start, end = _dde_span(t_span)
    if not callable(rhs):
        raise InvalidInput(
            "rhs", quoted_value(rhs), "a function of t, y and delayed is required", "Pass a callable."
        )
    if callable(history):
        past = history
        first = past(start) if initial is None else initial
        dimension = as_vector("history(t)" if initial is None else "initial", first).size
    else:
        constant = as_vector("history", history)
        dimension = constant.size

        def past(_: float) -> FloatArray:
            return constant

    options: OptionValues = {
        "rtol": _dde_tolerance("rtol", rtol),
        "atol": _dde_tolerance("atol", atol),
        "max_steps": as_whole_number("max_steps", max_steps),
        "initial_step": None if initial_step is None else as_number("initial_step", initial_step),
        "max_step": None if max_step is None else as_number("max_step", max_step),
        "breakpoints": _dde_breakpoints(breakpoints),
    }
    beginning = None if initial is None else as_vector("initial", initial).tolist()
    try:
        return core.solve_dde(rhs, _dde_delays(delays), past, dimension, beginning, (start, end), options)
    except InvalidInput as refused:
        if refused.field != "span":
            raise
        raise refused.at("t_span") from None


def _dde_span(t_span: Any) -> tuple[float, float]:
    try:
        start, end = t_span
    except (TypeError, ValueError):
        raise InvalidInput(
            "t_span",
            quoted_value(t_span),
            "the two times (start, end) are required",
            "Give both, the start first.",
        ) from None
    return as_number("t_span[0]", start), as_number("t_span[1]", end)


def _dde_tolerance(name: str, value: ArrayLike) -> float | list[float]:
    if as_numbers(name, value).ndim == 0:
        return as_number(name, value)
    components: list[float] = as_vector(name, value).tolist()
    return components


def _dde_breakpoints(breakpoints: Iterable[float | tuple[float, int]]) -> list[tuple[float, int]]:
    try:
        points = [(*point,) if isinstance(point, tuple) else (point, 1) for point in breakpoints]
        orders = [operator.index(order) for _, order in points]
        return [(as_number("", time), order) for (time, _), order in zip(points, orders, strict=True)]
    except (TypeError, ValueError):
        raise InvalidInput(
            "breakpoints",
            quoted_value(breakpoints),
            "times, or pairs of a time and the order of the derivative that may jump, are required",
            "Write them such as [1.0, (2.0, 0)].",
        ) from None
