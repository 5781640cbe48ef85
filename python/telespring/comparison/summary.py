"""The content of `compare.json`: a row for each condition, the choice and why, and the units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import finite_or_none, json_ready
from telespring._types import FloatArray
from telespring.comparison.choices import Alternative, Candidate, LeftOut, Recommendation, Rejection

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["comparison_json", "condition_rows"]

_SCHEMA = 1
_MM = 1e3
_UNITS = {
    "stiffness": "N/m",
    "delay": "s",
    "te1_mean": "mm",
    "te2_mean": "mm",
    "te1_sd": "mm",
    "te2_sd": "mm",
    "te1_worst": "mm",
    "te2_worst": "mm",
    "difference": "mm",
    "difference_error": "mm",
    "limited_share": "1",
    "withheld_share": "1",
    "force_fidelity": "1",
    "coupling_energy_minimum": "J",
    "coupling_energy": "J",
    "age_mean": "s",
    "age_low": "s",
    "age_high": "s",
    "within_age_range": "1",
}


def comparison_json(
    comparison: xr.Dataset, recommendation: Recommendation, left_out: tuple[LeftOut, ...]
) -> dict[str, Any]:
    """Return the content of `compare.json`, which `docs/compare.md` lists."""
    unconnected = comparison["tracking_error_unconnected"].values
    return {
        "schema": _SCHEMA,
        "study": str(comparison.attrs["name"]),
        "conditions": condition_rows(comparison),
        "unconnected": _tracking_errors(unconnected),
        "recommended": _recommended_json(recommendation),
        "alternatives": [_alternative_json(each) for each in recommendation.alternatives],
        "left_out": [{"architecture": each.architecture, "reason": each.reason} for each in left_out],
        "units": _UNITS,
    }


def condition_rows(comparison: xr.Dataset) -> list[dict[str, Any]]:
    """List what was measured for each architecture, network and condition."""
    rows = []
    arrays = {str(name): variable.values for name, variable in comparison.variables.items()}
    for a, architecture in enumerate(arrays["architecture"]):
        for n, network in enumerate(arrays["network"]):
            for c, condition in enumerate(arrays["condition"]):
                if not arrays["is_rehearsed"][n, c]:
                    continue
                here = (a, n, c)
                rows.append(
                    {
                        "architecture": str(architecture),
                        **{part: str(arrays[part][a]) for part in ("strategy", "predictor", "playout")},
                        "network": str(network),
                        "condition": str(condition),
                        "stiffness": float(arrays["stiffness"][c]),
                        "delay": float(arrays["delay"][c]),
                        **_tracking_errors(arrays["tracking_error"][here]),
                        "trials": int(arrays["status"][here].size),
                        "completed": int((arrays["status"][here] == 0).sum()),
                        "diverged": int(arrays["diverged"][here].sum()),
                        "limited_share": _mean(arrays["limited_share"][here]),
                        "withheld_share": _mean(arrays["withheld_share"][here]),
                        "force_fidelity": _mean(arrays["force_fidelity"][here]),
                        "coupling_energy_minimum": _extreme(np.min, arrays["coupling_energy_minimum"][here]),
                        "coupling_energy": _mean(arrays["coupling_energy"][here]),
                        "age_mean": _mean(arrays["age_mean"][here]),
                        "age_low": _extreme(np.min, arrays["age_low"][here]),
                        "age_high": _extreme(np.max, arrays["age_high"][here]),
                        "within_age_range": _mean(arrays["within_age_range"][here]),
                        "verdict": str(arrays["verdict"][here]),
                    }
                )
    return rows


def _tracking_errors(errors: FloatArray) -> dict[str, float | None]:
    """Return mean and standard deviation of both people, mm, over the completed trials (trial, robot)."""
    found: dict[str, float | None] = {}
    for robot in range(2):
        finite = _MM * errors[np.isfinite(errors[:, robot]), robot]
        found[f"te{robot + 1}_mean"] = float(finite.mean()) if len(finite) else None
        found[f"te{robot + 1}_sd"] = float(finite.std(ddof=1)) if len(finite) > 1 else None
    return found


def _mean(values: FloatArray) -> float | None:
    return _extreme(np.mean, values)


def _extreme(statistic: Any, values: FloatArray) -> float | None:
    """Apply a statistic to the finite values; None without any."""
    finite = values[np.isfinite(values)]
    return float(statistic(finite)) if finite.size else None


def _candidate_json(candidate: Candidate) -> dict[str, Any]:
    one, other = candidate.tracking_error
    worst_one, worst_other = candidate.worst_tracking_error
    return {
        "architecture": candidate.architecture,
        "strategy": candidate.strategy,
        "predictor": candidate.predictor,
        "playout": candidate.playout,
        "stiffness": candidate.stiffness,
        "te1_mean": _MM * one,
        "te2_mean": _MM * other,
        "te1_worst": _MM * worst_one,
        "te2_worst": _MM * worst_other,
        "grounds": candidate.grounds,
    }


def _recommended_json(recommendation: Recommendation) -> dict[str, Any] | None:
    candidate, following = recommendation.candidate, recommendation.next_best
    if candidate is None:
        return None
    best: dict[str, Any] = {"reason": "smallest tracking error", "next": None}
    if following is not None:
        best |= {"next": following.architecture, **_difference_json(following)}
    return {
        **_candidate_json(candidate),
        "reasons": [
            {
                "reason": "no trial ran away",
                "conditions": recommendation.conditions,
                "trials": recommendation.trials,
            },
            {"reason": "safe", "grounds": candidate.grounds},
            best,
        ],
        "rejected": [_rejection_json(each) for each in recommendation.rejections],
    }


def _alternative_json(alternative: Alternative) -> dict[str, Any]:
    candidate = alternative.candidate
    return {
        "architecture": alternative.architecture,
        "safe": None if candidate is None else _candidate_json(candidate),
        **_difference_json(alternative),
        "rejected": [_rejection_json(each) for each in alternative.rejections],
    }


def _difference_json(alternative: Alternative) -> dict[str, float | None]:
    return {
        "difference": finite_or_none(_MM * alternative.difference),
        "difference_error": finite_or_none(_MM * alternative.difference_error),
    }


def _rejection_json(rejection: Rejection) -> dict[str, Any]:
    values: dict[str, Any] = json_ready(vars(rejection))
    return values
