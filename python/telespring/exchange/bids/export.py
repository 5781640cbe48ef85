"""Writes a motion-BIDS dataset, or adds a session to one."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from telespring._arrays import quoted_value
from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.exchange.bids import sidecars
from telespring.exchange.bids.channels import channels
from telespring.exchange.bids.labels import bids_label, check_distinct
from telespring.exchange.bids.runs import Run, material_runs
from telespring.exchange.bids.tables import (
    append_rows,
    cell,
    read_json,
    read_table,
    write_json,
    write_samples,
    write_table,
)
from telespring.exchange.material import Material, export_place, open_material

if TYPE_CHECKING:
    import xarray as xr

    from telespring.recording import SessionRecording

__all__ = ["BidsExport", "export_bids"]

_EVENT_COLUMNS = tuple(sidecars.EVENTS)
_SCAN_COLUMNS = tuple(sidecars.SCANS)
_CHANNEL_COLUMNS = ("name", "component", "type", "tracked_point", "units", "reference_frame", "description")
#: A date that is not to be known is of a year before 1925: so BIDS marks it.
_HIDDEN = datetime(1900, 1, 1, tzinfo=UTC)


@dataclass(frozen=True)
class BidsExport:
    """What was written.

    Attributes
    ----------
    folder
        The dataset.
    session
        The label of the session.
    people
        The labels of the people, each once.
    files
        The motion files.
    missing
        Robots of a live session that have no file, because their site's recording was not given.
    """

    folder: Path
    session: str
    people: tuple[str, ...]
    files: tuple[Path, ...]
    missing: tuple[int, ...]


@dataclass
class _Person:
    """What one person of a session has: a line of scans.tsv per run."""

    label: str
    scans: list[list[object]] = field(default_factory=list)


def export_bids(
    source: SessionRecording | xr.Dataset | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    participants: Sequence[str] | None = None,
    session: str = "01",
    task: str = "coupled",
    rate: float | None = None,
    hide_date: bool = False,
) -> BidsExport:
    """Write trials or a live session as a motion-BIDS dataset, or add them to one as a further session.

    Each person is a subject; both files of a dyad have the same names but for the subject, the same samples
    of one clock, and name each other. docs/formats.md says what was chosen, and why.

    Parameters
    ----------
    source : SessionRecording, xarray.Dataset, str or path
        A rehearsal or recorded trials (path or dataset), or a live session (path or recording).
    folder : str or path
        The dataset. If there is one, the session is added to it, also to what other devices recorded in it.
    participants : sequence of str, optional
        Labels of who held robots 1 and 2. Default: the markers of a session, else the dyad and the robot.
    session : str, optional
        Label of the session. Every visit of these people needs its own.
    task : str, optional
        Label of the task.
    rate : float, optional
        Samples per second of a live session. Default: all.
    hide_date : bool, optional
        Whether a live session's date becomes 1900-01-01; the time of day stays.

    Returns
    -------
    BidsExport
        The folder, the people and the motion files.

    Raises
    ------
    telespring.InvalidInput
        If the source has nothing to export, a label has no letter or digit, or a person has motion of this
        session already: nothing is replaced.
    OSError
        If a file cannot be read or written.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> export = ts.export_bids("session.mcap", tempfile.mkdtemp(), participants=["P01", "P02"])
    >>> [file.name for file in export.files]
    ['sub-P01_ses-01_task-coupled_tracksys-robot_run-01_motion.tsv',
     'sub-P02_ses-01_task-coupled_tracksys-robot_run-01_motion.tsv']
    """
    place = export_place("folder", folder)
    session, task = bids_label(session, "session"), bids_label(task, "task")
    people = _people(participants)
    material = open_material(source, rate)
    runs = material_runs(material, people)
    if not runs:
        raise InvalidInput("source", "no trial", "at least one trial is required", "Name another file.")
    check_distinct(run.people for run in runs)
    labels = tuple(dict.fromkeys(run.people[i] for run in runs for i in run.robots))
    _check_new(place, labels, session)
    listed = _people_listed(place, labels)
    place.mkdir(parents=True, exist_ok=True)
    shift = _date_shift(runs) if hide_date else timedelta(0)
    beside = Path(tempfile.mkdtemp(prefix=".unfinished-", dir=place))
    try:
        persons = {label: _Person(label) for label in labels}
        files = [
            _write_run(beside, run, robot, persons[run.people[robot]], (session, task), material, shift)
            for run in runs
            for robot in run.robots
        ]
        insides = [Path(f"sub-{label}") / f"ses-{session}" for label in labels]
        for person, inside in zip(persons.values(), insides, strict=True):
            _write_scans(beside / inside, place / inside, f"sub-{person.label}_ses-{session}_scans", person)
        for inside in insides:
            _move_session(beside / inside, place / inside)
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    _write_dataset_files(place, listed, is_simulated=material.is_simulated)
    present = {robot for run in runs for robot in run.robots}
    return BidsExport(
        folder=place,
        session=session,
        people=labels,
        files=tuple(place / file.relative_to(beside) for file in files),
        missing=tuple(robot + 1 for robot in (0, 1) if robot not in present),
    )


def _people(participants: Sequence[str] | None) -> tuple[str, str] | None:
    if participants is None:
        return None
    if isinstance(participants, str) or len(participants) != 2:
        raise InvalidInput(
            "participants",
            quoted_value(participants),
            "two labels are required: who held robot 1, and who held robot 2",
            "Write them as in --participants P01,P02.",
        )
    first, second = (bids_label(str(label), "participants") for label in participants)
    return first, second


def _check_new(folder: Path, labels: Sequence[str], session: str) -> None:
    """Refuse a session that is there, and a folder of other things."""
    for label in labels:
        there = folder / f"sub-{label}" / f"ses-{session}" / "motion"
        if there.exists():
            raise InvalidInput(
                "session",
                session,
                f"sub-{label} has motion of this session already, and nothing is replaced ({there})",
                "Choose another label (--session, in Python session=), or another folder.",
            )
    if folder.is_dir() and any(folder.iterdir()) and not (folder / "dataset_description.json").is_file():
        raise InvalidInput(
            "folder",
            str(folder),
            "an empty or new folder, or a BIDS dataset is required: dataset_description.json is not there",
            "Choose another folder.",
        )


def _write_scans(beside: Path, there: Path, stem: str, person: _Person) -> None:
    """Write a person's list of recordings, behind those of other devices in the same session."""
    table, described = there / f"{stem}.tsv", there / f"{stem}.json"
    old = read_table(table) if table.is_file() else ([], [])
    write_table(beside / table.name, *append_rows(old, _SCAN_COLUMNS, person.scans))
    known = read_json(described) if described.is_file() else {}
    write_json(beside / described.name, sidecars.SCANS | known)


