"""Files that are complete or absent: write a temporary file, flush it to the disk, then rename it."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["replacing", "spelt_otherwise", "write_whole"]


def spelt_otherwise(path: Path) -> Path:
    """Return a file that exists: `path`, or one in its folder that differs in upper and lower case only.

    A name from Windows may have backslashes between its folders. Without such a file, `path` is returned.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> _ = (folder / "TRIALS.CSV").write_text("")
    >>> spelt_otherwise(folder / "trials.csv").name
    'TRIALS.CSV'
    """
    given = path if path.exists() else Path(str(path).replace("\\", "/"))
    if given.exists() or not given.parent.is_dir():
        return given if given.exists() else path
    alike = [entry for entry in given.parent.iterdir() if entry.name.casefold() == given.name.casefold()]
    return alike[0] if len(alike) == 1 else path


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path next to `path`, and move it there if the block succeeds.

    Missing folders are made. Whatever ends the block early (an exception, Ctrl-C) removes the temporary file
    and leaves what was at `path` as it was. An OSError names the folder or `path`, never the temporary file.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with replacing(folder / "note.txt") as beside:
    ...     _ = beside.write_text("whole")
    >>> [entry.name for entry in folder.iterdir()]
    ['note.txt']
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    # The name ends as the target's does: some writers choose the format by it. It is short, so that a
    # long name is refused only where the target's own is too long.
    beside = target.with_name(f".unfinished-{secrets.token_hex(8)}{target.suffix}")
    try:
        yield beside
        with beside.open("r+b") as written:  # Windows flushes only what may be written
            os.fsync(written.fileno())
        beside.replace(target)
    except OSError as trouble:
        # HDF5 names no file in `filename`, and the temporary one in its message.
        if trouble.filename not in (None, str(beside)):
            raise
        number = trouble.errno
        reason = os.strerror(number) if number else str(trouble).replace(str(beside), str(target))
        raise OSError(number or errno.EIO, reason, str(target)) from trouble
    finally:
        # What could not be made cannot be removed, and must not hide the first trouble.
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` (text as UTF-8) to `path`: a reader sees the old file or the new one, never a part.

    Missing folders are created. Returns the path.
    """
    with replacing(path) as beside:
        beside.write_bytes(content.encode() if isinstance(content, str) else content)
    return Path(path)
