"""The best safe choice of a comparison: the rule, and what it makes of every architecture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from telespring._types import FloatArray
from telespring.comparison.choices import Alternative, Candidate, Recommendation, Rejection, Unconnected

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["recommend"]


@dataclass(frozen=True)
class _Judged:
    """A candidate, with its tracking errors over (network, condition, trial, robot), m."""

    candidate: Candidate
    errors: FloatArray


def recommend(comparison: xr.Dataset) -> Recommendation:
    """Choose the best safe architecture and stiffness of a comparison.

    A user chooses architecture and stiffness; networks and delays are what they are. So each choice is
    judged on all networks and delays together. It is safe if

    1. it was rehearsed on each of them,
    2. no trial ran away, and none ended early for another reason,
    3. its strategy has grounds of its own on each of them (`telespring.comparison.grounds`).

    Of the safe choices the one with the smallest mean tracking error wins: the mean over both people, all
    networks, delays and trials. It is not recommended if that error is larger than without a partner.

    Parameters
    ----------
    comparison : xarray.Dataset
        As `telespring.compare` makes it.

    Returns
    -------
    Recommendation
        The choice, how it compares with working alone, and for every other architecture its best safe
        stiffness with the difference, or why it has none.
    """
    is_rehearsed = np.asarray(comparison["is_rehearsed"])
    delays = comparison["delay"].values
    needed = {
        (network, float(delays[condition]))
        for network, condition in zip(*np.nonzero(is_rehearsed), strict=True)
    }
    safe: dict[str, list[_Judged]] = {}
    rejections: dict[str, list[Rejection]] = {}
    labels = [str(label) for label in comparison["architecture"].values]
    for label in labels:
        safe[label], rejections[label] = [], []
        one = comparison.sel(architecture=label)
        for stiffness in np.unique(comparison["stiffness"].values).tolist():
            found = _judge(one, stiffness, is_rehearsed, needed)
            if isinstance(found, Rejection):
                rejections[label].append(found)
            else:
                safe[label].append(found)
    # The first of equals, so that the simpler architecture wins: it is listed first.
    best = {
        label: min(judged, key=lambda each: each.candidate.mean_tracking_error)
        for label, judged in safe.items()
        if judged
    }
    chosen = min(best, key=lambda label: best[label].candidate.mean_tracking_error, default=None)
    alone = np.asarray(comparison["tracking_error_unconnected"].transpose("trial", "robot").values)
    return Recommendation(
        candidate=None if chosen is None else best[chosen].candidate,
        unconnected=_unconnected(alone, None if chosen is None else best[chosen]),
        conditions=len(needed),
        trials=len(needed) * comparison.sizes["trial"],
        alternatives=tuple(
            _alternative(label, best.get(label), None if chosen is None else best[chosen], rejections[label])
            for label in labels
            if label != chosen
        ),
        rejections=() if chosen is None else tuple(rejections[chosen]),
    )


def _judge(
    one: xr.Dataset, stiffness: float, is_rehearsed: FloatArray, needed: set[tuple[int, float]]
) -> _Judged | Rejection:
    """Judge one architecture with one stiffness on all networks and delays."""
    conditions = np.flatnonzero(one["stiffness"].values == stiffness)
    networks, delays = [str(name) for name in one["network"].values], one["delay"].values
    places = [(n, c) for n in range(len(networks)) for c in conditions if is_rehearsed[n, c]]
    missing = needed - {(n, float(delays[c])) for n, c in places}
    if missing:
        network, delay = min(missing)
        return Rejection(stiffness, "not at every delay", networks[network], delay)
    status = one["status"].transpose("network", "condition", "trial").values
    diverged = one["diverged"].transpose("network", "condition", "trial").values
    for objection, bad in (("ran away", diverged), ("ended early", (status != 0) & ~diverged)):
        count = {(n, c): int(bad[n, c].sum()) for n, c in places}
        worst = max(places, key=lambda place: count[place])
        if count[worst]:
            n, c = worst
            return Rejection(stiffness, objection, networks[n], float(delays[c]), trials=count[worst])  # type: ignore[arg-type]
    words = {
        name: one[name].transpose("network", "condition").values for name in ("grounds", "lack", "verdict")
    }
    for n, c in places:
        if not words["grounds"][n, c]:
            lack, verdict = str(words["lack"][n, c]), str(words["verdict"][n, c])
            return Rejection(
                stiffness,
                "not proven",
                networks[n],
                float(delays[c]),
                verdict=verdict,
                lack=lack,  # type: ignore[arg-type]
            )
    errors = one["tracking_error"].transpose("network", "condition", "trial", "robot").values
    errors = np.array([errors[place] for place in places])
    by_robot, by_place = errors.mean(axis=(0, 1)), errors.mean(axis=1).max(axis=0)
    return _Judged(
        Candidate(
            architecture=str(one["architecture"].values),
            strategy=str(one["strategy"].values),
            predictor=str(one["predictor"].values),
            playout=str(one["playout"].values),
            stiffness=stiffness,
            tracking_error=(float(by_robot[0]), float(by_robot[1])),
            worst_tracking_error=(float(by_place[0]), float(by_place[1])),
            grounds=str(words["grounds"][places[0]]),  # type: ignore[arg-type]
        ),
        errors,
    )


def _unconnected(errors: FloatArray, chosen: _Judged | None) -> Unconnected:
    """Compare a choice with the trials without a partner, (trial, robot)."""
    completed = np.isfinite(errors).all(axis=1)
    one, other = (float(errors[completed, robot].mean()) if completed.any() else math.nan for robot in (0, 1))
    difference = error = math.nan
    if chosen is not None and completed.any():
        difference, error = _mean_and_error(
            chosen.errors.mean(axis=(0, 2))[completed] - errors[completed].mean(axis=1)
        )
    return Unconnected((one, other), difference, error)


def _alternative(
    label: str, judged: _Judged | None, chosen: _Judged | None, rejections: list[Rejection]
) -> Alternative:
    difference = error = math.nan
    if judged is not None and chosen is not None:
        # Trials of the same number have the same random numbers, at the same place.
        difference, error = _mean_and_error((judged.errors - chosen.errors).mean(axis=(0, 2)))
    return Alternative(
        label, None if judged is None else judged.candidate, difference, error, tuple(rejections)
    )


def _mean_and_error(pairs: FloatArray) -> tuple[float, float]:
    """Return the mean of differences over pairs of trials, and its standard error; NaN of one pair."""
    error = float(pairs.std(ddof=1) / math.sqrt(len(pairs))) if len(pairs) > 1 else math.nan
    return float(pairs.mean()), error
