"""The options of `identify` and `identify_logs`: their names, types and defaults."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from typing import Any, ParamSpec, TypedDict, TypeVar

from telespring._arrays import as_number
from telespring._errors import InvalidInput
from telespring._quantities import format_number
from telespring.identification.log_fit import FitOptions
from telespring.identification.results import METHODS, Method
from telespring.identification.terms import TERMS, ModelTerms

__all__ = ["DEFAULTS", "Settings", "fit_options", "with_settings"]

#: A longer lag of a force is no lag, s.
_LONGEST_DELAY = 0.2

_P = ParamSpec("_P")
_R = TypeVar("_R")


class Settings(TypedDict, total=False):
    """The options of `identify`, which says what they mean."""

    axes: Sequence[str] | None
    stiffness: bool | None
    coulomb: bool | None
    offset: bool | None
    drag: bool | None
    stiction: bool | None
    radius: float | None
    cutoff: float | None
    method: Method
    iterations: int
    force_delay: float | None


DEFAULTS: Settings = {
    "axes": None,
    "stiffness": None,
    "coulomb": None,
    "offset": None,
    "drag": None,
    "stiction": None,
    "radius": None,
    "cutoff": None,
    "method": "robust",
    "iterations": 1,
    "force_delay": None,
}


def with_settings(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Give a function that takes `**settings` their names and defaults, and refuse others as Python does."""
    own = inspect.signature(function)
    first = [p for p in own.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
    options = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=DEFAULTS[name],  # type: ignore[literal-required]
            annotation=annotation,
        )
        for name, annotation in Settings.__annotations__.items()
    ]
    signature = own.replace(parameters=[*first, *options])

    @wraps(function)
    def checked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        try:
            signature.bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(f"{function.__name__}() {error}") from None
        return function(*args, **kwargs)

    checked.__signature__ = signature  # type: ignore[attr-defined]
    return checked


def fit_options(given: Mapping[str, Any]) -> FitOptions:
    """Check the settings that say how a log is fitted."""
    settings: Mapping[str, Any] = DEFAULTS | given  # type: ignore[operator]
    method, iterations, radius = settings["method"], settings["iterations"], settings["radius"]
    _refuse_unknown_method(method, iterations)
    if radius is not None and not 0.0 < as_number("radius", radius) < float("inf"):
        raise InvalidInput(
            "radius", f"{radius:g}", "a radius above 0 m is required", "Give the metres of travel per radian."
        )
    lag = settings["force_delay"]
    lag = None if lag is None else as_number("force_delay", lag)
    if lag is not None and not abs(lag) <= _LONGEST_DELAY:
        raise InvalidInput(
            "force_delay",
            f"{format_number(lag, 6)} s",
            f"a lag between -{_LONGEST_DELAY:g} and {_LONGEST_DELAY:g} s is required",
            "Give it in seconds: 0.001 is one millisecond. Omit it to have it estimated.",
        )
    asked = {name: settings[name] for name in TERMS if name in settings}
    if method == "paper":
        # The paper's model: mass and damping, and what was asked for.
        asked = {name: bool(choice) for name, choice in asked.items()}
        lag = lag or 0.0
    return FitOptions(ModelTerms(asked, radius), method, iterations, lag)


def _refuse_unknown_method(method: str, iterations: int) -> None:
    if method not in METHODS:
        raise InvalidInput(
            "method",
            repr(method),
            'the methods are "robust", "ols" and "paper"',
            'Omit it for "robust".',
        )
    if not 1 <= iterations <= 10_000:
        raise InvalidInput("iterations", str(iterations), "1 to 10000 reweightings are allowed", "Use 1.")
    if iterations != 1 and method != "paper":
        raise InvalidInput(
            "iterations",
            str(iterations),
            f"only the paper's method has reweightings, but the method is {method!r}",
            'Omit it, or choose the method "paper".',
        )
