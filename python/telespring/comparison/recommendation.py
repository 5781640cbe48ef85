"""The best safe choice of a comparison: the rule, and what it makes of every architecture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from telespring._core import GuardOverdraft
from telespring._types import FloatArray
from telespring.comparison.choices import Alternative, Candidate, Grounds, Recommendation, Rejection

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["recommend"]

#: Strategies that are safe whatever network and partner do, as far as their overdraft is small (docs/guard.md has
#: the proof). The others need constant delays, stated ages or an honest partner (docs/strategies.md), which nobody
#: can promise; they are safe where the spring is stable.
_SAFE_ON_ANY_NETWORK = frozenset({"guard"})


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
    3. its strategy is safe on any network (the guard, as far as it is proven at that stiffness), or `decide`
       calls the bare spring stable on each of them; that answer is of the spring that follows the motion as
       played, so a spring with a predictor has none.

    Of the safe choices the one with the smallest mean tracking error wins: the mean over both people, all
    networks, delays and trials.

    Parameters
    ----------
    comparison : xarray.Dataset
        As `telespring.compare` makes it.

    Returns
    -------
    Recommendation
        The choice, and for every other architecture its best safe stiffness with the difference, or why it
        has none.
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
    return Recommendation(
        candidate=None if chosen is None else best[chosen].candidate,
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
    grounds: Grounds = "any network"
    overdraft = float(one["guard_overdraft"].values[conditions].max())
    if (
        str(one["strategy"].values) in _SAFE_ON_ANY_NETWORK
        and overdraft > GuardOverdraft.LARGEST_PROVEN_RATIO
    ):
        n, c = places[0]
        return Rejection(stiffness, "overdraft", networks[n], float(delays[c]))
    if str(one["strategy"].values) not in _SAFE_ON_ANY_NETWORK:
        grounds = "stable spring"
        predicts = str(one["predictor"].values) != "hold"
        verdict = one["verdict"].transpose("network", "condition").values
        for n, c in places:
            word = "" if predicts else str(verdict[n, c])
            if word != "stable":
                return Rejection(stiffness, "not proven", networks[n], float(delays[c]), verdict=word)
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
            grounds=grounds,
        ),
        errors,
    )


def _alternative(
    label: str, judged: _Judged | None, chosen: _Judged | None, rejections: list[Rejection]
) -> Alternative:
    difference = error = math.nan
    if judged is not None and chosen is not None:
        # Trials of the same number have the same random numbers, at the same place.
        pairs = (judged.errors - chosen.errors).mean(axis=(0, 2))
        difference = float(pairs.mean())
        if len(pairs) > 1:
            error = float(pairs.std(ddof=1) / math.sqrt(len(pairs)))
    return Alternative(
        label, None if judged is None else judged.candidate, difference, error, tuple(rejections)
    )
