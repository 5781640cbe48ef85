"""From trials or a session to the runs of a BIDS dataset: what two people did together, on one clock."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring.exchange.bids.labels import bids_label
from telespring.exchange.material import Material, Session, Trial, clock_accuracy

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording import MarkedTrial, SessionRecording

__all__ = ["BidsEvent", "Run", "material_runs", "mean_period"]


@dataclass(frozen=True)
class BidsEvent:
    """A line of an events file.

    Attributes
    ----------
    onset, duration
        s, from the first sample of the run.
    kind
        "trial", or what happened.
    value
        The label of the trial, or why it happened.
    robot
        At which site; None for both.
    condition, stiffness, delay, status
        Of a trial; "" and NaN otherwise.
    """

    onset: float
    duration: float
    kind: str
    value: str = ""
    robot: int | None = None
    condition: str = ""
    stiffness: float = math.nan
    delay: float = math.nan
    status: str = ""


@dataclass(frozen=True, eq=False)
class Run:
    """Signals of two people on one clock.

    Attributes
    ----------
    data
        Over time (s), robot and axis.
    people
        Labels of who held robots 1 and 2.
    robots
        Robots (0 and 1) whose own site recorded them.
    acquisition
        Label of the condition; "" where a run has several.
    number
        Number of the run, from 1, among those with the same people and acquisition.
    dyad
        The label of the dyad.
    events
        In the order of time.
    date
        Of the first sample, ns since 1970; None if it is not known.
    rates
        Ticks per second of each robot's site, Hz; NaN where the samples themselves are all that is known.
    clock_uncertainty
        s; 0 where one clock stamped both, NaN where it is not known.
    clock_scatter
        s; of the comparisons of both clocks, where no bound of their error is known; NaN otherwise.
    """

    data: xr.Dataset
    people: tuple[str, str]
    robots: tuple[int, ...]
    acquisition: str
    number: int
    dyad: str
    events: tuple[BidsEvent, ...]
    date: int | None
    rates: tuple[float, float]
    clock_uncertainty: float
    clock_scatter: float = math.nan

    @property
    def period(self) -> float:
        """The mean time between two samples, s."""
        return mean_period(np.asarray(self.data["time"]))

    @property
    def duration(self) -> float:
        """From the first sample to one period after the last, s."""
        time = np.asarray(self.data["time"])
        return float(time[-1] - time[0]) + self.period


def mean_period(time: NDArray[np.float64]) -> float:
    """Return the mean time between two samples, s; NaN of a single one."""
    return float(time[-1] - time[0]) / (len(time) - 1) if len(time) > 1 else math.nan


def material_runs(material: Material, people: tuple[str, str] | None) -> list[Run]:
    """Return the runs: one for each trial that is a recording of its own, else one for the same people.

    `people` names who held robots 1 and 2, where the data do not say.
    """
    if material.session is not None:
        return _session_runs(material.session, material.trials, people)
    counts: dict[tuple[tuple[str, str], str], int] = {}
    acquisitions = _acquisitions(trial.condition for trial in material.trials)
    runs = []
    for trial in material.trials:
        labels = people or _people_of_dyad(trial.dyad)
        acquisition = acquisitions[trial.condition]
        number = counts[labels, acquisition] = counts.get((labels, acquisition), 0) + 1
        time = np.asarray(trial.data["time"])
        runs.append(
            Run(
                data=trial.data.assign_coords(time=time - time[0]),
                people=labels,
                robots=(0, 1),
                acquisition=acquisition,
                number=number,
                dyad=_dyad_label(trial.dyad, labels),
                events=(_trial_event(trial, 0.0),),
                date=None,
                rates=(math.nan, math.nan),
                clock_uncertainty=0.0,
            )
        )
    return runs


def _acquisitions(conditions: Iterable[str]) -> dict[str, str]:
    """Label each condition; labels that are alike without their signs are numbered."""
    labels: dict[str, str] = {}
    for condition in dict.fromkeys(conditions):
        label = plain = bids_label(condition, "condition")
        number = 2
        while label.casefold() in {other.casefold() for other in labels.values()}:
            label, number = f"{plain}x{number}", number + 1
        labels[condition] = label
    return labels


def _people_of_dyad(dyad: str) -> tuple[str, str]:
    """Name two people of whom only the dyad, or nothing, is known."""
    prefix = bids_label(dyad, "dyad") if dyad else ""
    return f"{prefix}robot1", f"{prefix}robot2"


def _dyad_label(dyad: str, people: tuple[str, str]) -> str:
    return dyad or "+".join(people)


def _trial_event(trial: Trial, onset: float) -> BidsEvent:
    return BidsEvent(
        onset,
        trial.duration,
        "trial",
        trial.number,
        condition=trial.condition,
        stiffness=trial.stiffness,
        delay=trial.delay,
        status=trial.status,
    )


def _session_runs(session: Session, trials: Sequence[Trial], people: tuple[str, str] | None) -> list[Run]:
    """Split a session where other people take over: a run of its own for each stay of a pair."""
    time = np.asarray(session.data["time"])
    recording = session.recording
    spans = _stays(session.marked, people, float(time[-1]), _changed(recording))
    rates = [math.nan, math.nan]
    for number, side in recording.sides.items():
        if len(side.time) > 1:
            rates[number - 1] = 1e9 * (len(side.time) - 1) / float(side.time[-1] - side.time[0])
    sources = np.asarray(session.data["source"])
    uncertainty, scatter = clock_accuracy(recording)
    counts: dict[tuple[str, str], int] = {}
    runs = []
    for labels, begin, end in spans:
        number = counts[labels] = counts.get(labels, 0) + 1
        first, last = np.searchsorted(time, [begin, end], side="left")
        data = session.data.isel(time=slice(int(first), int(last) + 1))
        zero = float(time[first])
        marks = [_trial_event(trial, trial.begin - zero) for trial in trials if begin <= trial.begin <= end]
        happened = [
            BidsEvent(event.time - zero, 0.0, event.event, event.cause, event.side)
            for event in recording.events
            if begin <= event.time <= end
        ]
        runs.append(
            Run(
                data=data.assign_coords(time=np.asarray(data["time"]) - zero),
                people=labels,
                robots=tuple(i for i in range(2) if str(sources[i]) == "recorded"),
                acquisition="",
                number=number,
                dyad=_dyad_label("", labels),
                events=tuple(sorted([*marks, *happened], key=lambda event: event.onset)),
                date=None if session.date is None else session.date + round(1e9 * zero),
                rates=(rates[0], rates[1]),
                clock_uncertainty=uncertainty,
                clock_scatter=scatter,
            )
        )
    return runs


def _changed(recording: SessionRecording) -> str:
    """Name the people of a robot for which the markers name several; "" if there is none."""
    for robot in (1, 2):
        named: dict[str, str] = {}
        for _, side, kind, text in sorted(recording.marks()):
            if kind == "participant" and side == robot:
                named.setdefault("".join(filter(str.isalnum, text)), text)
        if len(named) > 1:
            return f"{' and '.join(named.values())} at robot {robot}"
    return ""


def _stays(
    marked: Sequence[MarkedTrial], people: tuple[str, str] | None, end: float, changed: str
) -> list[tuple[tuple[str, str], float, float]]:
    """Return each pair of people with the time in which it was at the robots; all of it if there is one.

    Of others, whom `changed` names, nothing goes to that one.
    """
    if changed and people is None and not any(trial.is_marked for trial in marked):
        raise InvalidInput(
            "participants",
            changed,
            "a session of two people, or markers of trials, are required: only those say whose motion it is",
            "Name the two people of the whole session, as in --participants P01,P02.",
        )
    stays: list[tuple[tuple[str, str], float, float]] = []
    for trial in marked:
        labels = _people_of_trial(trial.participants, people)
        if stays and stays[-1][0] == labels:
            stays[-1] = labels, stays[-1][1], trial.end
        else:
            stays.append((labels, trial.begin, trial.end))
    if len(stays) < 2 and (people is not None or not changed):
        labels = stays[0][0] if stays else people or _people_of_dyad("")
        return [(labels, 0.0, end)]
    return stays


def _people_of_trial(codes: tuple[str, str], people: tuple[str, str] | None) -> tuple[str, str]:
    if people is not None:
        return people
    unknown = _people_of_dyad("")
    labels = [bids_label(code, "participant") if code else unknown[i] for i, code in enumerate(codes)]
    return labels[0], labels[1]