def _move_session(beside: Path, there: Path) -> None:
    """Move a session to where it belongs: the folder of its motion, then the lists of its recordings."""
    there.mkdir(parents=True, exist_ok=True)
    (beside / "motion").rename(there / "motion")
    for file in beside.iterdir():
        file.replace(there / file.name)


def _write_run(
    folder: Path,
    run: Run,
    robot: int,
    person: _Person,
    labels: tuple[str, str],
    material: Material,
    shift: timedelta,
) -> Path:
    """Write the files of one person in a run, note its line of scans.tsv, and return the motion file."""
    session, task = labels
    file = _motion_file(run, robot, session, task)
    place = folder / f"sub-{person.label}" / f"ses-{session}" / file
    place.parent.mkdir(parents=True, exist_ok=True)
    stem = place.name.removesuffix("_motion.tsv")
    found = channels(run.data, robot)
    write_samples(place, [channel.values for channel in found])
    write_json(place.with_suffix(".json"), sidecars.motion_sidecar(run, robot, task, found, material.study))
    write_table(
        place.with_name(f"{stem}_channels.tsv"),
        _CHANNEL_COLUMNS,
        [
            (
                each.name,
                each.component,
                each.kind,
                each.tracked_point,
                each.units,
                "study" if each.component != "n/a" else None,
                each.description,
            )
            for each in found
        ],
    )
    write_json(place.with_name(f"{stem}_channels.json"), sidecars.CHANNELS)
    write_table(
        place.with_name(f"{stem}_events.tsv"),
        _EVENT_COLUMNS,
        [
            (
                event.onset,
                event.duration,
                event.kind,
                event.value,
                event.robot,
                event.condition,
                event.stiffness,
                event.delay,
                event.status,
            )
            for event in run.events
        ],
    )
    write_json(place.with_name(f"{stem}_events.json"), sidecars.EVENTS)
    partner = f"sub-{run.people[1 - robot]}/ses-{session}/{_motion_file(run, 1 - robot, session, task)}"
    person.scans.append(
        [
            file,
            None if run.date is None else _date_text(run.date, shift),
            run.duration,
            f"bids::{partner}" if 1 - robot in run.robots else None,
            run.dyad,
            robot + 1,
            run.clock_uncertainty,
            run.clock_scatter,
            "true" if material.is_simulated else "false",
        ]
    )
    return place


