"""What a live session shows: the measures of a rehearsal, and what network, guard and loop did."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from telespring._arrays import as_number
from telespring._json import finite_or_none
from telespring._quantities import format_count, format_time
from telespring._types import FloatArray
from telespring.analysis.measures import MEASURES, measure_trials
from telespring.analysis.results import compare_conditions
from telespring.analysis.trials import Trials
from telespring.recording import MarkedTrial, SessionRecording, read_recording
from telespring.recording.reports import SIDE_REPORTS
from telespring.recording.trials import coupled, trials_dataset

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["analyse_recording", "analyse_session", "recording_facts", "session_trials"]

#: Signals of each side that are described by quantiles: name in the result and in the dataset.
_DISTRIBUTIONS = {
    "age": "age",
    "round_trip": "round_trip",
    "playout_delay": "playout_delay",
    "lateness": "lateness",
    "latency_device": "latency_device",
    "latency_loop": "latency_loop",
    "latency_network": "latency_network",
    "latency_playout": "latency_playout",
}
#: The measures that need the target.
_OF_TARGET = ("tracking_error", "lag", "lag_correlation")


def analyse_recording(
    recording: SessionRecording | str | os.PathLike[str],
    discard: float | None = None,
    baseline: str | None = None,
) -> dict[str, Any]:
    """Measure a live session: what the people did, and what network, guard and loop did meanwhile.

    Parameters
    ----------
    recording : SessionRecording, str or path
        A recording, or its file: of one site, or merged of both.
    discard : float, optional
        Duration to leave out at the start of every trial, s. Default: nothing.
    baseline : str, optional
        Condition whose TE2 is the reference of the comparisons. Default: the unconnected mode.

    Returns
    -------
    dict
        The contents of `analysis.json` of a session, in SI units; docs/recording.md lists its keys. None is
        not known: with one site's file nothing is known of the other's force, account and network.

    Raises
    ------
    telespring.InvalidInput
        If the file is no recording, or the spring never acted.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import telespring as ts
    >>> found = ts.analyse_recording("session.mcap")
    >>> found["recording"]["status"], found["session"]["robot1"]["source"]
    ('complete', 'recorded')
    >>> found["session"]["robot1"]["tracking_error"] < 0.1  # m
    True
    """
    if not isinstance(recording, SessionRecording):
        recording = read_recording(recording)
    if discard is not None:
        discard = as_number("discard", discard)
    session = recording.dataset()
    return analyse_session(recording, session, discard, baseline)


def analyse_session(
    recording: SessionRecording,
    session: xr.Dataset,
    discard: float | None = None,
    baseline: str | None = None,
) -> dict[str, Any]:
    """Measure a session whose dataset has been made; see `analyse_recording`."""
    trials = recording.marked_trials(session)
    if not trials:
        recording.trials()  # refuses it
    whole = MarkedTrial("session", "", ("", ""), trials[0].begin, trials[-1].end, is_marked=False)
    laid_out = trials_dataset(session, trials)
    has_marks = any(trial.is_marked for trial in trials)
    experiment, notes = _experiment(laid_out, discard, baseline) if has_marks else (None, [])
    return {
        "schema": "telespring session analysis 1",
        **recording_facts(recording),
        "session": _measured(trials_dataset(session, [whole]), None if has_marks else discard)[0]
        | {"network": _network(session)},
        "trials": _measured(laid_out, discard) if has_marks else [],
        "experiment": experiment,
        "events": [
            {"time": event.time, "side": event.side, "event": event.event, "cause": event.cause or None}
            for event in recording.events
        ],
        "warnings": [*_warnings(recording), *notes],
    }


def session_trials(
    dataset: xr.Dataset, discard: float | None = None, *, robot: int | None = None
) -> tuple[Trials, NDArray[np.bool_]]:
    """Lay the trials of a session out for the measures, and say of which robots each trial knows the motion.

    Each person has a target of their own: both started the same one, but at their own time. With `robot` (0
    or 1) the target is its own; without, it is that of robot 1, and robot 2 is moved by the difference of
    both, so that each is as far from the target as it was from its own. Samples at which the spring did not
    act, or at which a robot of known motion has a gap, are not analysed.
    """
    if "own_target" in dataset:
        own = dataset["own_target"]
        has_own = np.isfinite(np.asarray(own)).any(axis=(0, 1, 2, 4))
        if robot is not None and has_own[robot]:
            dataset = dataset.assign(target=own.isel(robot=robot, drop=True))
        elif robot is None:
            apart = (own - dataset["target"]).fillna(0.0).transpose(*dataset["position"].dims)
            dataset = dataset.assign(position=dataset["position"] - apart)
    position = np.asarray(dataset["position"])
    finite = np.isfinite(position).all(axis=-1)
    known = finite.any(axis=2)
    complete: NDArray[np.bool_] = np.asarray((finite | ~known[:, :, None, :]).all(axis=-1))
    target = np.isfinite(np.asarray(dataset["target"])).all(axis=-1)
    if target.any():
        complete &= target
    names = [name for name in ("position", "velocity", "coupling_force", "target") if name in dataset]
    filled = dataset.assign({name: dataset[name].fillna(0.0) for name in names})
    trials = Trials.from_dataset(filled, discard)
    return replace(trials, window=trials.window & complete & np.asarray(dataset["spring_acted"])), known


def _measured(dataset: xr.Dataset, discard: float | None) -> list[dict[str, Any]]:
    """Measure the trials of a session, in the order in which they were."""
    trials, known = session_trials(dataset, discard, robot=0)
    measured = [measure_trials(trials), measure_trials(session_trials(dataset, discard, robot=1)[0])]
    has_target = (
        np.isfinite(np.asarray(dataset["own_target"])).any(axis=(0, 1, 2, 4))
        if "own_target" in dataset
        else np.zeros(2, dtype=bool)
    )
    is_recorded = np.asarray(dataset["source"]) == "recorded"
    rows = []
    for i, j in np.argwhere(trials.status != "absent").tolist():
        row: dict[str, Any] = {
            "label": str(dataset["label"].values[i, j]),
            "condition": trials.labels[i],
            "dyad": str(dataset["dyad"].values[i, j]) if "dyad" in dataset else None,
            "begin": float(dataset["begin"].values[i, j]),
            "duration": int(dataset["samples"].values[i, j]) * trials.sample_period,
            "status": str(trials.status[i, j]),
            "stiffness": finite_or_none(trials.stiffness[i]),
            "delay": finite_or_none(trials.delay[i]),
            "analysed": float(trials.window[i, j].sum() * trials.sample_period),
        }
        for robot in range(2):
            values: dict[str, Any] = {"source": str(np.asarray(dataset["source"])[robot])}
            for name in MEASURES:
                if name not in measured[robot]:
                    continue
                is_known = is_recorded[robot] if name.startswith("interaction") else known[i, j, robot]
                is_known &= has_target[robot] or name not in _OF_TARGET
                value = float(measured[robot][name].values[i, j, robot])
                values[name] = finite_or_none(value) if is_known else None
            for report in SIDE_REPORTS:
                values[report.name] = finite_or_none(float(dataset[report.name].values[i, j, robot]))
            values |= _levels(dataset, i, j, robot)
            row[f"robot{robot + 1}"] = values
        rows.append(row)
    return sorted(rows, key=lambda row: row["begin"])


def _levels(dataset: xr.Dataset, condition: int, trial: int, robot: int) -> dict[str, float | None]:
    """Describe the stiffness that was in use while the spring acted, and the account."""
    acted = np.asarray(dataset["spring_acted"][condition, trial])

    def known(name: str, when: NDArray[np.bool_]) -> FloatArray:
        if name not in dataset:
            return np.zeros(0)
        values = np.asarray(dataset[name][condition, trial, :, robot])[when]
        return np.asarray(values[np.isfinite(values)])

    in_use, account = known("stiffness_in_use", acted), known("account", np.ones_like(acted))
    return {
        "stiffness_mean": float(in_use.mean()) if in_use.size else None,
        "stiffness_least": float(in_use.min()) if in_use.size else None,
        "account_end": float(account[-1]) if account.size else None,
        "account_least": float(account.min()) if account.size else None,
    }


def _network(session: xr.Dataset) -> dict[str, Any]:
    """Describe ages, latencies and losses of each side while the spring acted."""
    acted = coupled(session)
    described: dict[str, Any] = {}
    for robot in range(2):
        values: dict[str, Any] = {}
        for name, variable in _DISTRIBUTIONS.items():
            signal = np.asarray(session[variable][:, robot])[acted]
            values[name] = _quantiles(signal[np.isfinite(signal)])
        lost, received = (_growth(session, name, robot) for name in ("packets_lost", "packets_received"))
        total = None if lost is None or received is None else lost + received
        values["loss"] = {
            "lost": lost,
            "received": received,
            "share": lost / total if total and lost is not None else None,
        }
        described[f"robot{robot + 1}"] = values
    return described


def _quantiles(known: FloatArray) -> dict[str, float] | None:
    if not known.size:
        return None
    middle, high = np.quantile(known, [0.5, 0.99])
    return {
        "smallest": float(known.min()),
        "median": float(middle),
        "quantile_99": float(high),
        "largest": float(known.max()),
    }


def _growth(session: xr.Dataset, name: str, robot: int) -> int | None:
    values = np.asarray(session[name][:, robot])
    known = values[np.isfinite(values)]
    return int(known[-1] - known[0]) if known.size else None


def _experiment(
    dataset: xr.Dataset, discard: float | None, baseline: str | None
) -> tuple[dict[str, Any] | None, list[str]]:
    """Compare the conditions of the marked trials as those of a rehearsal; None, and why, if that fails."""
    trials, known = session_trials(dataset, discard)
    if not (np.asarray(dataset["source"]) == "recorded").all():
        return None, [
            "Conditions are compared from both sites' recordings only: merge them (telespring merge)."
        ]
    if not np.isfinite(np.asarray(dataset["target"])).any():
        return None, ["No target was recorded: there is no tracking error to compare."]
    usable = trials.completed & known.all(axis=-1) & (trials.window.sum(axis=-1) > 1)
    if usable.sum() < 2:
        return None, []
    return compare_conditions(
        replace(trials, status=np.where(usable, trials.status, "stopped")), baseline
    ), []


def recording_facts(recording: SessionRecording) -> dict[str, Any]:
    """Say how whole a recording is, and how exact the common time of its sites."""
    return {
        "recording": _recording_facts(recording),
        "clock": _clock_facts(recording),
        "streams": _stream_facts(recording),
        "warnings": _warnings(recording),
    }


def _recording_facts(recording: SessionRecording) -> dict[str, Any]:
    return {
        "status": recording.status,
        "duration": recording.duration,
        "whole_until": recording.whole_until,
        "sample_period": recording.sample_period,
        "missed": recording.missed,
        "sites": [
            {
                "side": number,
                "file": side.path.name,
                "status": side.status,
                "ticks": len(side.ticks),
                "missing_ticks": side.missing_ticks,
                "missed": side.missed,
                "lost_bytes": side.lost_bytes,
                "damaged_chunks": side.damaged_chunks,
                "session": side.session,
                "program_version": side.metadata["telespring"].get("program_version"),
            }
            for number, side in recording.sides.items()
        ],
    }


def _clock_facts(recording: SessionRecording) -> dict[str, Any] | None:
    clock = recording.clock
    if clock is None:
        return None
    return {
        "uncertainty": clock.uncertainty,
        "drift": finite_or_none(clock.drift),
        "is_linear": clock.is_linear,
        "disagreement": clock.disagreement * 1e-9,
    }


def _stream_facts(recording: SessionRecording) -> list[dict[str, Any]] | None:
    """List the streams of an XDF file, and how the recorder's clock differs from theirs; None without."""
    if not recording.streams:
        return None
    return [
        {
            "side": number,
            "name": stream.name,
            "host": stream.host or None,
            "samples": stream.samples,
            "clock_offset": stream.clock.line[0] if stream.clock.time.size else None,
            "clock_drift": stream.clock.line[1] if stream.clock.time.size else None,
            "clock_scatter": stream.clock.scatter if stream.clock.time.size else None,
            "clock_offsets": [
                {"time": time, "offset": offset}
                for time, offset in zip(stream.clock.time.tolist(), stream.clock.offset.tolist(), strict=True)
            ],
        }
        for number, stream in recording.streams.items()
    ]


