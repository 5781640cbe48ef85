"""Results of a sweep as rows of numbers in one file, to which finished work is appended."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from telespring._files import replacing
from telespring._types import FloatArray

__all__ = ["RowFile"]

_MAGIC = b"telespring rows 1\n"
_DIGEST = 8


class RowFile:
    """A file of rows: the place of each in the sweep, its numbers, and a digest.

    A process that is killed while it appends leaves at most its last rows torn, which their digest shows.

    Parameters
    ----------
    path
        The file; it need not exist.
    width
        Numbers in a row.
    fingerprint
        Of the sweep, on which every digest depends.
    """

    def __init__(self, path: Path, width: int, fingerprint: str) -> None:
        self.path = path
        self._fingerprint = fingerprint.encode()
        self._type = np.dtype([("place", "<u8"), ("values", "<f8", (width,)), ("digest", "u1", (_DIGEST,))])

    def read(self) -> tuple[NDArray[np.uint64], FloatArray]:
        """Return places and numbers of all whole rows, each place once, by place."""
        try:
            data = self.path.read_bytes()
        except FileNotFoundError:
            data = b""
        body = data[len(_MAGIC) :] if data.startswith(_MAGIC) else b""
        count = len(body) // self._type.itemsize
        rows = np.frombuffer(body, self._type, count)
        whole = np.array([self._is_whole(row.tobytes()) for row in rows], dtype=bool)
        places, first = np.unique(rows["place"][whole], return_index=True)
        return places, rows["values"][whole][first]

    def has_rows(self) -> bool:
        """Check whether something was appended, by whichever sweep."""
        return self.path.exists() and self.path.stat().st_size > len(_MAGIC)

    def begin(self) -> NDArray[np.uint64]:
        """Drop what is torn, so that rows can be appended; return the places of those that are kept."""
        places, values = self.read()
        size = len(_MAGIC) + len(places) * self._type.itemsize
        if not self.path.exists() or self.path.stat().st_size != size:
            with replacing(self.path) as beside:
                beside.write_bytes(_MAGIC + self._encode(places, values))
        return places

    def append(self, places: Iterable[int], values: FloatArray) -> None:
        """Add finished rows."""
        content = self._encode(np.fromiter(places, dtype=np.uint64), values)
        # Buffered: closing writes all or fails. A bare write may stop at a full disk and say nothing.
        with self.path.open("ab") as file:
            file.write(content)

    def _encode(self, places: NDArray[np.uint64], values: FloatArray) -> bytes:
        rows = np.zeros(len(places), self._type)
        rows["place"], rows["values"] = places, values
        size = self._type.itemsize
        data = bytearray(rows.tobytes())
        for start in range(0, len(data), size):
            end = start + size - _DIGEST
            data[end : start + size] = self._digest(bytes(data[start:end]))
        return bytes(data)

    def _is_whole(self, row: bytes) -> bool:
        return self._digest(row[:-_DIGEST]) == row[-_DIGEST:]

    def _digest(self, content: bytes) -> bytes:
        return hashlib.blake2b(content, digest_size=_DIGEST, key=self._fingerprint[:64]).digest()
