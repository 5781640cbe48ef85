"""Where the samples of a log come from: how messages name its file, its columns and its samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._types import FloatArray

__all__ = ["Origin", "refusals_in"]

_KINDS = ("position", "force")


@dataclass(frozen=True, eq=False)
class Origin:
    """Names of a log's file, columns and samples.

    Attributes
    ----------
    axes
        Names of the axes.
    file
        Name of the file; empty for arrays.
    columns
        The file's columns by "position x", "force x", …; empty for arrays.
    time
        s, shape (n,).
    stamps
        The time stamps as the file has them, if they are not seconds.
    samples
        Number of each sample in the file, from 1; None if none was left out.
    lines
        Its line in a text file.
    """

    axes: Sequence[str]
    file: str = ""
    columns: Mapping[str, str] = field(default_factory=dict)
    time: FloatArray | None = None
    stamps: Any = None
    samples: NDArray[np.int_] | None = None
    lines: NDArray[np.int_] | None = None

    def select(self, chosen: NDArray[np.bool_]) -> Origin:
        """Return the origin of some of the samples."""
        places = np.flatnonzero(chosen)
        return replace(
            self,
            time=None if self.time is None else self.time[places],
            stamps=None if self.stamps is None else np.asarray(self.stamps, dtype=object)[places],
            samples=places + 1 if self.samples is None else self.samples[places],
            lines=None if self.lines is None else self.lines[places],
        )

    def column(self, kind: str, axis: int) -> str:
        """Name the column of a "position" or a "force" as the user does."""
        name = self.columns.get(f"{kind} {self.axes[axis]}")
        return f"{kind} ({self.axes[axis]})" if name is None else f"column {name}"

    def time_column(self) -> str:
        """Name the time column as the user does."""
        name = self.columns.get("time")
        return "time" if name is None else f"column {name}"

    def field(self, field: str) -> str:
        """Name what a refusal names: a column as the user does, after the file."""
        known = {
            f"{kind} ({axis})": self.column(kind, i) for kind in _KINDS for i, axis in enumerate(self.axes)
        }
        known["time"] = self.time_column()
        named = known.get(field, field)
        return f"{self.file}, {named}" if self.file else named

    def place(self, sample: int) -> str:
        """Name a sample, counted from 0: its time as the log writes it, its number and its line."""
        number = sample + 1 if self.samples is None else int(self.samples[sample])
        names = [f"sample {number}"]
        if self.lines is not None:
            names.append(f"line {self.lines[sample]}")
        if self.stamps is not None:
            stamp = str(self.stamps[sample])
        elif self.time is not None:
            stamp = f"{self.time[sample]:.9g} s"
        else:
            return ", ".join(names)
        return f"{stamp} ({', '.join(names)})"


@contextmanager
def refusals_in(origin: Origin) -> Iterator[None]:
    """Name the file and its column in every refusal of a log that does not name them."""
    try:
        yield
    except InvalidInput as refused:
        if origin.file and origin.file in f"{refused.field} {refused.value} {refused.allowed}":
            raise
        raise refused.at(origin.field(refused.field)) from None
