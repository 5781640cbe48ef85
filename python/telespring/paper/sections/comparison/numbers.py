"""The numbers of the section: tracking errors in mm, and their ratio to those without delay."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from telespring._json import finite_or_none
from telespring._types import FloatArray
from telespring.paper.published import TABLE_I
from telespring.paper.scene import Scene
from telespring.show.drawings.comparison import error_reference

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["comparison_numbers"]

_Condition = tuple[float, float]
#: An error of the shared clock for which its effect is given, s.
_CLOCK_ERROR = 0.005


def comparison_numbers(
    scene: Scene,
    compared: xr.Dataset,
    labels: Mapping[str, str],
    own: Sequence[_Condition],
    target_speed: float,
) -> tuple[dict[str, Any], _Condition]:
    """Return the key `comparison` of `study.json`, and the condition whose account is drawn.

    `labels` are those of the architectures in `compared` by the key that each has here, the bare spring first
    and the best last; `own` are the conditions of the study's protocol, and `target_speed` is the largest
    of the target, m/s.
    """
    published = _published_errors(scene)
    rows = []
    for i, (stiffness, delay) in enumerate(
        zip(compared.stiffness.values.tolist(), compared.delay.values.tolist(), strict=True)
    ):
        here = compared.sel(network="study").isel(condition=i)
        undelayed = _mean_errors(compared, labels["spring"], (stiffness, 0.0))
        rows.append(
            {
                "condition": str(compared.condition.values[i]),
                "stiffness": stiffness,
                "delay": delay,
                "of_the_protocol": (stiffness, delay) in own,
                "published": _published_cost(published, str(compared.condition.values[i]), stiffness),
                **{key: _entry(here.sel(architecture=label), undelayed) for key, label in labels.items()},
            }
        )
    best = list(labels)[-1]
    alone = _unconnected_entry(compared, rows, best)
    shown = _most_telling(rows, best)
    numbers = {
        "architectures": [{"key": key, "label": label} for key, label in labels.items()],
        "best": best,
        "delayed": sum(row["delay"] > 0.0 for row in rows),
        "trials": min(row[key]["trials"] for row in rows for key in labels if row[key] is not None),
        "unconnected": alone,
        "reference": error_reference(compared.sel(network="study")),
        "conditions": rows,
        "shown": shown,
        "worst": {key: _worst(rows, key) for key in labels},
        "worst_published": _worst_published(rows),
        "ran_away": {
            key: sum(1 for row in rows if row[key] is not None and row[key]["ran_away"]) for key in labels
        },
        "target_speed": target_speed,
        "clock_error": _CLOCK_ERROR,
        "clock_effect": target_speed * _CLOCK_ERROR,
    }
    return numbers, (rows[shown]["stiffness"], rows[shown]["delay"])


def _mean_errors(compared: xr.Dataset, label: str, condition: _Condition) -> FloatArray | None:
    """Return the mean tracking errors of both in one condition, m; None where there are none."""
    stiffness, delay = condition
    at = np.flatnonzero((compared.stiffness.values == stiffness) & (compared.delay.values == delay))
    if not len(at):
        return None
    one = compared.tracking_error.sel(architecture=label, network="study").isel(condition=int(at[0]))
    errors = one.transpose("trial", "robot").values
    errors = errors[np.isfinite(errors).all(axis=1)]
    return np.asarray(errors.mean(axis=0)) if len(errors) else None


def _unconnected_entry(
    compared: xr.Dataset, rows: Sequence[Mapping[str, Any]], best: str
) -> dict[str, Any] | None:
    """Describe working without a partner; None if no such trial was completed.

    `better` counts the delayed conditions in which both people together track better alone than under `best`.
    """
    if "tracking_error_unconnected" not in compared:
        return None
    errors = 1e3 * compared.tracking_error_unconnected.values
    errors = errors[np.isfinite(errors).all(axis=1)]
    if not len(errors):
        return None
    one, two = errors.mean(axis=0).tolist()
    coupled = [row[best] for row in rows if row["delay"] > 0.0 and row[best] is not None]
    means = [each["te1_mean"] + each["te2_mean"] for each in coupled if each["te1_mean"] is not None]
    return {
        "te1_mean": one,
        "te2_mean": two,
        "trials": len(errors),
        "better": sum(mean > one + two for mean in means),
        "compared": len(means),
    }


def _entry(one: xr.Dataset, undelayed: FloatArray | None) -> dict[str, Any] | None:
    """Describe one architecture in one condition; None where it was not run."""
    was_run = one.status.values >= 0
    if not was_run.any():
        return None
    errors = 1e3 * one.tracking_error.transpose("trial", "robot").values[was_run]
    finished = errors[np.isfinite(errors).all(axis=1)]
    entry: dict[str, Any] = {}
    for robot in (0, 1):
        name = f"te{robot + 1}"
        mean = float(finished[:, robot].mean()) if len(finished) else math.nan
        spread = float(finished[:, robot].std(ddof=1)) if len(finished) > 1 else math.nan
        cost = mean / (1e3 * float(undelayed[robot])) if undelayed is not None else math.nan
        entry |= {
            f"{name}_mean": finite_or_none(mean),
            f"{name}_sd": finite_or_none(spread),
            f"{name}_cost": finite_or_none(cost),
        }
    ran_away = one.diverged.values[was_run]
    return {
        **entry,
        "trials": int(was_run.sum()),
        "completed": len(finished),
        "ran_away": int(ran_away.sum()),
        "ended_early": int(((one.status.values[was_run] > 0) & ~ran_away).sum()),
        "limited_share": finite_or_none(float(one.limited_share.values[was_run].mean())),
    }


def _published_errors(scene: Scene) -> dict[str, tuple[float, float]]:
    """Return the published means of Table I by condition, m; none for another experiment."""
    return {row.label: row.mean for row in TABLE_I} if scene.of_the_papers_experiment else {}


def _published_cost(
    published: Mapping[str, tuple[float, float]], condition: str, stiffness: float
) -> dict[str, float] | None:
    """Relate the published errors of a condition to those without delay at its stiffness."""
    undelayed = published.get(f"CM-{stiffness:.0f}-0")
    if condition not in published or undelayed is None:
        return None
    return {f"te{i + 1}_cost": published[condition][i] / undelayed[i] for i in (0, 1)}


def _cost(entry: Mapping[str, Any] | None) -> float:
    """Return the larger cost of both people; −1 where there is none."""
    costs = [] if entry is None else [entry["te1_cost"], entry["te2_cost"]]
    return max((cost for cost in costs if cost is not None), default=-1.0)


def _worst(rows: Sequence[Mapping[str, Any]], key: str) -> dict[str, Any]:
    """Say in which condition with a delay an architecture costs most; none of its trials ran away there."""
    delayed = [i for i, row in enumerate(rows) if row["delay"] > 0.0 and row[key] is not None]
    calm = [i for i in delayed if not rows[i][key]["ran_away"]]
    i = max(calm, key=lambda i: _cost(rows[i][key]), default=None)
    cost = -1.0 if i is None else _cost(rows[i][key])
    return {"index": i, "cost": cost if cost > 0.0 else None}


def _worst_published(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    known = [i for i, row in enumerate(rows) if row["published"] is not None and row["delay"] > 0.0]
    if not known:
        return None
    i = max(known, key=lambda i: _cost(rows[i]["published"]))
    return {"index": i, "cost": _cost(rows[i]["published"])}


def _most_telling(rows: Sequence[Mapping[str, Any]], best: str) -> int:
    """Choose the condition of the protocol to speak of.

    The shortest delay at which the bare spring runs away; if it never does, where it costs most.
    """
    own = [i for i, row in enumerate(rows) if row["of_the_protocol"] and row[best] is not None]
    away = [i for i in own if rows[i]["spring"]["ran_away"]]
    if away:
        return min(away, key=lambda i: rows[i]["delay"])
    return max(own, key=lambda i: (_cost(rows[i]["spring"]), rows[i]["delay"]))
