"""Files of finished trials: complete or absent, and checked by a digest when read."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

__all__ = ["TrialRecord", "read_trial_file", "write_trial_file"]

_MAGIC = b"telespring trial 2\n"
_DIGEST = 32


@dataclass(frozen=True)
class TrialRecord:
    """One finished trial.

    Attributes
    ----------
    fingerprint
        Of the rehearsal to which it belongs.
    condition, trial, seed
        Which trial it is.
    status
        How it ended, one of `telespring.rehearsal.encoding.STATUSES`.
    ended_at
        Time of an early end, s; None if it was completed.
    rows
        Rows of its signals that hold values.
    reports
        What its coupling reports at the end, by the names of `telespring.rehearsal.encoding`: a number,
        or one for each robot.
    chunks
        Its signals, compressed by `telespring.rehearsal.encoding.compress_signal`.
    """

    fingerprint: str
    condition: int
    trial: int
    seed: int
    status: str
    ended_at: float | None
    rows: int
    reports: dict[str, float | list[float]]
    chunks: dict[str, bytes]


def write_trial_file(path: Path, record: TrialRecord) -> None:
    """Write a trial so that its file is complete or absent if this process is killed.

    The file is not flushed to the disk, which would take longer than the trial, so that a power cut may
    corrupt it. `read_trial_file` detects that. An OSError names `path`.
    """
    head = asdict(record) | {"chunks": {name: len(chunk) for name, chunk in record.chunks.items()}}
    header = json.dumps(head).encode()
    content = b"".join([len(header).to_bytes(8, "little"), header, *record.chunks.values()])
    temporary = path.with_name(f".unfinished-{path.name}")
    try:
        temporary.write_bytes(_MAGIC + _trial_file_digest(content) + content)
        temporary.replace(path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno:
            raise OSError(error.errno, os.strerror(error.errno), str(path)) from error
        raise


def read_trial_file(path: Path) -> TrialRecord | None:
    """Read the file of a trial; None if it is absent, corrupt or something else."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return None
    start = len(_MAGIC) + _DIGEST
    content = data[start:]
    if data[: len(_MAGIC)] != _MAGIC or data[len(_MAGIC) : start] != _trial_file_digest(content):
        return None
    end = 8 + int.from_bytes(content[:8], "little")
    head = json.loads(content[8:end])
    chunks = {}
    for name, length in head["chunks"].items():
        chunks[name] = content[end : end + length]
        end += length
    return TrialRecord(**(head | {"chunks": chunks}))


def _trial_file_digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_DIGEST).digest()
