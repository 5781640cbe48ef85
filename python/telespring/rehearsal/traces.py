"""Recorded traces of the network that a study names: read from the folder of the study."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from telespring._core import Experiment, Laboratory, Study
from telespring._errors import InvalidInput

__all__ = ["RecordedTraces", "read_traces"]


@dataclass(frozen=True)
class RecordedTraces:
    """The recorded traces of an experiment's network, forward and backward; None without one.

    Attributes
    ----------
    names
        The files as the study names them.
    texts
        Their content.
    """

    names: tuple[str | None, str | None]
    texts: tuple[str | None, str | None]

    def provenance(self) -> dict[str, dict[str, str]]:
        """Return name and SHA-256 of each file, on which the numbers depend, by its place in the study."""
        places = ("network.trace.forward", "network.trace.backward")
        return {
            place: {"name": name, "sha256": hashlib.sha256(text.encode()).hexdigest()}
            for place, name, text in zip(places, self.names, self.texts, strict=True)
            if name is not None and text is not None
        }

    def laboratory(self, experiment: Experiment) -> Laboratory:
        """Return the laboratory of the experiment, with these traces on its network."""
        return experiment.laboratory_on(self.texts)


def read_traces(source: Experiment | Study, folder: Path | None) -> RecordedTraces:
    """Read the recorded traces that an experiment or a study names, relative to the folder of the study.

    InvalidInput where a file is not text in UTF-8, OSError where it cannot be read. Their content is checked
    with the laboratory.

    Examples
    --------
    >>> import telespring as ts
    >>> experiment = ts.Study.paper().experiment
    >>> read_traces(experiment, None).texts
    (None, None)
    """
    forward, backward = source.trace_files
    return RecordedTraces((forward, backward), (_read(forward, folder), _read(backward, folder)))


def _read(name: str | None, folder: Path | None) -> str | None:
    if name is None:
        return None
    content = (Path() if folder is None else folder).joinpath(name).read_bytes()
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        raise InvalidInput(
            "network.trace",
            name,
            "a recorded trace is text in UTF-8: a table, or the JSON of IRTT",
            "Save it in that encoding.",
        ) from None
