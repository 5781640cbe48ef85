"""What is exported: trials of a rehearsal, recorded trials or a live session, opened in one form."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._arrays import quoted_value
from telespring._errors import InvalidInput
from telespring.analysis.sources import open_trials
from telespring.analysis.trials import Trials
from telespring.recording import SessionRecording, is_recording, read_recording

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording import MarkedTrial

__all__ = [
    "Material",
    "Session",
    "Trial",
    "clock_accuracy",
    "code_words",
    "export_place",
    "open_material",
    "robot_signals",
    "signal_values",
]


#: The order of robots and axes in every export.
_LABELS: dict[str, list[Any]] = {"robot": [1, 2], "axis": ["x", "y"]}


@dataclass(frozen=True, eq=False)
class Trial:
    """One trial.

    Attributes
    ----------
    data
        Its signals over time (s since its beginning), robot and axis.
    number
        Its number or label.
    condition, stiffness, delay
        Name, N/m (NaN unconnected) and s (NaN where not known) of its condition.
    status, ended_at
        How it ended, and when if it ended early (s, NaN otherwise).
    dyad
        The label of the two people; "" if the data do not say.
    begin
        s since the beginning of the recording; NaN for a trial that is a recording of its own.
    """

    data: xr.Dataset
    number: str
    condition: str
    stiffness: float
    delay: float
    status: str
    ended_at: float
    dyad: str
    begin: float

    @property
    def duration(self) -> float:
        """From the first sample to one period after the last, s."""
        time = np.asarray(self.data["time"])
        step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
        return float(time[-1] - time[0]) + step


@dataclass(frozen=True, eq=False)
class Session:
    """A live session as one recording.

    Attributes
    ----------
    recording
        What was read.
    data
        All of it over time (s since the beginning of the recording), robot and axis.
    marked
        The trials that its markers name; without any, all the time in which the spring acted.
    date
        When it began, ns since 1970 by the clock of the first site; None if that is not known.
    """

    recording: SessionRecording
    data: xr.Dataset
    marked: tuple[MarkedTrial, ...]
    date: int | None


@dataclass(frozen=True, eq=False)
class Material:
    """Everything that is exported.

    Attributes
    ----------
    trials
        In the order of conditions, and of trials in each.
    session
        The recording that the trials are part of; None if each is a recording of its own.
    is_simulated
        Whether a simulation made the trials.
    study
        The text of the study; "" if it is not known.
    """

    trials: tuple[Trial, ...]
    session: Session | None
    is_simulated: bool
    study: str


def export_place(name: str, place: object) -> Path:
    """Return where an export goes; InvalidInput if that is no path."""
    if not isinstance(place, str | os.PathLike):
        raise InvalidInput(name, repr(place), "a path", "Name where the export is to be written.")
    return Path(place)


def open_material(source: Any, rate: float | None = None) -> Material:
    """Open what is to be exported; `rate` is that of a live session's samples, Hz.

    InvalidInput where it is none, or has no trial.
    """
    import xarray as xr

    if isinstance(source, SessionRecording):
        return _of_session(source, rate)
    if isinstance(source, (str, os.PathLike)) and is_recording(source):
        return _of_session(read_recording(source), rate)
    if rate is not None:
        raise InvalidInput(
            "rate",
            f"{rate:g}",
            "only the samples of a live session can be made fewer here",
            "Leave it out: trials keep their samples.",
        )
    if isinstance(source, (str, os.PathLike)):
        return _of_trials(open_trials(Path(source)))
    if isinstance(source, xr.Dataset):
        return _of_trials(source)
    raise InvalidInput(
        "source",
        quoted_value(source),
        "a file or folder of trials, a recording of a live session or a dataset of trials is required",
        "Give the path of a .nc or .mcap file, or what telespring.read_recording returns.",
    )


def _of_session(recording: SessionRecording, rate: float | None) -> Material:
    data = recording.dataset(rate)
    marked = recording.marked_trials(data)
    trials: tuple[Trial, ...] = ()
    if marked:
        trials = tuple(_trials(recording.trials(rate)))
    zero = recording.first.wall_time_zero
    return Material(
        trials=trials,
        session=Session(recording, data, tuple(marked), zero + recording.begin if zero else None),
        is_simulated=False,
        study=recording.first.study,
    )


def _of_trials(dataset: xr.Dataset) -> Material:
    checked = Trials.from_dataset(dataset)
    return Material(
        trials=tuple(_trials(dataset, checked)),
        session=None,
        is_simulated=checked.is_simulated,
        study=str(dataset.attrs.get("study", "")),
    )


def _trials(dataset: xr.Dataset, checked: Trials | None = None) -> list[Trial]:
    """Cut a dataset over conditions and trials into its trials; absent ones are left out."""
    shape = (dataset.sizes.get("condition", 1), dataset.sizes.get("trial", 1))
    names = {name: 1 for name in ("condition", "trial") if name not in dataset.dims}
    dataset = dataset.expand_dims(names) if names else dataset
    dataset = dataset.sel({name: values for name, values in _LABELS.items() if name in dataset.coords})
    status = np.asarray(dataset["status"]) if checked is None else checked.status
    found = []
    for i, j in np.ndindex(*shape):
        if status[i, j] == "absent":
            continue
        data = dataset.isel(condition=i, trial=j).transpose(
            "time", "robot", "axis", ..., missing_dims="ignore"
        )
        data = data.isel(time=slice(0, _sample_count(data)))
        ended_at = float(data["ended_at"]) if "ended_at" in data else math.nan
        found.append(
            Trial(
                data=data,
                number=str(data["label"].item())
                if "label" in data
                else str(np.asarray(_numbers(dataset, checked))[i, j]),
                condition=str(np.asarray(dataset["condition"])[i]) if checked is None else checked.labels[i],
                stiffness=float(np.asarray(dataset["stiffness"]).reshape(-1)[i]),
                delay=float(np.asarray(dataset["delay"]).reshape(-1)[i]),
                status=str(status[i, j]),
                ended_at=ended_at,
                dyad=_dyad(data, checked, i, j),
                begin=float(data["begin"]) if "begin" in data else math.nan,
            )
        )
    return found


def _numbers(dataset: xr.Dataset, checked: Trials | None) -> NDArray[Any]:
    if checked is not None:
        return checked.numbers
    return np.broadcast_to(np.asarray(dataset["trial"]), np.asarray(dataset["status"]).shape)


def _dyad(data: xr.Dataset, checked: Trials | None, i: int, j: int) -> str:
    if checked is not None:
        return "" if checked.dyads is None else str(checked.dyads[i, j])
    return str(data["dyad"].item()) if "dyad" in data else ""


def _sample_count(data: xr.Dataset) -> int:
    """Return how many samples a trial has: as it says, or up to its last number."""
    if "samples" in data:
        return int(data["samples"])
    known = np.flatnonzero(np.isfinite(np.asarray(data["position"])).any(axis=(1, 2)))
    return int(known[-1]) + 1 if known.size else data.sizes["time"]


def clock_accuracy(recording: SessionRecording) -> tuple[float, float]:
    """Return the largest error of both sites' common time, and the scatter that is all an XDF file has of it.

    Both in s; NaN is not known. 0 where one clock stamped everything.
    """
    clock = recording.clock
    if clock is None:
        return 0.0 if len(recording.sides) == 1 else math.nan, math.nan
    is_bounded = not any(stream.clock.time.size for stream in recording.streams.values())
    return (clock.uncertainty, math.nan) if is_bounded else (math.nan, clock.uncertainty)


def robot_signals(*datasets: xr.Dataset) -> list[str]:
    """List the variables over time and robot that have a value in one of the datasets, in their order."""
    found: dict[str, None] = {}
    for data in datasets:
        for name, variable in data.data_vars.items():
            if variable.dims[:2] != ("time", "robot") or variable.dtype.kind not in "fiub":
                continue
            if (np.isfinite(variable) if variable.dtype.kind == "f" else np.asarray(variable) >= 0).any():
                found[str(name)] = None
    return list(found)


def signal_values(data: xr.Dataset, name: str, robot: int) -> NDArray[np.float64]:
    """Return a signal of one robot (0 or 1), (time, axis) or (time); codes that are not known are NaN."""
    variable = data[name]
    values = np.asarray(variable.isel(robot=robot)).astype(np.float64)
    if "flag_values" in variable.attrs:
        values[values < 0] = np.nan
    return values


def code_words(variable: xr.DataArray) -> str:
    """Say what the codes of a variable mean, such as "0 connecting, 1 running"."""
    codes = np.asarray(variable.attrs["flag_values"]).tolist()
    words = str(variable.attrs["flag_meanings"]).split()
    pairs = [(code, word) for code, word in zip(codes, words, strict=False) if code >= 0]
    return ", ".join(f"{code} {word.replace('_', ' ')}" for code, word in pairs)
