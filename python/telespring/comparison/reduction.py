"""What a comparison keeps of a rehearsal: numbers per trial, force responses, one trial of each condition."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from telespring._types import FloatArray
from telespring.analysis.measures import tracking_errors
from telespring.analysis.trials import Trials
from telespring.comparison.force_fidelity import (
    ForceResponse,
    force_fidelity,
    force_frequencies,
    force_response,
    intended_force,
)
from telespring.comparison.growth import quarter_errors

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LongestAges", "measure_connected", "measure_unconnected"]

#: As a rehearsal has them: of each side, and of the coupling.
_PER_ROBOT = (
    "limited_share",
    "withheld_share",
    "given_out",
    "energy_sent",
    "hand_energy",
    "held_share",
    "lost",
)
_PER_TRIAL = ("status", "ended_at", "coupling_energy", "coupling_energy_minimum")


class LongestAges(Protocol):
    """Says up to which age the samples of a spring may be used."""

    def longest_ages(
        self, stiffness: float, shortest: tuple[float, float], longest: tuple[float, float]
    ) -> tuple[float, float]:
        """Return up to which age, s, robots 1 and 2 may use samples that are no younger than `shortest`."""


def measure_connected(dataset: Path, coupling_damping: float, ages: LongestAges) -> xr.Dataset:
    """Measure the connected conditions of a rehearsal, one after the other, so that memory holds one.

    Parameters
    ----------
    dataset
        The file of the rehearsal.
    coupling_damping
        Damping in parallel with the spring, N·s/m.
    ages
        The verdict on ages.

    Returns
    -------
    xarray.Dataset
        Over the connected conditions; `docs/compare.md` lists what is in it.
    """
    import xarray as xr

    measured = [
        _measure_condition(one, coupling_damping, ages)
        for one in _conditions(dataset)
        if np.isfinite(float(one["stiffness"][0]))
    ]
    return xr.concat(
        measured, dim="condition", data_vars="minimal", coords="minimal", compat="override", join="exact"
    )


def measure_unconnected(dataset: Path) -> xr.Dataset:
    """Measure the unconnected condition of a rehearsal: tracking errors and their growth."""
    import xarray as xr

    one = next(each for each in _conditions(dataset) if np.isnan(float(each["stiffness"][0])))
    trials = Trials.from_dataset(one)
    return xr.Dataset(
        {
            "tracking_error": (("trial", "robot"), tracking_errors(trials)[0]),
            "quarter_error": (("trial", "robot", "quarter"), quarter_errors(trials)[0]),
        }
    )


def _conditions(dataset: Path) -> Iterator[xr.Dataset]:
    """Load the conditions of a rehearsal one after the other."""
    import xarray as xr

    with xr.open_dataset(dataset, engine="h5netcdf", drop_variables="agent_force") as rehearsal:
        signals = [name for name, values in rehearsal.items() if {"condition", "time"} <= set(values.dims)]
        # Of the many small variables each read takes longer than its values.
        rest = rehearsal.drop_vars(signals).load()
        for condition in range(rehearsal.sizes["condition"]):
            place = {"condition": [condition]}
            yield rest.isel(place).assign({name: rehearsal[name].isel(place).load() for name in signals})


def _measure_condition(one: xr.Dataset, coupling_damping: float, ages: LongestAges) -> xr.Dataset:
    import xarray as xr

    trials = Trials.from_dataset(one)
    labels = ("condition", "stiffness", "delay", "trial", "time", "robot", "axis")
    variables: dict[str, Any] = {
        "tracking_error": (("condition", "trial", "robot"), tracking_errors(trials)),
        "quarter_error": (("condition", "trial", "robot", "quarter"), quarter_errors(trials)),
        **{name: one[name].variable for name in (*_PER_TRIAL, *_PER_ROBOT)},
        **_forces(trials, coupling_damping),
        **_ages(one, trials, ages),
        **_first_trial(one),
    }
    frequency = force_frequencies(int(trials.analysed.sum()), trials.sample_period)
    return xr.Dataset(
        variables, coords={**{name: one[name].variable for name in labels}, "frequency": frequency}
    )


def _forces(trials: Trials, coupling_damping: float) -> dict[str, Any]:
    """Compare the delivered with the intended force of one condition."""
    assert trials.velocity is not None
    assert trials.coupling_force is not None
    completed, analysed = trials.completed[0], trials.analysed
    fidelity = np.full((1, len(completed), 2), np.nan)
    frequency = force_frequencies(int(analysed.sum()), trials.sample_period)
    nothing = np.full(len(frequency), np.nan)
    response = ForceResponse(frequency, nothing, nothing, nothing)
    if completed.any():
        position, velocity, delivered = (
            signal[0, completed][:, analysed]
            for signal in (trials.position, trials.velocity, trials.coupling_force)
        )
        intended = intended_force(position, velocity, float(trials.stiffness[0]), coupling_damping)
        fidelity[0, completed] = force_fidelity(intended, delivered)
        response = force_response(intended, delivered, trials.sample_period)
    return {
        "force_fidelity": (("condition", "trial", "robot"), fidelity),
        "force_gain": (("condition", "frequency"), response.gain[None]),
        "force_phase": (("condition", "frequency"), response.phase[None]),
        "force_coherence": (("condition", "frequency"), response.coherence[None]),
    }


def _ages(one: xr.Dataset, trials: Trials, ages: LongestAges) -> dict[str, Any]:
    """Summarise the ages of one condition over its trials, and how long they are within the verdict."""
    per_robot = ("condition", "robot")
    low, mean, high = (
        one[name].reduce(function, "trial")
        for name, function in (("age_low", _least), ("age_mean", _mean), ("age_high", _largest))
    )
    within = np.full(2, np.nan)
    shortest, longest = ((float(age[0, 0]), float(age[0, 1])) for age in (low, high))
    if np.isfinite([*shortest, *longest]).all():
        limits = ages.longest_ages(float(trials.stiffness[0]), shortest, longest)
        within = _share_within(np.asarray(one["age"].isel(condition=0)), np.asarray(limits))
    return {
        "age_low": low.variable,
        "age_mean": mean.variable,
        "age_high": high.variable,
        "within_age_range": (per_robot, within[None]),
    }


def _share_within(ages: FloatArray, limits: FloatArray) -> FloatArray:
    """Return the share of ages (trial, time, robot) up to the limit of each robot; NaN ages do not count."""
    played = np.isfinite(ages)
    within = (ages <= limits + 1e-9) & played
    with np.errstate(invalid="ignore"):
        share = within.sum(axis=(0, 1)) / played.sum(axis=(0, 1))
    return np.where(np.isnan(limits), np.nan, share)


def _first_trial(one: xr.Dataset) -> dict[str, Any]:
    """Keep the course of the first trial, in single precision."""
    first = one.isel(trial=0)
    account = first["account"] if "account" in first else _no_account(one)
    return {
        "target": one["target"].variable,
        "account": account.variable.astype(np.float32),
        **{name: first[name].variable.astype(np.float32) for name in ("position", "coupling_force")},
    }


def _no_account(one: xr.Dataset) -> xr.DataArray:
    import xarray as xr

    dimensions = ("condition", "time", "robot")
    return xr.DataArray(np.full([one.sizes[name] for name in dimensions], np.nan), dims=dimensions)


def _least(values: FloatArray, axis: int) -> FloatArray:
    return np.asarray(np.fmin.reduce(values, axis=axis))


def _largest(values: FloatArray, axis: int) -> FloatArray:
    return np.asarray(np.fmax.reduce(values, axis=axis))


def _mean(values: FloatArray, axis: int) -> FloatArray:
    """Average what is finite; NaN where nothing is."""
    finite = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(finite, values, 0.0).sum(axis=axis) / finite.sum(axis=axis))