def _motion_file(run: Run, robot: int, session: str, task: str) -> str:
    """Name the motion file of a robot, in the folder of the person's session."""
    acquisition = f"_acq-{run.acquisition}" if run.acquisition else ""
    return (
        f"motion/sub-{run.people[robot]}_ses-{session}_task-{task}_tracksys-robot{acquisition}"
        f"_run-{run.number:02d}_motion.tsv"
    )


def _moment(date: int) -> datetime:
    return datetime.fromtimestamp(date // 10**9, UTC) + timedelta(microseconds=date % 10**9 // 1000)


def _date_text(date: int, shift: timedelta) -> str:
    return f"{_moment(date) + shift:%Y-%m-%dT%H:%M:%S.%f}Z"


def _date_shift(runs: Sequence[Run]) -> timedelta:
    """Return the whole days that bring the first run to the hidden date."""
    dates = [run.date for run in runs if run.date is not None]
    return timedelta(days=(_HIDDEN.date() - _moment(min(dates)).date()).days) if dates else timedelta(0)


def _people_listed(folder: Path, labels: Sequence[str]) -> tuple[list[str], list[list[str]]]:
    """Return the table of participants with those who are new; a first one lists everybody who is there."""
    table = folder / "participants.tsv"
    names, rows = read_table(table) if table.is_file() else ([], [])
    people = [f"sub-{label}" for label in labels]
    if not table.is_file():
        people = sorted({*people, *(path.name for path in folder.glob("sub-*") if path.is_dir())})
    known = {row[0] for row in rows}
    return append_rows((names, rows), ["participant_id"], [[each] for each in people if each not in known])


def _write_dataset_files(
    folder: Path, people: tuple[list[str], list[list[str]]], *, is_simulated: bool
) -> None:
    """Write what a dataset has once; of what is there only the list of people grows."""
    description = folder / "dataset_description.json"
    names, rows = people
    lines = ["\t".join(names), *("\t".join(map(cell, row)) for row in rows)]
    write_whole(folder / "participants.tsv", "\n".join(lines) + "\n")
    if not (folder / "participants.json").exists():
        write_json(folder / "participants.json", sidecars.PARTICIPANTS)
    if not any((folder / f"README{ending}").exists() for ending in ("", ".md", ".rst", ".txt")):
        write_whole(folder / "README", sidecars.README)
    if not description.exists():
        name = "Two people coupled by a virtual spring"
        write_json(description, sidecars.dataset_description(f"{name}, simulated" if is_simulated else name))
