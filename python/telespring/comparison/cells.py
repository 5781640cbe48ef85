"""The rehearsals that a comparison consists of, and the store of what they leave."""

from __future__ import annotations

from pathlib import Path

from telespring._core import Study
from telespring.comparison.schedule import ComparisonSchedule
from telespring.comparison.store import UNCONNECTED_FOLDER, ComparisonIdentity, ComparisonStore
from telespring.rehearsal.identity import core_version
from telespring.rehearsal.run import Progress, require_experiment
from telespring.rehearsal.traces import read_traces
from telespring.rehearsal.user_code import load_user_code

__all__ = ["comparison_store", "progress_after", "rehearsals_of", "trial_count"]


def comparison_store(
    folder: Path, schedule: ComparisonSchedule, *, quick: bool, modules: Path | None
) -> ComparisonStore:
    """Return the store of a comparison in a folder."""
    identity = ComparisonIdentity(
        name=schedule.study.name,
        study=schedule.study.to_toml(),
        is_quick=quick,
        programs=_provenance(schedule, modules),
        folders=(UNCONNECTED_FOLDER, *(cell.folder for cell in schedule.cells)),
        version=core_version(),
    )
    return ComparisonStore(folder, identity)


def rehearsals_of(schedule: ComparisonSchedule) -> dict[str, Study]:
    """Return what is rehearsed, by the name of its folder."""
    return {UNCONNECTED_FOLDER: schedule.unconnected, **{cell.folder: cell.study for cell in schedule.cells}}


def _provenance(schedule: ComparisonSchedule, modules: Path | None) -> dict[str, dict[str, str]]:
    """Return name and hash of the files on which the numbers depend beside the study."""
    found = load_user_code(schedule.experiment, modules).provenance()
    for network, study in zip(schedule.networks, schedule.network_studies, strict=True):
        traces = read_traces(require_experiment(study), modules).provenance()
        found |= {f"{network}: {place}": file for place, file in traces.items()}
    return found


def trial_count(study: Study) -> int:
    """Return how many trials a study's protocol has."""
    experiment = require_experiment(study)
    return experiment.trials * len(experiment.conditions)


def progress_after(progress: Progress, before: int, total: int) -> Progress:
    """Return the progress of one rehearsal as that of the whole."""

    def told(done: int, _trials: int) -> None:
        if done:
            progress(before + done, total)

    return told
