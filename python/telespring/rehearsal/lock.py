"""One process at a time in a folder."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from telespring._errors import InvalidInput

__all__ = ["LOCK", "locked"]

#: The file in the folder that is locked. It stays: to remove it would let two processes lock two files
#: of the same name.
LOCK = ".rehearsal.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder until the block ends or this process dies, however it dies.

    Parameters
    ----------
    folder
        An existing folder.

    Raises
    ------
    InvalidInput
        Where another process holds it.
    OSError
        Where the folder cannot be written.
    """
    # os.open, because the owner's number may only be replaced once the lock is ours
    handle = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if not _taken(handle):
            owner = os.read(handle, 32).decode(errors="replace").strip()
            raise InvalidInput(
                "out",
                str(folder),
                "one rehearsal at a time may work in a folder, and "
                + (f"process {owner}" if owner else "another process")
                + " is at work in this one",
                "Wait until it has ended, or name another folder.",
            )
        os.ftruncate(handle, 0)
        os.write(handle, f"{os.getpid()}\n".encode())
        yield
    finally:
        # closing releases the lock; the system does the same for a process that was killed
        os.close(handle)


if sys.platform == "win32":
    import msvcrt

    def _taken(handle: int) -> bool:
        # a byte far behind the owner's number: what is locked here cannot be read by others
        os.lseek(handle, 1 << 20, os.SEEK_SET)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            os.lseek(handle, 0, os.SEEK_SET)
        return True
else:
    import fcntl

    def _taken(handle: int) -> bool:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