def _warnings(recording: SessionRecording) -> list[str]:
    found = []
    for number, side in recording.sides.items():
        if side.status == "truncated":
            lost = f"; {side.lost_bytes / 1000:.0f} kB behind that are lost" if side.lost_bytes else ""
            damaged = f"; {format_count(side.damaged_chunks, 'part')} of it cannot be read"
            until = float(recording.seconds(number, side.time[-1:])[0])
            found.append(
                f"Site {number} did not end its recording: it is whole until {format_time(until)}{lost}"
                f"{damaged if side.damaged_chunks else ''}."
            )
        if side.missed or side.missing_ticks:
            found.append(
                f"Site {number}: {format_count(side.missing_ticks, 'tick')} not recorded, and "
                f"{format_count(side.missed, 'item')} counted as missed."
            )
    clock = recording.clock
    if clock is not None and clock.disagreement > 0.0:
        found.append(
            f"The sites contradict each other's clocks by {format_time(clock.disagreement * 1e-9, 3)}: a "
            "clock was set, or runs too fast. Times of one site against the other's are in doubt."
        )
    if clock is not None and recording.streams:
        found.append(
            "The clocks of both sites were compared by the recorder of the XDF file, which states no bound: "
            f"its offsets scatter by {format_time(clock.uncertainty, 2, rounding='up')}."
        )
    if len(recording.sides) == 1:
        found.append(_only_one_site(recording))
    return found


def _only_one_site(recording: SessionRecording) -> str:
    side = recording.first
    only = f"Only site {side.side} is known: of robot {3 - side.side}"
    error = side.clock_estimates().error
    if not len(side.packets) or not error.size:
        return f"{only} nothing was received."
    known = format_time(float(np.median(error)) * 1e-9, 2, rounding="up")
    return f"{only} there is what its packets told, motion only, at times known to {known}."
