"""Samples that repeat others to the last digit: a log given twice, a copy, or a part that was appended again.

Two measurements never agree in all digits of all channels for long. Samples that do are one measurement, and
counted twice they would make the intervals narrower than it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray

__all__ = ["Copies", "find_copies"]

#: So many samples in a row that all differ from their neighbours, and equal others: no chance.
_IN_A_ROW = 64


@dataclass(frozen=True, eq=False)
class Copies:
    """Which samples of a log repeat earlier ones.

    Attributes
    ----------
    repeated
        Shape (n,).
    first
        The first of them, from 0; −1 if there are none.
    log, sample
        The log and the sample that the first one repeats, from 0.
    """

    repeated: NDArray[np.bool_]
    first: int = -1
    log: int = 0
    sample: int = 0


def find_copies(logs: Sequence[FloatArray]) -> list[Copies]:
    """Find, per log, the samples that repeat those of a log before or of an earlier part.

    Every log has one row per sample and one column per signal, without the time: a copy may have other time
    stamps.

    Examples
    --------
    >>> rows = np.random.default_rng(1).normal(size=(500, 2))
    >>> once, again = find_copies([rows, np.vstack([rows[-1:], rows[:300]])])
    >>> int(once.repeated.sum()), np.flatnonzero(~again.repeated).tolist(), again.sample
    (0, [0], 0)
    """
    import pandas as pd

    keys: list[NDArray[np.uint64]] = []
    places: list[NDArray[np.int_]] = []
    numbers: list[NDArray[np.int_]] = []
    for number, rows in enumerate(logs):
        # A sensor that is read less often than it is logged repeats its values: each reading counts once.
        changes = (
            np.concatenate([[True], (rows[1:] != rows[:-1]).any(axis=1)])
            if len(rows)
            else np.zeros(0, dtype=bool)
        )
        distinct = np.flatnonzero(changes & np.isfinite(rows).all(axis=1))
        keys.append(_keys_of_windows(rows[distinct]))
        places.append(distinct)
        numbers.append(np.full(keys[-1].size, number))
    key, owner = np.concatenate(keys), np.concatenate(numbers)
    window = np.concatenate([np.arange(each.size) for each in keys])
    codes, _ = pd.factorize(key)
    codes = np.asarray(codes)
    first_of = np.full(codes.max(initial=-1) + 1, key.size)
    np.minimum.at(first_of, codes, np.arange(key.size))
    is_later = first_of[codes] < np.arange(key.size)
    found = []
    for i, rows in enumerate(logs):
        repeated = np.zeros(len(rows), dtype=bool)
        later = np.flatnonzero(is_later & (owner == i))
        if not later.size:
            found.append(Copies(repeated))
            continue
        covered = np.zeros(places[i].size + 1, dtype=int)
        np.add.at(covered, window[later], 1)
        np.add.at(covered, window[later] + _IN_A_ROW, -1)
        inside = np.cumsum(covered[:-1]) > 0
        # What lies between two repeated readings is repeated, too.
        marks = np.zeros(len(rows), dtype=int)
        marks[places[i]] = np.where(inside, 1, -1)
        last = np.maximum.accumulate(np.where(marks != 0, np.arange(len(rows)), -1))
        repeated = (last >= 0) & (marks[np.maximum(last, 0)] > 0)
        source = first_of[codes[later[0]]]
        origin = int(owner[source])
        found.append(
            Copies(repeated, int(places[i][window[later[0]]]), origin, int(places[origin][window[source]]))
        )
    return found


def _keys_of_windows(rows: FloatArray) -> NDArray[np.uint64]:
    """Return one number per window of `_IN_A_ROW` rows: equal windows have equal numbers."""
    import pandas as pd

    if len(rows) < _IN_A_ROW:
        return np.zeros(0, dtype=np.uint64)
    keys = pd.util.hash_pandas_object(pd.DataFrame(rows + 0.0), index=False).to_numpy().astype(np.uint64)
    length, factor = 1, np.uint64(0x9E3779B97F4A7C15)
    with np.errstate(over="ignore"):
        while length < _IN_A_ROW:
            # The number of a window twice as long, from those of its halves.
            keys = keys[:-length] * factor + (keys[length:] ^ (keys[length:] >> np.uint64(31)))
            length *= 2
    return keys
