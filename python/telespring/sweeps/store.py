"""The folder of a sweep: its finished rows, and its dataset."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from telespring._files import write_whole
from telespring.rehearsal.claims import dataset_identity, require_claimable, require_same
from telespring.rehearsal.store import LOCK_FILE
from telespring.sweeps.over import as_number
from telespring.sweeps.rows import RowFile

__all__ = ["IDENTITY_FILE", "SCHEMA", "SWEEP_FILES", "SweepIdentity", "SweepStore"]

_DATASET, _ZARR = "sweep.nc", "sweep.zarr"
_POINTS, _TRIALS = "points.rows", "trials.rows"
#: Which sweep a folder with finished rows belongs to.
IDENTITY_FILE = "sweep.json"
#: What a sweep writes into its folder.
SWEEP_FILES = (_DATASET, _ZARR, _POINTS, _TRIALS, IDENTITY_FILE, LOCK_FILE)
#: Changes when a variable or attribute of the dataset changes its meaning or is removed.
SCHEMA = "telespring sweep 1"


@dataclass(frozen=True)
class SweepIdentity:
    """Everything that the numbers of a sweep depend on.

    Attributes
    ----------
    name, study
        Name and text of the study.
    over
        Keys with their values.
    draws, seed
        Of the robots.
    conditions, trials
        At every point.
    programs
        Agents, targets and recorded traces: name and hash of each file.
    version
        Of the compiled core.
    schema
        Of the dataset.
    """

    name: str
    study: str
    over: list[tuple[str, list[str]]]
    draws: int
    seed: int
    conditions: int
    trials: int
    programs: dict[str, dict[str, str]]
    version: str
    schema: str = SCHEMA

    @property
    def fingerprint(self) -> str:
        """A hash of the whole identity, the same for equal sweeps."""
        return hashlib.sha256(self._compared().encode()).hexdigest()

    def to_json(self) -> str:
        """Return the identity as text, with the values of the keys as they were given."""
        return json.dumps(asdict(self), sort_keys=True, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str) -> SweepIdentity:
        """Read the output of `to_json`; ValueError or TypeError if the text is something else."""
        return cls(**json.loads(text))

    def describe_difference(self, text: str | None) -> str | None:
        """Describe in what the sweep with this identity differs from this one; None if in nothing."""
        other = self.from_json(text or "")
        if other._compared() == self._compared():
            return None
        if (other.schema, other.version) != (self.schema, self.version):
            return f"a sweep by telespring {other.version}; this is {self.version}"
        if other.study != self.study:
            return f"a sweep of another study, {other.name!r}, or of one with different contents"
        if other.programs != self.programs:
            return "a sweep with another version of a Python file or a recorded trace"
        return "a sweep over other keys, values or draws"

    def has_points_of(self, text: str) -> bool:
        """Check whether the sweep with this identity has the same points, whatever its agents and targets."""
        return self.from_json(text)._of_points() == self._of_points()

    def _of_points(self) -> str:
        """Return the text that sweeps with equal points have in common: of the files only recorded traces."""
        traces = {place: file for place, file in self.programs.items() if place.startswith("network.trace")}
        return replace(self, programs=traces)._compared()

    def _compared(self) -> str:
        """Return the text that equal sweeps have in common: 30 and 30.0 are one value of a key."""
        over = [[key, [as_number(value) for value in values]] for key, values in self.over]
        return json.dumps(asdict(self) | {"over": over}, sort_keys=True, ensure_ascii=False)


class SweepStore:
    """The files of one sweep in a folder.

    Parameters
    ----------
    path
        The folder; it need not exist.
    identity
        Identity of the sweep.
    widths
        Numbers in a row of a point, and of a trial.

    Attributes
    ----------
    path, dataset, zarr : pathlib.Path
        The folder, and in it the dataset as netCDF or as Zarr.
    points, trials : RowFile
        Finished points and trials.
    """

    def __init__(self, path: Path, identity: SweepIdentity, widths: tuple[int, int]) -> None:
        self.path = path
        self.dataset, self.zarr = path / _DATASET, path / _ZARR
        self.points = RowFile(path / _POINTS, widths[0], identity.fingerprint)
        self.trials = RowFile(path / _TRIALS, widths[1], identity.fingerprint)
        self.identity = identity
        self._identity_file = path / IDENTITY_FILE

    def is_complete(self, *, as_zarr: bool) -> bool:
        """Check whether the dataset of this sweep exists; InvalidInput if it is that of another."""
        for place, read in ((self.dataset, dataset_identity), (self.zarr, _zarr_identity)):
            if place.exists():
                require_same(self.path, "sweep", read(place), self.identity.describe_difference)
        return (self.zarr if as_zarr else self.dataset).exists()

    def require_own_rows(self) -> None:
        """Refuse a folder with finished rows of another sweep."""
        require_claimable(self._identity_file, "sweep", self.identity.describe_difference, self._has_finished)

    def begin(self) -> None:
        """Claim the folder for this sweep; InvalidInput if it holds another with finished rows."""
        self.require_own_rows()
        write_whole(self._identity_file, self.identity.to_json())
        for file in self.path.glob(".unfinished-*"):
            if file.is_dir():
                shutil.rmtree(file)
            else:
                file.unlink(missing_ok=True)

    def remove_rows(self) -> None:
        """Remove the rows, which the dataset contains."""
        self.points.path.unlink(missing_ok=True)
        self.trials.path.unlink(missing_ok=True)
        # Last, so that no rows are left without their identity.
        self._identity_file.unlink(missing_ok=True)

    def remove_sweep(self) -> None:
        """Remove the sweep in the folder, whichever it is, and nothing else."""
        self.dataset.unlink(missing_ok=True)
        if self.zarr.is_dir():
            shutil.rmtree(self.zarr)
        self.remove_rows()

    def _has_finished(self, stored: str) -> bool:
        """Check whether there are results to keep, of the sweep with this stored identity.

        Before the first trial only points are there, and no agent has a part in them: one that failed at
        once may be corrected. A recorded trace has.
        """
        return self.trials.has_rows() or (self.points.has_rows() and not self.identity.has_points_of(stored))


def _zarr_identity(folder: Path) -> str | None:
    """Read the identity of a dataset in Zarr; None where the folder is not a sweep's dataset."""
    try:
        text = (folder / "zarr.json").read_text(encoding="utf-8")
        return str(json.loads(text)["attributes"]["identity"])
    except (FileNotFoundError, NotADirectoryError, ValueError, KeyError):
        return None
