"""What the section shows of each rehearsal, laid out as a comparison of strategies is."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.analysis.measures import tracking_errors
from telespring.analysis.trials import Trials
from telespring.comparison.growth import have_run_away, paid_shares, quarter_errors
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["MeasuredRehearsal", "first_trial", "measure_rehearsal", "side_by_side"]

#: What the measures need of a rehearsal; the rest of it, which is larger, stays on the disk.
_NEEDED = ("position", "velocity", "coupling_force", "target", "status", "ended_at", "limited_share")
_OF_A_TRIAL = ("account", "position", "coupling_force")


@dataclass(frozen=True, eq=False)
class MeasuredRehearsal:
    """The trials of one rehearsal.

    Attributes
    ----------
    conditions
        Stiffness (N/m, NaN: unconnected) and one-way delay (s).
    errors
        Tracking errors, m, (condition, trial, robot); NaN for a trial that ended early.
    quarters
        What `quarter_errors` returns.
    paid
        What `paid_shares` returns.
    status
        How the trials ended, (condition, trial), and as the dataset numbers it.
    limited_share
        Share of ticks that the strategy limited, (condition, trial, robot).
    target_speed
        Largest speed of the target between two recorded samples, m/s.
    """

    conditions: list[tuple[float, float]]
    errors: FloatArray
    quarters: FloatArray
    paid: FloatArray
    status: NDArray[np.str_]
    status_numbers: NDArray[np.int8]
    limited_share: FloatArray
    target_speed: float

    @property
    def unconnected(self) -> FloatArray:
        """Quarter errors of the unconnected trials, (trial, robot, 2); none without such a condition."""
        alone = self._unconnected
        return np.empty((0, 2, 2)) if alone is None else self.quarters[alone]

    @property
    def unconnected_errors(self) -> FloatArray | None:
        """Tracking errors of the unconnected trials, m, (trial, robot); None without such a condition."""
        alone = self._unconnected
        return None if alone is None else self.errors[alone]

    @property
    def _unconnected(self) -> int | None:
        return next((i for i, (stiffness, _) in enumerate(self.conditions) if np.isnan(stiffness)), None)


def measure_rehearsal(dataset: Path) -> MeasuredRehearsal:
    """Measure the trials of a rehearsal from its file."""
    import xarray as xr

    with xr.open_dataset(dataset, engine="h5netcdf") as rehearsal:
        needed = rehearsal[list(_NEEDED)].load()
    needed.attrs = rehearsal.attrs
    trials = Trials.from_dataset(needed)
    target = needed.target.transpose("time", "axis").values
    return MeasuredRehearsal(
        conditions=list(zip(trials.stiffness.tolist(), trials.delay.tolist(), strict=True)),
        errors=tracking_errors(trials),
        quarters=quarter_errors(trials),
        paid=paid_shares(trials, *_losses(needed.attrs)),
        status=trials.status,
        status_numbers=needed.status.values,
        limited_share=needed.limited_share.transpose("condition", "trial", "robot").values,
        target_speed=float(np.hypot(*np.diff(target, axis=0).T).max() / trials.sample_period),
    )


def _losses(attributes: Mapping[str, Any]) -> tuple[FloatArray, FloatArray]:
    """Return damping (N·s/m) and Coulomb friction (N) of the robots of a rehearsal, (robot, axis)."""
    robots = json.loads(attributes["robots"])
    damping = np.array([robot["damping"] for robot in robots], dtype=np.float64)
    return damping, np.array([robot.get("coulomb", [0.0, 0.0]) for robot in robots], dtype=np.float64)


def side_by_side(rehearsals: Mapping[str, Sequence[MeasuredRehearsal]], own: MeasuredRehearsal) -> xr.Dataset:
    """Lay the connected conditions of rehearsals out by architecture.

    `own` is the study's rehearsal, with whose unconnected trials one that runs away is recognised. The result
    has the names of a comparison's dataset, for one network, "study". A trial that was not run has the status
    −1. The errors of the unconnected trials have a dimension of their own: there may be more of them.
    """
    import xarray as xr

    conditions = sorted(
        {
            condition
            for parts in rehearsals.values()
            for part in parts
            for condition in part.conditions
            if np.isfinite(condition[0])
        }
    )
    trials = max(part.errors.shape[1] for parts in rehearsals.values() for part in parts)
    shape = (len(rehearsals), 1, len(conditions), trials)
    status, diverged = np.full(shape, -1, np.int8), np.zeros(shape, dtype=bool)
    errors, limited = np.full((2, *shape, 2), np.nan)
    for a, parts in enumerate(rehearsals.values()):
        for part in parts:
            ran_away = have_run_away(part.status, part.quarters, own.unconnected, part.paid)
            for i, condition in enumerate(part.conditions):
                if np.isfinite(condition[0]):
                    place = (a, 0, conditions.index(condition), slice(part.errors.shape[1]))
                    errors[place], limited[place] = part.errors[i], part.limited_share[i]
                    status[place], diverged[place] = part.status_numbers[i], ran_away[i]
    where = ("architecture", "network", "condition", "trial")
    alone = own.unconnected_errors
    variables: dict[str, Any] = (
        {} if alone is None else {"tracking_error_unconnected": (("unconnected_trial", "robot"), alone)}
    )
    variables |= {
        "tracking_error": ((*where, "robot"), errors),
        "limited_share": ((*where, "robot"), limited),
        "status": (where, status),
        "diverged": (where, diverged),
    }
    return xr.Dataset(
        variables,
        coords={
            "architecture": list(rehearsals),
            "network": ["study"],
            "condition": condition_labels(conditions),
            "stiffness": ("condition", [stiffness for stiffness, _ in conditions]),
            "delay": ("condition", [delay for _, delay in conditions]),
            "robot": [1, 2],
        },
    )


def first_trial(dataset: Path, stiffness: float, delay: float) -> xr.Dataset:
    """Load the first trial of one condition of a rehearsal, with its account if the strategy keeps one."""
    import xarray as xr

    with xr.open_dataset(dataset, engine="h5netcdf") as rehearsal:
        at = np.flatnonzero((rehearsal.stiffness.values == stiffness) & (rehearsal.delay.values == delay))
        kept = [name for name in _OF_A_TRIAL if name in rehearsal]
        return rehearsal[[*kept, "target"]].isel(condition=int(at[0]), trial=0).load()
