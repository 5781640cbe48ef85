"""Least-squares fits of a hypothesis to cells of the table, with profiles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from telespring._types import FloatArray
from telespring.paper.calibration.hypotheses import Hypothesis

__all__ = ["Fit", "Profile", "Search", "interval_threshold"]

#: Mean errors (point, condition, robot), m, for values of a hypothesis's parameters at several points.
Model = Callable[[FloatArray], FloatArray]

#: Larger errors, m, count as this: an unstable dyad has no bound, and one that is stable must always fit
#: better.
_CAP = 1.0

#: Points spread over the searched ranges, and how many of the best among them are improved.
_SPREAD = 128
_STARTS = 3
#: Step of the derivatives and tolerance of the search, in shares of a parameter's range.
_STEP = 1e-3
_TOLERANCE = 1e-4
#: A profile's first step, in shares of the range; how near the end of an interval its last step comes, in
#: shares of the threshold's root; and its most steps to either side.
_FIRST_STEP = 0.02
_NEAR = 0.05
_WALK = 8
_ROUNDS = 30


@dataclass(frozen=True)
class Profile:
    """Sum of squares along one parameter, the others free, as a rise of the deviance.

    Attributes
    ----------
    values
        Of the parameter, SI units.
    rise
        n log(S/S₀), S the least sum of squares there and S₀ the overall one, up to the end of the interval.
    interval
        Where the rise stays below the threshold of 95 %, within the searched range.
    open_below, open_above
        Whether the interval reaches an end of that range.
    """

    values: FloatArray
    rise: FloatArray
    interval: tuple[float, float]
    open_below: bool
    open_above: bool


@dataclass(frozen=True)
class _Walk:
    """Places visited on one side of an optimum, roots of the rise there, and where the interval ends."""

    places: list[float]
    roots: list[float]
    end: float
    open: bool


@dataclass(frozen=True)
class Fit:
    """The best values of a hypothesis's parameters, SI units, and the errors there, (condition, robot), m."""

    values: FloatArray
    errors: FloatArray


def interval_threshold(cells: int, parameters: int, level: float = 0.95) -> float:
    """Rise of n log(sum of squares) up to which a value lies inside its profile interval.

    With one unknown variance the likelihood ratio of one parameter of a linear model is a function of
    Student's t, and n log(1 + t²/ν) with ν = n less the number of parameters is exact.

    Examples
    --------
    >>> round(interval_threshold(34, 4), 2), round(interval_threshold(10_000, 4), 2)
    (4.43, 3.84)
    """
    from scipy.stats import t

    freedom = cells - parameters
    return float(cells * math.log1p(float(t.ppf(0.5 + level / 2, freedom)) ** 2 / freedom))


