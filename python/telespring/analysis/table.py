"""Table I: tracking errors per condition with the arrows that say how they differ from the baseline."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.analysis.statistics import Comparison, compare_pairs
from telespring.analysis.trials import Trials
from telespring.theory.axis import finite_or_none

__all__ = ["baseline_of", "compare_with_baseline", "describe", "group_name", "table1", "table1_csv"]


def group_name(robot: int, label: str) -> str:
    """Name the tracking errors of one robot in one condition, such as "TE2 CM-36-167"."""
    return f"TE{robot} {label}"


def baseline_of(trials: Trials, wanted: str | None = None) -> str | None:
    """Find the condition that the others are compared with.

    Parameters
    ----------
    trials
        The experiment.
    wanted
        Name of a condition; the unconnected mode unless given.

    Returns
    -------
    str or None
        Its name; None where there is no unconnected mode.

    Raises
    ------
    telespring.InvalidInput
        Where no condition has the name.
    """
    if wanted is None:
        unconnected = [
            label for label, k in zip(trials.labels, trials.stiffness, strict=True) if not np.isfinite(k)
        ]
        return unconnected[0] if unconnected else None
    if wanted not in trials.labels:
        raise InvalidInput(
            "baseline", wanted, f"one of {', '.join(trials.labels)} is needed", "Leave it away for UM."
        )
    return wanted


def compare_with_baseline(
    errors: Mapping[str, FloatArray], trials: Trials, baseline: str | None
) -> dict[str, Comparison]:
    """Compare every tracking error with TE2 in the baseline, as one family.

    Parameters
    ----------
    errors
        Tracking errors by group name, m.
    trials
        The experiment.
    baseline
        Its condition, or None.

    Returns
    -------
    dict
        By the name of the first group; empty without a baseline. For seventeen conditions the family has
        33 members: TE1 in each, and TE2 in each but the baseline.
    """
    if baseline is None:
        return {}
    reference = group_name(2, baseline)
    pairs = [
        (group_name(robot, label), reference)
        for label in trials.labels
        for robot in (1, 2)
        if group_name(robot, label) != reference
    ]
    return {found.first: found for found in compare_pairs(pairs, errors)}


def describe(values: FloatArray) -> dict[str, float | None]:
    """Give mean, standard deviation (n − 1) and median of the values that exist, None where they do not."""
    existing = values[np.isfinite(values)]
    return {
        "mean": finite_or_none(existing.mean()) if len(existing) else None,
        "sd": finite_or_none(existing.std(ddof=1)) if len(existing) > 1 else None,
        "median": finite_or_none(np.median(existing)) if len(existing) else None,
    }


def table1(
    errors: Mapping[str, FloatArray], trials: Trials, comparisons: Mapping[str, Comparison]
) -> list[dict[str, Any]]:
    """Lay out Table I.

    Parameters
    ----------
    errors
        Tracking errors by group name, m.
    trials
        The experiment.
    comparisons
        With the baseline, by group name.

    Returns
    -------
    list of dict
        A row per condition: ``condition``; ``stiffness`` (N/m, None unconnected) and ``delay`` (s);
        ``trials`` begun and ``ended_early``; per robot i ``tei_mean``, ``tei_sd``, ``tei_median`` in mm,
        ``tei_n``, ``tei_arrow`` by the raw ``tei_p`` < 0.05 as in the paper ("↑", "↓" or ""),
        ``tei_arrow_holm`` by ``tei_p_holm``, and the effect ``tei_superiority`` (Vargha and Delaney's A)
        between ``tei_superiority_low`` and ``tei_superiority_high``.
    """
    rows = []
    begun = (trials.status != "absent").sum(axis=1)
    early = trials.ended_early.sum(axis=1)
    for i, label in enumerate(trials.labels):
        row: dict[str, Any] = {
            "condition": label,
            "stiffness": finite_or_none(trials.stiffness[i]),
            "delay": finite_or_none(trials.delay[i]),
            "trials": int(begun[i]),
            "ended_early": int(early[i]),
        }
        for robot in (1, 2):
            name, key = group_name(robot, label), f"te{robot}"
            found = comparisons.get(name)
            millimetres = describe(1e3 * errors[name])
            row |= {f"{key}_{which}": value for which, value in millimetres.items()}
            interval = None if found is None else found.superiority_interval
            low, high = (None, None) if interval is None else interval
            row |= {
                f"{key}_n": int(np.isfinite(errors[name]).sum()),
                f"{key}_arrow": "" if found is None else found.arrow(),
                f"{key}_arrow_holm": "" if found is None else found.arrow(corrected=True),
                f"{key}_p": None if found is None else found.p_value,
                f"{key}_p_holm": None if found is None else found.p_holm,
                f"{key}_superiority": None if found is None else found.superiority,
                f"{key}_superiority_low": low,
                f"{key}_superiority_high": high,
            }
        rows.append(row)
    return rows


def table1_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Write Table I as CSV, a column per key of its rows; an empty field is a value that does not exist."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
