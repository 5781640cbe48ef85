"""Shares of a comparison put together: their trials in one folder, from which the result follows."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from telespring._core import Study
from telespring.comparison.cells import (
    comparison_store,
    progress_after,
    rehearsals_of,
    trial_count,
)
from telespring.comparison.results import Comparison
from telespring.comparison.run import run_comparison
from telespring.comparison.schedule import schedule_comparison
from telespring.comparison.store import IDENTITY_FILE
from telespring.rehearsal.merging import gather_trials, missing_refusal, refusing_shares
from telespring.rehearsal.run import Progress
from telespring.rehearsal.store import create_folder, lock_folder
from telespring.rehearsal.work import prepare_runner

__all__ = ["merge_comparison"]


def merge_comparison(
    shares: Sequence[Path], folder: Path, modules: Path | None, progress: Progress | None = None
) -> Comparison:
    """Finish a comparison from the folders of all its shares.

    The result is the one of a single machine. InvalidInput where trials are missing, or a share is of another
    comparison.
    """
    identity = json.loads((shares[0] / IDENTITY_FILE).read_text(encoding="utf-8"))
    study, quick = Study.from_toml(identity["study"]), bool(identity["is_quick"])
    schedule = schedule_comparison(study, quick=quick, modules=modules)
    store = comparison_store(folder, schedule, quick=quick, modules=modules)
    create_folder(folder)
    if not store.is_complete():
        for share in shares:
            with refusing_shares(share):
                comparison_store(share, schedule, quick=quick, modules=modules).require_own_trials()
        with lock_folder(folder):
            store.begin()
        missing: list[int] = []
        done = 0
        for name, each in rehearsals_of(schedule).items():
            if store.read_cell(name) is None:
                runner = prepare_runner(each, modules)
                told = None if progress is None else progress_after(progress, done, schedule.trials)
                missing += gather_trials(runner, folder / name, [share / name for share in shares], told)
            done += trial_count(each)
        if missing:
            raise missing_refusal(missing, schedule.trials, shares)
    return run_comparison(study, folder, quick=quick, modules=modules)
