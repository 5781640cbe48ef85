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

    Conditions that rounding makes alike have as many more digits as tell them apart, without zeros at the
    end; a repeated condition is numbered.

    Examples
    --------
    >>> condition_labels([(None, 0.0), (35.616, 0.0), (35.616, 0.16719)])
    ['UM', 'CM-36-0', 'CM-36-167']
    >>> condition_labels([(35.6, 0.1), (36.2, 0.1), (36.2, 0.1)])
    ['CM-35.6-100', 'CM-36.2-100', 'CM-36.2-100 (2)']
    >>> condition_labels([(71.0, 0.1), (36.0, 0.1), (36.00000001, 0.1)])
    ['CM-71-100', 'CM-36-100', 'CM-36.00000001-100']
    """
    pairs = [(k, delay if k is not None else 0.0) for k, delay in conditions]
    labels = {pair: condition_label(*pair) for pair in pairs}
    alike = {pair for pair in labels if list(labels.values()).count(labels[pair]) > 1}
    for digits in range(1, 13):
        if len(set(labels.values())) == len(labels):
            break
        labels |= {pair: _shortened_label(pair, digits) for pair in alike}
    return distinct_labels(labels[pair] for pair in pairs)


def _shortened_label(pair: tuple[float | None, float], digits: int) -> str:
    """Name a condition with up to so many decimal places, without zeros at the end."""
    name = condition_label(*pair, digits)
    return "-".join(part.rstrip("0").rstrip(".") if "." in part else part for part in name.split("-"))


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
