"""A MATLAB file of trials: an array of structs, as a MATLAB user would have saved it."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._core import __version__
from telespring._errors import InvalidInput
from telespring._files import replacing
from telespring.exchange.material import (
    Material,
    Session,
    Trial,
    clock_accuracy,
    code_words,
    export_place,
    open_material,
    robot_signals,
    signal_values,
)

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording import SessionRecording

__all__ = ["export_mat"]

#: A variable of a file of version 5 is smaller than this.
_MOST_BYTES = 2**31 - 2**20
#: The text with which such a file begins.
_HEADER = 116
_ENDING = ".mat"


def export_mat(
    source: SessionRecording | xr.Dataset | str | os.PathLike[str],
    file: str | os.PathLike[str],
    *,
    rate: float | None = None,
) -> Path:
    """Write trials, or a live session with its trials, to a MATLAB file (version 5, which Octave reads, too).

    Parameters
    ----------
    source : SessionRecording, xarray.Dataset, str or path
        A rehearsal or recorded trials (path or dataset), or a live session (path or recording).
    file : str or path
        Where to write, ``.mat``. A file there is replaced.
    rate : float, optional
        Samples per second of a live session. Default: all.

    Returns
    -------
    pathlib.Path
        The file. Its variables are `trial` (an array of structs), `session` (of a live session), `units`,
        `meaning` and `about`; docs/formats.md lists their fields. Equal trials give equal bytes.

    Raises
    ------
    telespring.InvalidInput
        If the source has no trials, or more than the format can hold.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> file = ts.export_mat("examples/trials", tempfile.mkdtemp() + "/trials.mat")
    >>> from scipy.io import loadmat
    >>> trial = loadmat(file, simplify_cells=True)["trial"]
    >>> trial[0]["robot"][1]["position"].shape == (len(trial[0]["time"]), 2)
    True
    """
    place = export_place("file", file)
    if place.suffix.lower() != _ENDING:
        raise InvalidInput(
            "file", str(file), f"a name that ends in {_ENDING} is required", f"Write {place}{_ENDING}."
        )
    material = open_material(source, rate)
    variables: dict[str, Any] = {
        "about": _about(material),
        "units": _attributes(material, "units", "1"),
        "meaning": _attributes(material, "long_name", ""),
        "trial": _trials(material.trials),
    }
    if material.session is not None:
        variables["session"] = _session(material.session)
    for name, value in variables.items():
        _check_size(name, value)
    from scipy import io

    with replacing(place) as beside:
        io.savemat(beside, variables, long_field_names=True, do_compression=True, oned_as="column")
        # scipy writes the date there; equal trials shall give equal files.
        with beside.open("r+b") as written:
            text = f"MATLAB 5.0 MAT-file, written by telespring {__version__}"
            written.write(text.encode("ascii", "replace").ljust(_HEADER))
    return place


def struct_array(elements: list[dict[str, Any]]) -> NDArray[Any]:
    """Return an array of structs, 1 × n, whose elements have the same fields."""
    fields = list(elements[0]) if elements else ["number"]
    array = np.empty((1, len(elements)), dtype=[(field, object) for field in fields])
    for place, element in enumerate(elements):
        for field in fields:
            array[field][0, place] = element[field]
    return array


def _about(material: Material) -> dict[str, Any]:
    return {
        "program": f"telespring {__version__}",
        "format": "telespring mat 1",
        "documentation": "docs/formats.md",
        "simulated": material.is_simulated,
        "study": material.study,
    }


def _attributes(material: Material, attribute: str, default: str) -> dict[str, str]:
    """Collect an attribute of all signals, such as their units."""
    found = {
        "units": {"time": "s", "stiffness": "N/m", "delay": "s", "ended_at": "s", "begin": "s"},
        "long_name": {
            "time": "time since the beginning of the trial, or of the session",
            "stiffness": "stiffness of the virtual spring; NaN if there is none",
            "delay": "one-way delay; in a live session the median age of the partner's motion in use",
            "ended_at": "time at which the trial ended early; NaN if it was completed",
            "begin": "beginning of the trial since the beginning of the session",
        },
    }[attribute]
    datasets = [trial.data for trial in material.trials[:1]]
    datasets += [] if material.session is None else [material.session.data]
    for data in datasets:
        for name in (*robot_signals(data), "target"):
            text = str(data[name].attrs.get(attribute, default))
            if attribute == "long_name" and "flag_meanings" in data[name].attrs:
                text = f"{text}: {code_words(data[name])}"
            found.setdefault(name, text)
    return found


def _trials(trials: Sequence[Trial]) -> NDArray[Any]:
    names = robot_signals(*(trial.data for trial in trials))
    return struct_array([_trial(trial, names) for trial in trials])


def _trial(trial: Trial, names: Sequence[str]) -> dict[str, Any]:
    return {
        "number": trial.number,
        "condition": trial.condition,
        "stiffness": trial.stiffness,
        "delay": trial.delay,
        "status": trial.status,
        "ended_at": trial.ended_at,
        "dyad": trial.dyad,
        "begin": trial.begin,
        "time": _column(trial.data["time"]),
        "target": np.asarray(trial.data["target"], dtype=np.float64),
        "robot": _robots(trial.data, names),
    }


def _robots(data: xr.Dataset, names: Sequence[str]) -> NDArray[Any]:
    return struct_array([{name: _two(signal_values(data, name, r)) for name in names} for r in range(2)])


def _two(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values if values.ndim == 2 else values[:, None]


def _column(values: Any) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64).reshape(-1, 1)


def _session(session: Session) -> dict[str, Any]:
    recording = session.recording
    uncertainty, scatter = clock_accuracy(recording)
    return {
        "time": _column(session.data["time"]),
        "target": np.asarray(session.data["target"], dtype=np.float64),
        "robot": _robots(session.data, robot_signals(session.data)),
        "event": struct_array(
            [
                {"time": event.time, "robot": event.side, "name": event.event, "cause": event.cause}
                for event in recording.events
            ]
        ),
        "status": recording.status,
        "whole_until": recording.whole_until,
        "missed": float(recording.missed),
        "clock_uncertainty": uncertainty,
        "clock_scatter": scatter,
        "clock_drift": math.nan if recording.clock is None else recording.clock.drift,
    }


def _check_size(name: str, value: Any) -> None:
    size = _bytes(value)
    if size > _MOST_BYTES:
        raise InvalidInput(
            name,
            f"{size / 1e9:.1f} GB",
            "MATLAB files of version 5 hold up to 2 GB per variable",
            "Keep fewer samples per second (--rate, in Python rate=), or export fewer trials.",
        )


def _bytes(value: Any) -> int:
    if isinstance(value, dict):
        return sum(map(_bytes, value.values()))
    if isinstance(value, np.ndarray) and value.dtype.names is not None:
        return sum(_bytes(value[field][0, i]) for field in value.dtype.names for i in range(value.shape[1]))
    return value.nbytes if isinstance(value, np.ndarray) else 8
