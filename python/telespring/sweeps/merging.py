"""Shares of a rehearsal, a comparison or a sweep put together, wherever they ran."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from telespring._core import Study
from telespring._errors import InvalidInput
from telespring.comparison.merging import merge_comparison
from telespring.comparison.results import Comparison
from telespring.rehearsal.merging import merge_rehearsal, missing_refusal, refusing_shares
from telespring.rehearsal.run import Progress, RehearsalOutcome
from telespring.rehearsal.shards import SHARD_FILE, Job, ShardFacts
from telespring.rehearsal.store import create_folder, lock_folder
from telespring.sweeps.assembly import has_sweep, read_sweep, require_zarr
from telespring.sweeps.over import Over
from telespring.sweeps.plan import SweepPlan
from telespring.sweeps.rows import RowFile
from telespring.sweeps.run import Counter, SweepOutcome, finish_sweep, row_widths, sweep_store
from telespring.sweeps.store import IDENTITY_FILE, SweepIdentity, SweepStore

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Merged", "ShareProgress", "find_shares", "merge_shards", "merge_shares", "share_progress"]

#: What merging makes: of a rehearsal, of a comparison, of a sweep.
Merged: TypeAlias = RehearsalOutcome | Comparison | SweepOutcome


@dataclass(frozen=True)
class ShareProgress:
    """How far a share is.

    Attributes
    ----------
    folder
        Its folder.
    facts
        What it is a share of.
    finished
        Trials (of a sweep: points and trials) that are finished.
    """

    folder: Path
    facts: ShardFacts
    finished: int


def merge_shards(
    folders: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None = None,
    *,
    modules: str | os.PathLike[str] | None = None,
    as_zarr: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset | Comparison:
    """Put the shares of a rehearsal, a comparison or a sweep together.

    The result is the one that a single machine makes, byte for byte. The folders of the shares stay; they are
    no longer needed.

    Parameters
    ----------
    folders : path, or sequence of path
        Folders of shares, or the folder that contains them.
    out : path, optional
        Folder of the result; by default the folder that contains the shares.
    modules : path, optional
        Folder of the study's file, with its agents, targets and traces; by default where the shares ran.
    as_zarr : bool
        Write a sweep as ``sweep.zarr``.
    progress : callable, optional
        Called with the number of results that have been put together, and of all.

    Returns
    -------
    xarray.Dataset or Comparison
        What `rehearse`, `sweep` or `compare` returns.

    Raises
    ------
    InvalidInput
        If a share is missing, not finished, or of something else.

    Examples
    --------
    >>> import tempfile
    >>> import telespring as ts
    >>> study = ts.Study.paper().replace(
    ...     protocol={"stiffness": [35.6], "delay": [0.167], "trials": 2, "duration": 2.5, "discard": 0.5}
    ... )
    >>> folder = tempfile.mkdtemp()
    >>> for index in (1, 2):
    ...     _ = ts.rehearse(study, folder, shard=(index, 2))
    >>> ts.merge_shards(folder).sizes["trial"]
    2
    """
    import xarray as xr

    named = [folders] if isinstance(folders, str | os.PathLike) else list(folders)
    merged = merge_shares(
        [Path(folder) for folder in named],
        None if out is None else Path(out),
        modules=None if modules is None else Path(modules),
        as_zarr=as_zarr,
        progress=progress,
    )
    if isinstance(merged, Comparison):
        return merged
    if isinstance(merged, RehearsalOutcome):
        return xr.load_dataset(merged.dataset, engine="h5netcdf")
    return read_sweep(merged.dataset, as_zarr=as_zarr)


def merge_shares(
    folders: Sequence[Path],
    out: Path | None = None,
    *,
    modules: Path | None = None,
    as_zarr: bool = False,
    progress: Progress | None = None,
) -> Merged:
    """Put shares together, and leave the result on the disk."""
    shares = find_shares(folders)
    facts = [ShardFacts.read(share) for share in shares]
    job = _common_job(facts)
    if out is None:
        parents = {share.resolve().parent for share in shares}
        if len(parents) != 1:
            raise InvalidInput(
                "out", "", "a folder for the result, as the shares are in several", "Write --out DIR."
            )
        out = shares[0].parent
    if modules is None:
        # Where the shares ran, if that is here.
        there = next((Path(each.modules) for each in facts if each.modules is not None), None)
        modules = there if there is not None and there.is_dir() else None
    with _refusing_result():
        if job == "rehearsal":
            return merge_rehearsal(shares, out, modules, progress)
        if job == "comparison":
            return merge_comparison(shares, out, modules, progress)
        return _merge_sweep(shares, out, modules, progress, as_zarr=as_zarr)


@contextmanager
def _refusing_result() -> Iterator[None]:
    """Say what helps where the folder of the result holds something else: merging has no `fresh`."""
    try:
        yield
    except InvalidInput as refused:
        if refused.field != "out" or "--fresh" not in refused.remedy:
            raise
        raise InvalidInput(
            refused.field,
            refused.value,
            refused.allowed,
            "Write another folder with --out (out=… in Python), or remove what is in this one, but for the "
            "shares.",
        ) from None


def find_shares(folders: Iterable[Path]) -> list[Path]:
    """Find the folders of shares: those named, and those inside of one that is no share itself."""
    found: dict[Path, None] = {}
    for folder in folders:
        if (folder / SHARD_FILE).exists():
            found[folder] = None
            continue
        inside = [file.parent for file in folder.glob(f"shard-*/{SHARD_FILE}")]
        if not inside:
            ShardFacts.read(folder)  # refuses it
        facts = sorted((ShardFacts.read(each).index, each) for each in inside)
        found |= dict.fromkeys(each for _, each in facts)
    return list(found)


def share_progress(folders: Iterable[Path]) -> list[ShareProgress]:
    """Count what is finished of each share, as its files have it now."""
    progress = []
    for share in find_shares(folders):
        facts = ShardFacts.read(share)
        if facts.job == "sweep":
            # As what ran there says of itself: its study's files and its build may not be here.
            identity = _sweep_identity(share)
            store = SweepStore(share, identity, row_widths(_plan_of(identity)))
            finished = sum(len(rows.read()[0]) for rows in (store.points, store.trials))
        else:
            finished = sum(1 for _ in share.glob("**/[!.]*.trial"))
        progress.append(ShareProgress(share, facts, finished))
    return progress


def _common_job(facts: Sequence[ShardFacts]) -> Job:
    jobs = {each.job for each in facts}
    if len(jobs) != 1:
        raise InvalidInput(
            "shard",
            ", ".join(sorted(jobs)),
            "shares of one rehearsal, one comparison or one sweep are merged",
            "Name the folders of one of them.",
        )
    return jobs.pop()


def _merge_sweep(
    shares: Sequence[Path], out: Path, modules: Path | None, progress: Progress | None, *, as_zarr: bool
) -> SweepOutcome:
    plan = _plan_of(_sweep_identity(shares[0]))
    store = sweep_store(out, plan, modules)
    create_folder(out)
    done = plan.points + plan.units
    outcome = SweepOutcome(plan, store.zarr if as_zarr else store.dataset, done, done)
    if store.is_complete(as_zarr=as_zarr):
        return outcome
    if as_zarr:
        require_zarr()
    sources = [sweep_store(share, plan, modules) for share in shares]
    for source in sources:
        with refusing_shares(source.path):
            source.require_own_rows()
    with lock_folder(out):
        if has_sweep(store, plan, as_zarr=as_zarr):
            return outcome
        store.require_own_rows()
        points, trials = [source.points for source in sources], [source.trials for source in sources]
        # Before anything is written: the folder stays free for what the shares may become.
        missing = _missing([store.points, *points], plan.points)
        missing += _missing([store.trials, *trials], plan.units)
        if missing:
            raise missing_refusal(missing, done, shares)
        store.begin()
        counter = Counter(done, progress)
        _gather(store.points, points, counter)
        _gather(store.trials, trials, counter)
        finish_sweep(store, plan, as_zarr=as_zarr)
    return outcome


def _missing(sources: Sequence[RowFile], count: int) -> list[int]:
    """Return the places of rows that no file has."""
    is_there = np.zeros(count, dtype=bool)
    for source in sources:
        places, _ = source.read()
        is_there[places[places < count].astype(np.int64)] = True
    return [int(place) for place in np.flatnonzero(~is_there)]


def _gather(target: RowFile, sources: Sequence[RowFile], counter: Counter) -> None:
    """Take rows from other files."""
    kept = set(target.begin().tolist())
    counter.add(len(kept))
    for source in sources:
        places, values = source.read()
        new = np.array([place not in kept for place in places.tolist()], dtype=bool)
        if new.any():
            target.append(places[new].tolist(), values[new])
            kept |= set(places[new].tolist())
            counter.add(int(new.sum()))


def _sweep_identity(share: Path) -> SweepIdentity:
    try:
        return SweepIdentity.from_json((share / IDENTITY_FILE).read_text(encoding="utf-8"))
    except (ValueError, TypeError):
        raise InvalidInput(
            "shard",
            str(share),
            f"its {IDENTITY_FILE} is not one of this telespring",
            "Merge with the build of telespring that ran the shares.",
        ) from None


def _plan_of(identity: SweepIdentity) -> SweepPlan:
    """Return the plan of a sweep from its identity."""
    over = tuple(Over(key, tuple(values)) for key, values in identity.over)
    return SweepPlan(
        Study.from_toml(identity.study),
        over,
        identity.draws,
        identity.seed,
        identity.conditions,
        identity.trials,
    )
