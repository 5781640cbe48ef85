"""The dataset of a rehearsal: all trials with labels and units, as a netCDF file."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from telespring._core import Experiment, Study
from telespring._files import replacing
from telespring._types import FloatArray
from telespring.rehearsal.encoding import (
    REPORTS,
    SIDE_REPORTS,
    STATUSES,
    TARGET,
    Signal,
    round_signal,
    stored_signals,
)
from telespring.rehearsal.identity import RehearsalIdentity
from telespring.rehearsal.schedule import ScheduledTrial
from telespring.rehearsal.store import RehearsalStore
from telespring.rehearsal.trial_file import TrialRecord
from telespring.study.conditions import condition_labels

__all__ = ["write_dataset"]

_PLACE = ("condition", "trial")
_DIMENSIONS = ("condition", "trial", "time", "robot", "axis")


def write_dataset(
    store: RehearsalStore,
    identity: RehearsalIdentity,
    study: Study,
    experiment: Experiment,
    trials: list[ScheduledTrial],
    target: FloatArray,
) -> None:
    """Write the dataset of a finished rehearsal, complete or absent; `target` is (time, axis), m."""
    records = _StoredTrials(store, trials)
    with _dataset_disk_errors(store.dataset), replacing(store.dataset) as temporary:
        labels = _dataset_without_signals(identity, study, experiment, records, target)
        no_fill_value = {name: {"_FillValue": None} for name in ("time", "delay", TARGET.name)}
        labels.to_netcdf(temporary, engine="h5netcdf", encoding=no_fill_value)
        signals = stored_signals(study.session)
        _declare_dataset_signals(temporary, signals, len(experiment.sample_times))
        # Every thread compressed its own trials; here only their bytes are copied.
        with h5py.File(temporary, "r+") as file:
            for trial, record in records:
                for signal in signals:
                    place = (trial.condition, trial.trial, *(0 for _ in _signal_dimensions(signal)[2:]))
                    file[signal.name].id.write_direct_chunk(place, record.chunks[signal.name])


class _StoredTrials:
    """The stored trials in the order of the dataset, read one at a time."""

    def __init__(self, store: RehearsalStore, trials: list[ScheduledTrial]) -> None:
        self._store = store
        self._trials = sorted(trials, key=lambda trial: (trial.condition, trial.trial))

    def __iter__(self) -> Iterator[tuple[ScheduledTrial, TrialRecord]]:
        for trial in self._trials:
            record = self._store.read_trial(trial)
            if record is None:
                raise OSError(
                    None,
                    "a finished trial can no longer be read; run the same command again to repeat it",
                    str(self._store.path),
                )
            yield trial, record


@contextmanager
def _dataset_disk_errors(dataset: Path) -> Iterator[None]:
    """Raise OSError where h5py raises RuntimeError because a write failed."""
    try:
        yield
    except RuntimeError as error:
        number = re.search(r"errno = (\d+)", str(error))
        if number is None:
            raise
        code = int(number[1])
        raise OSError(code, os.strerror(code), str(dataset)) from error


def _dataset_without_signals(
    identity: RehearsalIdentity,
    study: Study,
    experiment: Experiment,
    records: _StoredTrials,
    target: FloatArray,
) -> xr.Dataset:
    conditions = experiment.conditions
    shape = (len(conditions), experiment.trials)
    seed, order = np.zeros(shape, np.uint64), np.zeros(shape, np.int64)
    status, ended_at = np.zeros(shape, np.int8), np.full(shape, np.nan)
    reports = {report.name: np.full(shape, np.nan) for report in REPORTS}
    reports |= {report.name: np.full((*shape, 2), np.nan) for report in SIDE_REPORTS}
    for trial, record in records:
        place = (trial.condition, trial.trial)
        for name, value in record.reports.items():
            reports[name][place] = value
        seed[place], order[place] = trial.seed, trial.order
        status[place] = STATUSES.index(record.status)
        ended_at[place] = np.nan if record.ended_at is None else record.ended_at
    stiffness = [np.nan if k is None else k for k, _ in conditions]
    return xr.Dataset(
        {
            "target": (
                ("time", "axis"),
                round_signal(TARGET, target),
                _variable_attributes(TARGET.units, TARGET.long_name, resolution=TARGET.resolution),
            ),
            "seed": (_PLACE, seed, _variable_attributes("1", "seed of everything random in the trial")),
            "status": (
                _PLACE,
                status,
                _variable_attributes(
                    "1",
                    "how the trial ended",
                    flag_values=np.arange(len(STATUSES), dtype=np.int8),
                    flag_meanings=" ".join(status.replace(" ", "_") for status in STATUSES),
                ),
            ),
            "ended_at": (
                _PLACE,
                ended_at,
                _variable_attributes("s", "time at which the trial ended early; NaN if it was completed"),
            ),
            "order": (_PLACE, order, _variable_attributes("1", "place in the order of running, from 0")),
        }
        | {
            report.name: (
                dimensions,
                reports[report.name],
                _variable_attributes(report.units, report.long_name),
            )
            for kind, dimensions in ((SIDE_REPORTS, (*_PLACE, "robot")), (REPORTS, _PLACE))
            for report in kind
        },
        coords={
            "condition": (
                "condition",
                np.array(condition_labels(conditions), dtype=object),
                _variable_attributes(
                    "1", "UM: unconnected; CM: connected, with stiffness in N/m and one-way delay in ms"
                ),
            ),
            "stiffness": (
                "condition",
                np.array(stiffness, dtype=np.float64),
                _variable_attributes("N/m", "stiffness of the virtual spring; NaN if there is none"),
            ),
            "delay": (
                "condition",
                np.array([delay for _, delay in conditions], dtype=np.float64),
                _variable_attributes("s", "one-way delay, each way"),
            ),
            "trial": ("trial", np.arange(1, shape[1] + 1), _variable_attributes("1", "number of the trial")),
            "time": (
                "time",
                experiment.sample_times,
                _variable_attributes("s", "time since the beginning of the trial"),
            ),
            "robot": ("robot", np.array([1, 2]), _variable_attributes("1", "number of the robot")),
            "axis": ("axis", np.array(["x", "y"], dtype=object), _variable_attributes("1", "axis of motion")),
        },
        attrs=_dataset_attributes(identity, study, experiment),
    )


def _variable_attributes(units: str, long_name: str, **more: Any) -> dict[str, Any]:
    return {"units": units, "long_name": long_name, **more}


def _dataset_attributes(identity: RehearsalIdentity, study: Study, experiment: Experiment) -> dict[str, Any]:
    """List everything that the dataset depends on; no time stamps: equal studies give equal datasets."""
    return identity.to_attributes() | {
        "duration": experiment.duration,
        "discard": experiment.discard,
        "record_rate": experiment.record_rate,
        "sample_period": experiment.sample_period,
        "trials": experiment.trials,
        "master_seed": np.uint64(experiment.seed),
        "order": experiment.order,
        "agents": _attribute_json([agent.to_dict() for agent in experiment.agents]),
        "arms": _attribute_json([arm.to_dict() for arm in experiment.arms]),
        "task": _attribute_json(experiment.task.to_dict()),
        "robots": _attribute_json([_robot_keys(study, index) for index in range(2)]),
        "coupling_damping": experiment.coupling_damping,
        "session": _attribute_json(study.session.to_dict()),
        "laboratory": _attribute_json(
            experiment.settings.to_dict() | {"sample_period": experiment.sample_period}
        ),
    }


def _robot_keys(study: Study, index: int) -> dict[str, Any]:
    """List a robot's keys for the dataset as its study has them, without those at their defaults."""
    robot, name = study.dyad.robots[index], study.robot_names[index]
    friction, uncertainty = study.coulomb[index], study.uncertainty[index]
    keys: dict[str, Any] = {} if name is None else {"name": name}
    keys |= {"axes": robot.axes, "mass": robot.mass.tolist(), "damping": robot.damping.tolist()}
    if friction.any():
        keys["coulomb"] = friction.tolist()
    if uncertainty is not None:
        keys["mass_sd"] = uncertainty.mass_sd.tolist()
        keys["damping_sd"] = uncertainty.damping_sd.tolist()
        keys["mass_damping_correlation"] = uncertainty.correlation.tolist()
    return keys


def _attribute_json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, ensure_ascii=False)


def _signal_dimensions(signal: Signal) -> tuple[str, ...]:
    return _DIMENSIONS if signal.has_axes else _DIMENSIONS[:-1]


def _declare_dataset_signals(path: Path, signals: tuple[Signal, ...], count: int) -> None:
    """Add the variables of the signals to the file, a chunk per trial, without values."""
    with h5netcdf.File(path, "a") as file:
        for signal in signals:
            dimensions = _signal_dimensions(signal)
            variable = file.create_variable(
                signal.name,
                dimensions,
                np.dtype("<f8"),
                chunks=(1, 1, count, 2, 2)[: len(dimensions)],
                compression="gzip",
                compression_opts=1,
                shuffle=True,
                fillvalue=np.nan,
            )
            variable.attrs["units"] = signal.units
            variable.attrs["long_name"] = signal.long_name
            variable.attrs["resolution"] = signal.resolution
