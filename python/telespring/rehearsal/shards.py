"""Shares of the same work for several machines: every nth trial, in a folder of its own."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal, TypeAlias, TypeVar

from telespring._errors import InvalidInput
from telespring._files import write_whole

__all__ = ["SHARD_FILE", "Job", "Shard", "ShardFacts", "ShardLike", "read_shard"]

#: Which share of which work a folder holds.
SHARD_FILE = "shard.json"
_NAME = re.compile(r"(\d+)\s*/\s*(\d+)")
_MOST = 100_000

#: What is shared out.
Job = Literal["rehearsal", "comparison", "sweep"]
Item = TypeVar("Item")


@dataclass(frozen=True)
class Shard:
    """One share of some work.

    Attributes
    ----------
    index, count
        This share, from 1, and how many there are.
    """

    index: int
    count: int

    def __str__(self) -> str:
        return f"{self.index}/{self.count}"

    def folder(self, base: Path) -> Path:
        """Return its folder inside the folder of the whole work."""
        return base / f"shard-{self.index}-of-{self.count}"

    def select(self, items: Sequence[Item]) -> list[Item]:
        """Return its share: every nth item, so that all shares take about as long."""
        return list(items[self.index - 1 :: self.count])


#: A share as a caller writes it: "2/8" or (2, 8).
ShardLike: TypeAlias = Shard | str | tuple[int, int]


def read_shard(value: ShardLike | None) -> Shard | None:
    """Read which share is meant; None for all of the work.

    Examples
    --------
    >>> read_shard("2/8") == read_shard((2, 8)) == Shard(2, 8)
    True
    """
    if value is None or isinstance(value, Shard):
        return value
    index, count = 0, 0
    if isinstance(value, str):
        found = _NAME.fullmatch(value.strip())
        if found is not None:
            index, count = int(found[1]), int(found[2])
    elif len(value) == 2:
        index, count = value
    if not 1 <= index <= count <= _MOST:
        raise InvalidInput(
            "shard",
            str(value),
            f"the number of this share and of all, such as 2/8, with 1 ≤ share ≤ all ≤ {_MOST}",
            "Write --shard 1/8 to --shard 8/8 on eight machines (shard=(1, 8) in Python), then merge them.",
        )
    return Shard(index, count)


@dataclass(frozen=True)
class ShardFacts:
    """What the folder of a share says about it.

    Attributes
    ----------
    job
        What is shared out.
    index, count
        This share, from 1, and how many there are.
    trials
        Number of trials that it runs.
    modules
        The folder of the study's file where it ran; None if there was no file.
    """

    job: Job
    index: int
    count: int
    trials: int
    modules: str | None

    @classmethod
    def of(cls, job: Job, shard: Shard, trials: int, modules: Path | None) -> ShardFacts:
        """Describe a share that is about to run."""
        place = None if modules is None else str(modules.resolve())
        return cls(job, shard.index, shard.count, trials, place)

    @property
    def shard(self) -> Shard:
        """Which share it is."""
        return Shard(self.index, self.count)

    def write(self, folder: Path) -> None:
        """Write them into the folder of the share."""
        write_whole(folder / SHARD_FILE, json.dumps(asdict(self), sort_keys=True, indent=1))

    @classmethod
    def read(cls, folder: Path) -> ShardFacts:
        """Read them from the folder of a share; InvalidInput if it is none."""
        try:
            facts = cls(**json.loads((folder / SHARD_FILE).read_text(encoding="utf-8")))
            read_shard((facts.index, facts.count))
        except (ValueError, TypeError, FileNotFoundError, NotADirectoryError):
            raise InvalidInput(
                "shard",
                str(folder),
                f"the folder of a share has a {SHARD_FILE}, which says what it is a share of",
                "Name the folder that was given as --out, or the shard-… folders in it.",
            ) from None
        return facts
