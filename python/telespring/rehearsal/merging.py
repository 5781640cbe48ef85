"""Shares of a rehearsal put together: their trials in one folder, from which the dataset is written."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring.rehearsal.identity import RehearsalIdentity
from telespring.rehearsal.run import Progress, RehearsalOutcome, run_protocol
from telespring.rehearsal.schedule import schedule_trials
from telespring.rehearsal.shards import Shard, ShardFacts
from telespring.rehearsal.store import IDENTITY_FILE, RehearsalStore, create_folder, lock_folder
from telespring.rehearsal.work import TrialRunner, prepare_runner

__all__ = ["gather_trials", "merge_rehearsal", "missing_refusal", "refusing_shares", "shares_of"]


def merge_rehearsal(
    shares: Sequence[Path], folder: Path, modules: Path | None, progress: Progress | None = None
) -> RehearsalOutcome:
    """Write the dataset of a rehearsal from the folders of all its shares.

    The dataset is the one that a single machine writes. InvalidInput where trials are missing, or a share
    is of another rehearsal.
    """
    text = (shares[0] / IDENTITY_FILE).read_text(encoding="utf-8")
    study = Study.from_toml(RehearsalIdentity.from_json(text).study)
    runner = prepare_runner(study, modules)
    missing = gather_trials(runner, folder, shares, progress)
    if missing:
        raise missing_refusal(missing, len(schedule_trials(runner.experiment)), shares)
    return run_protocol(study, folder, modules=modules)


def gather_trials(
    runner: TrialRunner, folder: Path, sources: Iterable[Path], progress: Progress | None = None
) -> list[int]:
    """Take finished trials from other folders; return the places in the schedule of those that none has."""
    store = RehearsalStore(folder, runner.identity)
    create_folder(folder)
    if store.is_complete():
        return []
    others = [RehearsalStore(source, runner.identity) for source in sources]
    for other in others:
        with refusing_shares(other.path):
            other.require_own_trials()
    missing = []
    with lock_folder(folder):
        store.begin()
        trials = schedule_trials(runner.experiment)
        for place, trial in enumerate(trials):
            is_there = store.read_trial(trial) is not None
            if not is_there and not any(store.take_trial(trial, other) for other in others):
                missing.append(place)
            if progress is not None:
                progress(place + 1 - len(missing), len(trials))
    return missing


@contextmanager
def refusing_shares(folder: Path) -> Iterator[None]:
    """Refuse the folder of a share, where the block refuses it as that of a whole."""
    try:
        yield
    except InvalidInput as refused:
        raise InvalidInput(
            "shard",
            str(folder),
            refused.allowed,
            "Merge shares of one study only, run by one build of telespring; repeat the others.",
        ) from None


def shares_of(missing: Iterable[int], folders: Sequence[Path]) -> list[Shard]:
    """Return which shares have these places of a schedule; none if the folders are of several divisions."""
    counts = {ShardFacts.read(folder).count for folder in folders}
    if len(counts) != 1:
        return []
    [count] = counts
    return [Shard(index + 1, count) for index in sorted({place % count for place in missing})]


def missing_refusal(missing: Sequence[int], trials: int, folders: Sequence[Path]) -> InvalidInput:
    """Return the refusal to merge while trials are missing."""
    shares = shares_of(missing, folders)
    named = ", ".join(map(str, shares[:8])) + (" and others" if len(shares) > 8 else "")
    return InvalidInput(
        "shard",
        named or f"{len(folders)} folders",
        f"every share must be finished, and {len(missing)} of {trials} results are missing",
        "Run these shares to their end with the same command and --shard, then merge again.",
    )
