"""The trials of a live session in the layout of a rehearsal: over condition, trial, time, robot and axis."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._types import FloatArray
from telespring.recording.events import MarkedTrial
from telespring.recording.reports import SIDE_REPORTS
from telespring.recording.signals import SIGNALS, TARGET
from telespring.study.conditions import condition_labels

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["COUPLED", "coupled_span", "trials_dataset"]

#: The state in which the spring acts.
COUPLED = "running"
#: A trial counts as completed if its sites were coupled for this share of it: a missed tick is no end.
_COMPLETED = 0.99
_PER_TRIAL = ("condition", "trial")


def coupled(session: xr.Dataset) -> NDArray[np.bool_]:
    """Whether the spring acted, over time: at all sites that the recording knows."""
    meanings = str(session["phase"].attrs["flag_meanings"]).split()
    phase = np.asarray(session["phase"])
    known = (phase >= 0).any(axis=0)
    if COUPLED not in meanings or not known.any():
        return np.zeros(len(phase), dtype=bool)
    # The first meaning is that of -1.
    return np.asarray((phase[:, known] == meanings.index(COUPLED) - 1).all(axis=1))


def coupled_span(session: xr.Dataset) -> tuple[float, float] | None:
    """Return from when to when (s) the spring acted, pauses included; None if it never did."""
    acted = np.flatnonzero(coupled(session))
    if not acted.size:
        return None
    time = np.asarray(session["time"])
    return float(time[acted[0]]), float(time[acted[-1]])


def trials_dataset(session: xr.Dataset, trials: Sequence[MarkedTrial]) -> xr.Dataset:
    """Lay the trials of a session out as those of a rehearsal.

    Without a marked condition, trials with the same stiffness, to 0.1 N/m, are of one condition. The
    stiffness of a condition is the median of what was wanted, its delay the median age of the partner's
    motion in use.
    """
    import xarray as xr

    time = np.asarray(session["time"])
    acted = coupled(session)
    spans = [slice(*np.searchsorted(time, [trial.begin, trial.end], side="left")) for trial in trials]
    conditions = _conditions(session, trials, spans)
    longest = max((span.stop - span.start for span in spans), default=0)
    most = max((len(members) for _, _, _, members in conditions), default=0)
    shape = (len(conditions), most)
    signals = [*(signal for signal in SIGNALS if np.isfinite(session[signal.name]).any()), TARGET]
    values = {
        signal.name: np.full((*shape, longest, *session[signal.name].shape[1:]), np.nan) for signal in signals
    }
    status, label = np.full(shape, "absent", dtype=object), np.full(shape, "", dtype=object)
    ended_at, begin = np.full(shape, np.nan), np.full(shape, np.nan)
    samples = np.zeros(shape, dtype=np.int64)
    spring_acted = np.zeros((*shape, longest), dtype=bool)
    reports = {report.name: np.full((*shape, 2), np.nan) for report in SIDE_REPORTS}
    participant = [np.full(shape, "", dtype=object) for _ in range(2)]
    for i, (_, _, _, members) in enumerate(conditions):
        for j, member in enumerate(members):
            trial, span = trials[member], spans[member]
            count = span.stop - span.start
            for name, array in values.items():
                array[i, j, :count] = np.asarray(session[name][span])
            status[i, j], label[i, j], begin[i, j], samples[i, j] = (
                "completed",
                trial.label,
                trial.begin,
                count,
            )
            spring_acted[i, j, :count] = acted[span]
            # Without a marker the trial is what there was of the session, pauses and all.
            if trial.is_marked and count and acted[span].mean() < _COMPLETED:
                status[i, j] = "stopped"
                ended_at[i, j] = time[span][int(np.argmin(acted[span]))] - trial.begin
            for report in SIDE_REPORTS:
                reports[report.name][i, j] = report.compute(session, span)
            for robot in range(2):
                participant[robot][i, j] = trial.participants[robot]
    variables: dict[str, Any] = {
        name: ((*_PER_TRIAL, *session[name].dims), array, dict(session[name].attrs))
        for name, array in values.items()
    }
    variables |= {
        report.name: (
            (*_PER_TRIAL, "robot"),
            reports[report.name],
            _attributes(report.units, report.long_name),
        )
        for report in SIDE_REPORTS
    }
    variables |= {
        "status": (_PER_TRIAL, status, _attributes("1", "how the trial ended")),
        "ended_at": (
            _PER_TRIAL,
            ended_at,
            _attributes("s", "time at which the trial ended early; NaN if it was completed"),
        ),
        "spring_acted": (
            (*_PER_TRIAL, "time"),
            spring_acted,
            {"long_name": "whether the spring acted at both sites: the session was not paused"},
        ),
        "samples": (_PER_TRIAL, samples, _attributes("1", "samples of the trial")),
        "begin": (
            _PER_TRIAL,
            begin,
            _attributes("s", "beginning of the trial since the beginning of the recording"),
        ),
        "label": (_PER_TRIAL, label, _attributes("1", "text of the trial's marker")),
        "source": session["source"],
    }
    if any(each.any() for each in participant):
        dyads = np.array(
            [
                " and ".join(dict.fromkeys(filter(None, pair)))
                for pair in zip(*(p.ravel() for p in participant), strict=True)
            ],
            dtype=object,
        ).reshape(shape)
        variables["dyad"] = (_PER_TRIAL, dyads, _attributes("1", "codes of who took part"))
    return xr.Dataset(
        variables,
        coords={
            "condition": ("condition", np.array([name for name, _, _, _ in conditions], dtype=object)),
            "stiffness": (
                "condition",
                np.array([stiffness for _, stiffness, _, _ in conditions], dtype=np.float64),
                _attributes("N/m", "stiffness of the virtual spring; NaN if there is none"),
            ),
            "delay": (
                "condition",
                np.array([delay for _, _, delay, _ in conditions], dtype=np.float64),
                _attributes("s", "median age of the partner's motion in use"),
            ),
            "trial": ("trial", np.arange(1, most + 1), _attributes("1", "number of the trial")),
            "time": (
                "time",
                np.arange(longest) * _step(time),
                _attributes("s", "time since the beginning of the trial"),
            ),
            "robot": session["robot"],
            "axis": session["axis"],
        },
        attrs=dict(session.attrs),
    )


def _attributes(units: str, long_name: str) -> dict[str, Any]:
    return {"units": units, "long_name": long_name}


def _step(time: FloatArray) -> float:
    return float(time[1] - time[0]) if len(time) > 1 else 0.0


def _conditions(
    session: xr.Dataset, trials: Sequence[MarkedTrial], spans: Sequence[slice]
) -> list[tuple[str, float, float, list[int]]]:
    """Group the trials by condition: its name, stiffness (N/m), delay (s) and the places of its trials."""
    stiffness = [_median(session, "wanted_stiffness", span) for span in spans]
    delay = [_median(session, "age", span) for span in spans]
    groups: dict[Any, list[int]] = {}
    for i, trial in enumerate(trials):
        key = trial.condition or (None if math.isnan(stiffness[i]) else round(stiffness[i], 1))
        groups.setdefault(key, []).append(i)
    pairs = []
    for members in groups.values():
        middle, known = (
            np.median([stiffness[i] for i in members]),
            [d for i in members if (d := delay[i]) == d],
        )
        pairs.append((float(middle), float(np.median(known)) if known else 0.0))
    names = condition_labels((None if math.isnan(k) else k, d) for k, d in pairs)
    return [
        (key if isinstance(key, str) else name, *pair, members)
        for (key, members), name, pair in zip(groups.items(), names, pairs, strict=True)
    ]


def _median(session: xr.Dataset, name: str, span: slice) -> float:
    values = np.asarray(session[name][span])
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else math.nan
