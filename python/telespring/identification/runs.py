"""Several runs in one log: known by a column, or by the time that starts again."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["find_runs", "select_run"]

#: A run starts again where the time returns to the first part of the run before.
_RETURN = 0.1
#: Fewer samples are no run, but a disorder of the time stamps.
_FEWEST_SAMPLES = 10


def find_runs(time: FloatArray, column: Any | None) -> tuple[NDArray[np.int_], tuple[str, ...]]:
    """Return the run of every sample (from 0) and the names of the runs.

    `column` has a value per run, which is its name. Without it a run begins where the time (s) starts again,
    and they are named "1", "2", …; a time that only steps back is no new run.
    """
    if column is not None:
        import pandas as pd

        codes, values = pd.factorize(pd.Series(column), use_na_sentinel=False)
        return np.asarray(codes, dtype=int), tuple(_name_of_run(value) for value in values)
    known = np.flatnonzero(np.isfinite(time))
    starts = [0]
    for back in np.flatnonzero(np.diff(time[known]) < 0.0) + 1:
        first, last, again = time[known[starts[-1]]], time[known[back - 1]], time[known[back]]
        if back - starts[-1] >= _FEWEST_SAMPLES and again <= first + _RETURN * (last - first):
            starts.append(int(back))
    if known.size - starts[-1] < _FEWEST_SAMPLES:
        starts = starts[:1]
    run = np.zeros(time.size, dtype=int)
    for start in starts[1:]:
        run[known[start] :] += 1
    return run, tuple(str(i + 1) for i in range(len(starts)))


def _name_of_run(value: Any) -> str:
    """Return the value of a run's column as a person writes it: 2.0 is 2."""
    return (
        str(int(value))
        if isinstance(value, float | np.floating) and float(value).is_integer()
        else str(value)
    )


def select_run(wanted: str, names: tuple[str, ...]) -> int:
    """Return the place of a run by its name."""
    if wanted.strip() not in names:
        shown = ", ".join(names[:20]) + (", …" if len(names) > 20 else "")
        raise InvalidInput(
            "run", wanted, f"the log has the runs {shown}", "Choose one of them, or omit --run for all."
        )
    return names.index(wanted.strip())
