"""Table I: tracking errors per condition, with arrows for significant differences from the baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from telespring._errors import InvalidInput
from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.analysis.statistics import Comparison
from telespring.analysis.tracking_errors import TrackingErrors, tracking_error_name
from telespring.analysis.trials import Trials

__all__ = [
    "choose_baseline",
    "compare_with_baseline",
    "mean_sd_median",
    "table_1_csv",
    "table_1_rows",
]


def choose_baseline(trials: Trials, requested: str | None = None) -> str | None:
    """Return the baseline of Table I: the requested one, else the unconnected mode, None without."""
    if requested is None:
        unconnected = [
            label for label, k in zip(trials.labels, trials.stiffness, strict=True) if not np.isfinite(k)
        ]
        return unconnected[0] if unconnected else None
    if requested not in trials.labels:
        raise InvalidInput(
            "baseline", requested, f"one of {', '.join(trials.labels)} is required", "Omit it for UM."
        )
    return requested


def compare_with_baseline(
    errors: TrackingErrors, trials: Trials, baseline: str | None
) -> dict[str, Comparison]:
    """Compare every tracking error with TE2 in the baseline, as one family, by the name of the first group.

    For the paper's seventeen conditions the family has 33 members: TE1 in each condition, and TE2 in each
    but the baseline. It is empty without a baseline.
    """
    if baseline is None:
        return {}
    reference = tracking_error_name(2, baseline)
    pairs = [
        (tracking_error_name(robot, label), reference)
        for label in trials.labels
        for robot in (1, 2)
        if tracking_error_name(robot, label) != reference
    ]
    return {comparison.first: comparison for comparison in errors.compare(pairs)}


def mean_sd_median(values: FloatArray) -> dict[str, float | None]:
    """Compute mean, standard deviation (n − 1) and median of a cell of Table I; None for too few values."""
    present = values[np.isfinite(values)]
    return {
        "mean": finite_or_none(present.mean()) if len(present) else None,
        "sd": finite_or_none(present.std(ddof=1)) if len(present) > 1 else None,
        "median": finite_or_none(np.median(present)) if len(present) else None,
    }


def table_1_rows(
    errors: TrackingErrors, trials: Trials, comparisons: Mapping[str, Comparison]
) -> list[dict[str, Any]]:
    """Lay out Table I, a row per condition, from tracking errors (m) and comparisons with the baseline.

    docs/recorded-trials.md lists the keys of a row; means, standard deviations and medians are in mm and over
    the `n` values that count once: the means of the dyads if there are several, otherwise the distinct
    trials.
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
            name, key = tracking_error_name(robot, label), f"te{robot}"
            comparison = comparisons.get(name)
            values = errors.independent_values(name)
            millimetres = mean_sd_median(1e3 * values)
            row |= {f"{key}_{statistic}": value for statistic, value in millimetres.items()}
            interval = None if comparison is None else comparison.superiority_interval
            low, high = (None, None) if interval is None else interval
            row |= {
                f"{key}_n": len(values),
                f"{key}_distinct": int(np.isfinite(errors.values[name]).sum()),
                f"{key}_copies": int(errors.copies[i, :, robot - 1].sum()),
                f"{key}_dyads": errors.count_dyads(name),
                f"{key}_arrow": "" if comparison is None else comparison.arrow(),
                f"{key}_arrow_holm": "" if comparison is None else comparison.arrow(corrected=True),
                f"{key}_p": None if comparison is None else comparison.p_value,
                f"{key}_p_holm": None if comparison is None else comparison.p_holm,
                f"{key}_least_p": None if comparison is None else comparison.least_p,
                f"{key}_superiority": None if comparison is None else comparison.superiority,
                f"{key}_superiority_low": low,
                f"{key}_superiority_high": high,
            }
        rows.append(row)
    return rows


def table_1_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Format Table I as CSV, a column per key of its rows; a missing value is an empty field."""
    import pandas as pd

    text = pd.DataFrame(list(rows)).to_csv(index=False, lineterminator="\n")
    assert isinstance(text, str)
    return text
