"""How things are timed, and what a line of the table holds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass
class Timing:
    """Seconds per piece of work: median, quartiles, and how often it was repeated."""

    median: float
    lower: float
    upper: float
    repetitions: int

    def scaled(self, factor: float) -> Timing:
        return Timing(self.median * factor, self.lower * factor, self.upper * factor, self.repetitions)


@dataclass
class Row:
    """One line: who did it, how long it took, how wrong it was, and what was aimed at."""

    group: str
    name: str
    timing: Timing | None = None
    error: float | None = None
    ours: bool = False
    # the line of ours that the others' ratios in its group refer to
    base: bool = False
    target_seconds: float | None = None
    target_error: float | None = None
    note: str = ""

    @property
    def verdict(self) -> str:
        """What became of the target: "met", "not met", with what is missing, or nothing."""
        missed = []
        if self.timing is None:
            return ""
        if self.target_seconds is not None and self.timing.median > self.target_seconds:
            missed.append("time")
        if self.target_error is not None and not (self.error is not None and self.error <= self.target_error):
            missed.append("accuracy")
        if self.target_seconds is None and self.target_error is None:
            return ""
        return f"not met ({' and '.join(missed)})" if missed else "met"


@dataclass(frozen=True)
class Effort:
    """How much work to spend; `quick` only shows that everything runs."""

    quick: bool = False

    def time(self, call: Callable[[], Any], seconds: float = 1.0, least: int = 3) -> Timing:
        """Repeat a call for about so many seconds after one call that warms up."""
        if not self.quick:
            call()
        samples: list[float] = []
        start = time.perf_counter()
        while not samples or (
            not self.quick and (len(samples) < least or time.perf_counter() - start < seconds)
        ):
            begin = time.perf_counter()
            call()
            samples.append(time.perf_counter() - begin)
        lower, median, upper = np.quantile(samples, [0.25, 0.5, 0.75])
        return Timing(float(median), float(lower), float(upper), len(samples))

    def once(self, call: Callable[[], Any]) -> tuple[Timing, Any]:
        """Time a single call that is too long to repeat, and return what it gave."""
        begin = time.perf_counter()
        result = call()
        spent = time.perf_counter() - begin
        return Timing(spent, spent, spent, 1), result


def attempt(group: str, name: str, rows: Callable[[], Iterable[Row]]) -> list[Row]:
    """Return the rows of a peer, or one that says why there are none."""
    try:
        return list(rows())
    except ImportError as missing:
        return [Row(group, name, note=f"not installed: {missing}")]
    except Exception as error:
        return [Row(group, name, note=f"failed: {type(error).__name__}: {error}")]


def relative_error(found: Any, truth: Any) -> float:
    """Return the largest absolute error over the largest magnitude; NaN counts as infinite."""
    found, truth = np.asarray(found), np.asarray(truth)
    if found.shape != truth.shape:
        raise ValueError(f"{found.shape} outputs where {truth.shape} were asked for")
    error = float(np.max(np.abs(found - truth)) / np.max(np.abs(truth)))
    return error if np.isfinite(error) else float("inf")
