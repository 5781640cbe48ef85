"""Finished trials as files that are whole or not trusted."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

__all__ = ["Record", "keep", "kept"]

_MAGIC = b"telespring trial 1\n"
_DIGEST = 32


@dataclass(frozen=True)
class Record:
    """One finished trial.

    Attributes
    ----------
    fingerprint
        Of the rehearsal it belongs to.
    condition, trial, seed
        Which trial it is.
    status
        How it ended, one of `telespring.rehearsal.encoding.STATUSES`.
    ended_at
        Where it ended early, s; None where it was completed.
    rows
        How many rows of its signals hold values.
    chunks
        Its signals, as `telespring.rehearsal.encoding.pack` makes them.
    """

    fingerprint: str
    condition: int
    trial: int
    seed: int
    status: str
    ended_at: float | None
    rows: int
    chunks: dict[str, bytes]


def keep(path: Path, record: Record) -> None:
    """Write a trial so that its file is whole or absent when this process is killed.

    After a power cut a file may be torn all the same: it is not flushed to the disk, which would cost more
    than the trial. `kept` finds that out.

    Raises
    ------
    OSError
        Where it cannot be written; its `filename` is `path`.
    """
    head = asdict(record) | {"chunks": {name: len(chunk) for name, chunk in record.chunks.items()}}
    first = json.dumps(head).encode()
    content = b"".join([len(first).to_bytes(8, "little"), first, *record.chunks.values()])
    beside = path.with_name(f".unfinished-{path.name}")
    try:
        beside.write_bytes(_MAGIC + _digest(content) + content)
        beside.replace(path)
    except BaseException as trouble:
        beside.unlink(missing_ok=True)
        if isinstance(trouble, OSError) and trouble.errno:
            raise OSError(trouble.errno, os.strerror(trouble.errno), str(path)) from trouble
        raise


def kept(path: Path) -> Record | None:
    """Read a trial, or return None where its file is absent, torn or none of ours.

    Raises
    ------
    OSError
        Where the file is there and cannot be read.
    """
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return None
    start = len(_MAGIC) + _DIGEST
    content = text[start:]
    if text[: len(_MAGIC)] != _MAGIC or text[len(_MAGIC) : start] != _digest(content):
        return None
    end = 8 + int.from_bytes(content[:8], "little")
    head = json.loads(content[8:end])
    chunks = {}
    for name, length in head["chunks"].items():
        chunks[name] = content[end : end + length]
        end += length
    return Record(**(head | {"chunks": chunks}))


def _digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_DIGEST).digest()
