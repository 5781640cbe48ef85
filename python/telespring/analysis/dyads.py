"""Trials of several dyads: one value per dyad, because the trials of a dyad are not independent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_numbers
from telespring._types import FloatArray

__all__ = ["dyad_means", "matched_dyads", "split_dyads"]


def dyad_means(values: ArrayLike, dyads: ArrayLike) -> dict[str, float]:
    """Average the values (NaN where missing) of every dyad, by its label; dyads without values are left out.

    Examples
    --------
    >>> dyad_means([1.0, 3.0, np.nan, 5.0], ["a", "a", "a", "b"])
    {'a': 2.0, 'b': 5.0}
    """
    array, labels = as_numbers("values", values).reshape(-1), np.asarray(dyads).reshape(-1).astype(str)
    present = ~np.isnan(array)
    return {
        str(label): float(array[present & (labels == label)].mean()) for label in np.unique(labels[present])
    }


def matched_dyads(groups: Sequence[Mapping[str, float]]) -> list[str] | None:
    """List the dyads that have a value in every group, if they are most of all dyads; else None.

    Then the groups are compared within dyads, which removes the differences between them.

    Examples
    --------
    >>> matched_dyads([{"a": 1.0, "b": 2.0}, {"a": 3.0, "b": 1.0, "c": 2.0}])
    ['a', 'b']
    >>> matched_dyads([{"a": 1.0}, {"b": 1.0}]) is None
    True
    """
    everywhere = set(groups[0]).intersection(*groups[1:])
    anywhere = set(groups[0]).union(*groups[1:])
    return sorted(everywhere) if everywhere and 2 * len(everywhere) >= len(anywhere) else None


def split_dyads(groups: Sequence[Mapping[str, float]]) -> list[FloatArray]:
    """Return the values of dyads that have a value in one group only: these groups are independent.

    Examples
    --------
    >>> [group.tolist() for group in split_dyads([{"a": 1.0, "b": 2.0}, {"b": 3.0, "c": 4.0}])]
    [[1.0], [4.0]]
    """
    labels = [label for group in groups for label in group]
    return [
        np.array([value for label, value in group.items() if labels.count(label) == 1]) for group in groups
    ]