class Search:
    """Fits one hypothesis to any cells of the table; the same input gives the same output.

    Parameters
    ----------
    hypothesis
        Its parameters and their ranges.
    model
        The errors of the whole table.
    measured
        The published errors (condition, robot), m.
    model_near
        The errors at several points near the first argument, for derivatives, if there is a faster way to
        them than `model`.
    """

    def __init__(
        self,
        hypothesis: Hypothesis,
        model: Model,
        measured: FloatArray,
        model_near: Callable[[FloatArray, FloatArray], FloatArray] | None = None,
    ) -> None:
        from scipy.stats import qmc

        self._hypothesis, self._model, self._measured = hypothesis, model, measured
        self._model_near = model_near if model_near is not None else lambda _, moved: model(moved)
        self._low, self._span = hypothesis.low, hypothesis.high - hypothesis.low
        count = len(hypothesis.parameters)
        self._spread = qmc.Sobol(count, seed=1).random_base2((_SPREAD - 1).bit_length())

    @cached_property
    def _found(self) -> FloatArray:
        """The errors at the points of the spread."""
        return self._predict(self._spread)

    def fit(self, rows: Sequence[int], near: Sequence[FloatArray] = (), starts: int = _STARTS) -> Fit:
        """Fit to these conditions only, from the best points of the spread and from these values."""
        rows = list(rows)
        squares = np.sum((self._found[:, rows] - self._measured[rows]) ** 2, axis=(1, 2))
        first = [(values - self._low) / self._span for values in near]
        first += [self._spread[i] for i in np.argsort(squares, kind="stable")[:starts]]
        free = list(range(len(self._low)))
        found = [self._improve(start, free, rows) for start in first]
        point, _ = min(found, key=lambda each: each[1])
        values = self._low + point * self._span
        return Fit(values, self._model(values[None])[0])

    def profiles(
        self, fit: Fit, rows: Sequence[int], names: Sequence[str] | None = None
    ) -> dict[str, Profile]:
        """Return the profiles around a fit to these conditions, of all parameters or those named."""
        best = (fit.values - self._low) / self._span
        return {
            parameter.name: self._profile(i, best, list(rows))
            for i, parameter in enumerate(self._hypothesis.parameters)
            if names is None or parameter.name in names
        }

    def _profile(self, i: int, best: FloatArray, rows: list[int]) -> Profile:
        cells = 2 * len(rows)
        least, limit = self._sum_of_squares(best, rows), interval_threshold(cells, len(best))
        below, above = (self._walk(i, best, rows, sign, least, math.sqrt(limit)) for sign in (-1.0, 1.0))
        places = [*reversed(below.places), best[i], *above.places]
        return Profile(
            values=self._low[i] + np.array(places) * self._span[i],
            rise=np.square([*reversed(below.roots), 0.0, *above.roots]),
            interval=(
                float(self._low[i] + below.end * self._span[i]),
                float(self._low[i] + above.end * self._span[i]),
            ),
            open_below=below.open,
            open_above=above.open,
        )

    def _walk(
        self, i: int, best: FloatArray, rows: list[int], sign: float, least: float, goal: float
    ) -> _Walk:
        """Go from the optimum to where the root of the rise reaches the goal, or to the end of the range.

        The root is linear where the sum of squares is a parabola; that gives the next step.
        """
        others = [j for j in range(len(best)) if j != i]
        bound = 1.0 if sign > 0 else 0.0
        room = abs(bound - best[i])
        inside, outside = (0.0, 0.0), None
        found: dict[float, float] = {}
        point, step = best, min(_FIRST_STEP, room)
        for _ in range(_WALK):
            if step <= 0.0:
                break
            point = point.copy()
            point[i] = best[i] + sign * step
            point, squares = self._improve(point, others, rows)
            root = math.sqrt(max(2 * len(rows) * math.log(squares / least), 0.0))
            found[step] = root
            if root <= goal:
                inside = (step, root)
            else:
                outside = (step, root)
            if abs(root - goal) < _NEAR * goal:
                # near enough for the same line to be the way to the end
                outside = (step * goal / root, goal)
                break
            if root <= goal and step >= room:
                break
            if outside is None:
                step = min(room, step * min(max(1.05 * goal / max(root, 1e-9), 1.3), 8.0))
            else:
                step = _between(inside, outside, goal)
        steps = sorted(found)
        end = room if outside is None else min(_between(inside, outside, goal), room)
        return _Walk(
            places=[float(best[i] + sign * each) for each in steps],
            roots=[found[each] for each in steps],
            end=float(best[i] + sign * end),
            open=outside is None,
        )

    def _improve(self, start: FloatArray, free: list[int], rows: list[int]) -> tuple[FloatArray, float]:
        """Find the least sum of squares over the free parameters, in shares of their ranges."""
        from scipy.optimize import least_squares

        point = np.array(start, dtype=float)

        def whole(part: FloatArray) -> FloatArray:
            moved = point.copy()
            moved[free] = part
            return moved

        last: dict[bytes, FloatArray] = {}

        def residuals(part: FloatArray) -> FloatArray:
            last.clear()
            last[part.tobytes()] = 1e3 * self._predict(whole(part)[None])[0, rows].ravel()
            return last[part.tobytes()] - 1e3 * self._measured[rows].ravel()

        def slopes(part: FloatArray) -> FloatArray:
            # asked for where the residuals were computed last
            if part.tobytes() not in last:
                residuals(part)
            steps = np.where(part + _STEP <= 1.0, _STEP, -_STEP)
            moved = np.repeat(point[None], len(part), axis=0)
            moved[:, free] = part + np.diag(steps)
            near = self._model_near(self._low + whole(part) * self._span, self._low + moved * self._span)
            errors = 1e3 * np.minimum(near, _CAP)[:, rows].reshape(len(moved), -1)
            return np.asarray(((errors - last[part.tobytes()]) / steps[:, None]).T)

        result = least_squares(
            residuals,
            np.clip(point[free], 0.0, 1.0),
            jac=slopes,
            bounds=(0.0, 1.0),
            method="dogbox",
            xtol=_TOLERANCE,
            ftol=1e-6,
            gtol=1e-10,
            max_nfev=_ROUNDS,
        )
        return whole(result.x), 2.0 * float(result.cost)

    def _predict(self, points: FloatArray) -> FloatArray:
        return np.minimum(self._model(self._low + points * self._span), _CAP)

    def _sum_of_squares(self, point: FloatArray, rows: list[int]) -> float:
        return float(np.sum((1e3 * (self._predict(point[None])[0, rows] - self._measured[rows])) ** 2))


def _between(inside: tuple[float, float], outside: tuple[float, float], goal: float) -> float:
    """Step at which the root of the rise is the goal, on a line between two steps with their roots."""
    share = (goal - inside[1]) / max(outside[1] - inside[1], 1e-12)
    return inside[0] + share * (outside[0] - inside[0])
