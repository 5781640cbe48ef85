"""Names of conditions, such as UM and CM-36-167."""

from __future__ import annotations

import math
from collections.abc import Iterable

from telespring._core import Condition

__all__ = ["condition_label", "condition_labels", "distinct_labels"]


def condition_label(stiffness: float | None, delay: float, digits: int = 0) -> str:
    """Name a condition as the paper does.

    Parameters
    ----------
    stiffness
        Stiffness of the virtual spring, N/m; None or NaN in the unconnected mode.
    delay
        One-way delay, s.
    digits
        Decimal places of stiffness and delay.

    Returns
    -------
    str
        "UM", or "CM-" with the stiffness in N/m and the delay in ms, both rounded.

    Examples
    --------
    >>> condition_label(35.61599, 0.16719), condition_label(None, 0.0)
    ('CM-36-167', 'UM')
    """
    if stiffness is None or math.isnan(stiffness):
        return "UM"
    return f"CM-{stiffness:.{digits}f}-{1e3 * delay:.{digits}f}"


def condition_labels(conditions: Iterable[Condition | tuple[float | None, float]]) -> list[str]:
    """Name all conditions of an experiment as `condition_label` does, each differently.

    Where rounding makes two conditions alike, all names have more digits; a repeated condition is numbered.

    Examples
    --------
    >>> condition_labels([(None, 0.0), (35.616, 0.0), (35.616, 0.16719)])
    ['UM', 'CM-36-0', 'CM-36-167']
    >>> condition_labels([(35.6, 0.1), (36.2, 0.1), (36.2, 0.1)])
    ['CM-35.6-100.0', 'CM-36.2-100.0', 'CM-36.2-100.0 (2)']
    """
    pairs: list[tuple[float | None, float]] = [(k, delay) for k, delay in conditions]
    distinct = len({(k, delay if k is not None else 0.0) for k, delay in pairs})
    for digits in range(13):
        names = [condition_label(k, delay, digits) for k, delay in pairs]
        if len(set(names)) == distinct:
            break
    return distinct_labels(names)


def distinct_labels(names: Iterable[str]) -> list[str]:
    """Make all names different: those that occur again get a number.

    Examples
    --------
    >>> distinct_labels(["UM", "CM-36-0", "UM", "UM (2)"])
    ['UM', 'CM-36-0', 'UM (2)', 'UM (2) (2)']
    """
    labels: list[str] = []
    for name in names:
        label, count = name, 1
        while label in labels:
            count += 1
            label = f"{name} ({count})"
        labels.append(label)
    return labels
