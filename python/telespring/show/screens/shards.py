"""What the commands print about shares of some work: one that is finished, and how far all are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console, Group, RenderableType
from rich.text import Text

from telespring.rehearsal.shards import Shard
from telespring.show.screens.layout import fitting_table

if TYPE_CHECKING:
    from telespring.sweeps.merging import ShareProgress

__all__ = ["missing_shares", "share_outcome_screen", "share_progress_screen"]


def share_outcome_screen(console: Console, shard: Shard, share: Path, folder: Path, results: int) -> None:
    """Say that a share is finished, and what to do when all are."""
    console.print(f"Share {shard} is finished: {results} results in {share}", markup=False)
    console.print(f"When all shares are: telespring merge {folder}", markup=False)


def missing_shares(shares: Sequence[ShareProgress]) -> list[Shard]:
    """List the shares that have not begun, of each division of the work that some have."""
    missing = []
    for count in sorted({each.facts.count for each in shares}):
        there = {each.facts.index for each in shares if each.facts.count == count}
        missing += [Shard(index, count) for index in range(1, count + 1) if index not in there]
    return missing


def share_progress_screen(shares: Sequence[ShareProgress], named: Sequence[Path]) -> RenderableType:
    """Lay out how far each share is, which ones are missing, and how far all are together.

    `named` are the folders that were asked about.
    """
    rows = [
        [str(each.facts.shard), f"{each.finished} of {each.facts.trials}", str(each.folder)]
        for each in shares
    ]
    finished, total = sum(each.finished for each in shares), sum(each.facts.trials for each in shares)
    parts: list[RenderableType] = [
        fitting_table("", ["share", "finished", "folder"], rows, right=(1,)),
        Text(f"Together: {finished} of {total} of the shares that have begun"),
    ]
    missing = missing_shares(shares)
    if missing:
        more = f" and {len(missing) - 8} more" if len(missing) > 8 else ""
        parts.append(Text(f"Not begun: {', '.join(map(str, missing[:8]))}{more}", style="yellow"))
    elif finished == total:
        parts.append(Text(f"All are finished: telespring merge {' '.join(map(str, named))}"))
    return Group(*parts)
