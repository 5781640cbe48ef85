"""One labelled dataset of all trials, as a netCDF file."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from telespring._files import replacing
from telespring._types import FloatArray
from telespring.rehearsal.encoding import SIGNALS, STATUSES, TARGET, rounded
from telespring.rehearsal.identity import Identity
from telespring.rehearsal.schedule import Trial, sample_count, sample_times
from telespring.rehearsal.store import RehearsalFolder
from telespring.rehearsal.trial_file import Record
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    from telespring._core import Experiment, Study

__all__ = ["write_dataset"]

_PLACE = ("condition", "trial")
_DIMENSIONS = ("condition", "trial", "time", "robot", "axis")


def write_dataset(
    home: RehearsalFolder,
    identity: Identity,
    study: Study,
    experiment: Experiment,
    trials: list[Trial],
    target: FloatArray,
) -> None:
    """Make the dataset of finished trials; it is whole or absent.

    Parameters
    ----------
    home
        The folder in which all of them are kept.
    identity
        Of the rehearsal.
    experiment
        Its protocol.
    trials
        All its trials.
    target
        Where the target is in every row of a whole trial, (time, axis), m.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    records = _Records(home, trials)
    with _told_as_disk_trouble(home.dataset), replacing(home.dataset) as beside:
        small = _labels_and_outcomes(identity, study, experiment, records, target)
        none_missing = {name: {"_FillValue": None} for name in ("time", "delay", TARGET.name)}
        small.to_netcdf(beside, engine="h5netcdf", encoding=none_missing)
        count = sample_count(experiment)
        _declare_signals(beside, count)
        # Every thread deflated its own trials; here their bytes are only put in their places.
        with h5py.File(beside, "r+") as file:
            for trial, record in records:
                for signal in SIGNALS:
                    place = (trial.condition, trial.trial, 0, 0, 0)
                    file[signal.name].id.write_direct_chunk(place, record.chunks[signal.name])


class _Records:
    """The kept trials, read one after the other, in the order of the dataset."""

    def __init__(self, home: RehearsalFolder, trials: list[Trial]) -> None:
        self._home = home
        self._trials = sorted(trials, key=lambda trial: (trial.condition, trial.trial))

    def __iter__(self) -> Iterator[tuple[Trial, Record]]:
        for trial in self._trials:
            record = self._home.record(trial)
            if record is None:
                raise OSError(
                    None,
                    "a finished trial can no longer be read; the same command computes it again",
                    str(self._home.path),
                )
            yield trial, record


@contextmanager
def _told_as_disk_trouble(dataset: Path) -> Iterator[None]:
    """Make an OSError of what h5py raises where a write fails: it knows the number, but not the class."""
    try:
        yield
    except RuntimeError as trouble:
        number = re.search(r"errno = (\d+)", str(trouble))
        if number is None:
            raise
        code = int(number[1])
        raise OSError(code, os.strerror(code), str(dataset)) from trouble


def _labels_and_outcomes(
    identity: Identity,
    study: Study,
    experiment: Experiment,
    records: _Records,
    target: FloatArray,
) -> xr.Dataset:
    """Make the dataset without its signals."""
    conditions = experiment.conditions
    shape = (len(conditions), experiment.trials)
    seed, order = np.zeros(shape, np.uint64), np.zeros(shape, np.int64)
    status, ended_at = np.zeros(shape, np.int8), np.full(shape, np.nan)
    for trial, record in records:
        place = (trial.condition, trial.trial)
        seed[place], order[place] = trial.seed, trial.order
        status[place] = STATUSES.index(record.status)
        ended_at[place] = np.nan if record.ended_at is None else record.ended_at
    stiffness = [np.nan if k is None else k for k, _ in conditions]
    return xr.Dataset(
        {
            "target": (
                ("time", "axis"),
                rounded(TARGET, target),
                _described(TARGET.units, TARGET.long_name, resolution=TARGET.resolution),
            ),
            "seed": (_PLACE, seed, _described("1", "seed of everything random in the trial")),
            "status": (
                _PLACE,
                status,
                _described(
                    "1",
                    "how the trial ended",
                    flag_values=np.arange(len(STATUSES), dtype=np.int8),
                    flag_meanings=" ".join(status.replace(" ", "_") for status in STATUSES),
                ),
            ),
            "ended_at": (
                _PLACE,
                ended_at,
                _described("s", "time at which the trial ended early; NaN where it was completed"),
            ),
            "order": (_PLACE, order, _described("1", "place in the order of running, from 0")),
        },
        coords={
            "condition": (
                "condition",
                np.array(condition_labels(conditions), dtype=object),
                _described(
                    "1", "UM: unconnected; CM: connected, with stiffness in N/m and one-way delay in ms"
                ),
            ),
            "stiffness": (
                "condition",
                np.array(stiffness, dtype=np.float64),
                _described("N/m", "stiffness of the virtual spring; NaN where there is none"),
            ),
            "delay": (
                "condition",
                np.array([delay for _, delay in conditions], dtype=np.float64),
                _described("s", "one-way delay, each way"),
            ),
            "trial": ("trial", np.arange(1, shape[1] + 1), _described("1", "number of the trial")),
            "time": (
                "time",
                sample_times(experiment),
                _described("s", "time since the beginning of the trial"),
            ),
            "robot": ("robot", np.array([1, 2]), _described("1", "number of the robot")),
            "axis": ("axis", np.array(["x", "y"], dtype=object), _described("1", "axis of motion")),
        },
        attrs=_attributes(identity, study, experiment),
    )


def _described(units: str, long_name: str, **more: Any) -> dict[str, Any]:
    return {"units": units, "long_name": long_name, **more}


def _attributes(identity: Identity, study: Study, experiment: Experiment) -> dict[str, Any]:
    """Everything that the dataset was made from; no time stamps, so that the same study gives the same."""
    return identity.to_attributes() | {
        "duration": experiment.duration,
        "discard": experiment.discard,
        "record_rate": experiment.record_rate,
        "sample_period": experiment.sample_period,
        "trials": experiment.trials,
        "master_seed": np.uint64(experiment.seed),
        "order": experiment.order,
        "agents": _json([agent.to_dict() for agent in experiment.agents]),
        "arms": _json([arm.to_dict() for arm in experiment.arms]),
        "task": _json(experiment.task.to_dict()),
        "robots": _json([_robot_keys(study, index) for index in range(2)]),
        "coupling_damping": experiment.coupling_damping,
        "laboratory": _json(experiment.settings.to_dict() | {"sample_period": experiment.sample_period}),
    }


def _robot_keys(study: Study, index: int) -> dict[str, Any]:
    """List the keys that a robot has in the text of its study, where those at their defaults are left out."""
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


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, ensure_ascii=False)


def _declare_signals(path: Path, count: int) -> None:
    """Add the signals to the file, a chunk per trial, without values."""
    with h5netcdf.File(path, "a") as file:
        for signal in SIGNALS:
            variable = file.create_variable(
                signal.name,
                _DIMENSIONS,
                np.dtype("<f8"),
                chunks=(1, 1, count, 2, 2),
                compression="gzip",
                compression_opts=1,
                shuffle=True,
                fillvalue=np.nan,
            )
            variable.attrs["units"] = signal.units
            variable.attrs["long_name"] = signal.long_name
            variable.attrs["resolution"] = signal.resolution
