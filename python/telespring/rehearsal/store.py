"""The folder of a rehearsal: what is in it, whose it is, and what of it is finished."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.rehearsal.identity import Identity
from telespring.rehearsal.schedule import Trial
from telespring.rehearsal.trial_file import Record, keep, kept

__all__ = ["RehearsalFolder"]


class RehearsalFolder:
    """A folder with the finished trials of one rehearsal, or with its dataset.

    Parameters
    ----------
    path
        The folder; it need not exist.
    identity
        Of the rehearsal that it is for.

    Attributes
    ----------
    path : pathlib.Path
        The folder.
    dataset : pathlib.Path
        Where the dataset stands once all trials are finished; whole or absent.
    """

    def __init__(self, path: Path, identity: Identity) -> None:
        self.path = path
        self.dataset = path / "rehearsal.nc"
        self._identity = identity
        self._plan = path / "rehearsal.json"
        self._trials = path / "trials"

    def make(self) -> None:
        """Make the folder where it is missing.

        Raises
        ------
        InvalidInput
            Where a file stands in its place.
        OSError
            Where it cannot be made.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError):
            raise InvalidInput(
                "out", str(self.path), "a folder is needed, and a file stands there", "Name a folder."
            ) from None

    def complete(self) -> bool:
        """Tell whether this rehearsal's dataset is there.

        Raises
        ------
        InvalidInput
            Where a dataset of another rehearsal, or something else, stands in its place.
        """
        if not self.dataset.exists():
            return False
        self._own(_identity_in(self.dataset))
        return True

    def foreign(self) -> bool:
        """Tell whether another rehearsal is in the folder, or something else of a rehearsal's names."""
        try:
            self.complete()
            self._refuse_other_trials()
        except InvalidInput:
            return True
        return False

    def begin(self) -> None:
        """Make the folder this rehearsal's own, and clear away what a killed process left half-written.

        Raises
        ------
        InvalidInput
            Where it holds another rehearsal.
        OSError
            Where it cannot be written.
        """
        self._refuse_other_trials()
        # A plan of which nothing was finished binds nobody: an agent that failed at once may be mended.
        if not any(self._trials.glob("*.trial")):
            write_whole(self._plan, self._identity.to_json())
        self._trials.mkdir(exist_ok=True)
        self._remove_unfinished()

    def empty(self) -> None:
        """Remove whatever rehearsal is in the folder, and nothing else."""
        self.dataset.unlink(missing_ok=True)
        self.tidy()

    def tidy(self) -> None:
        """Remove the trials' own files: the dataset has them."""
        if self._trials.is_dir():
            for file in self._trials.glob("*.trial"):
                file.unlink()
        self._remove_unfinished()
        with suppress(OSError):  # something of somebody else's is in it
            self._trials.rmdir()
        # Last, so that trials without a plan, whose nobody knows, are never left.
        self._plan.unlink(missing_ok=True)

    def record(self, trial: Trial) -> Record | None:
        """Return a finished trial, or None where it is missing, torn or not of this rehearsal."""
        found = kept(self._file(trial))
        if found is None or found.fingerprint != self._identity.fingerprint:
            return None
        return found if (found.condition, found.trial) == (trial.condition, trial.trial) else None

    def finished(self, trials: Iterable[Trial]) -> list[Trial]:
        """Return those of the trials that are finished and sound."""
        return [trial for trial in trials if self.record(trial) is not None]

    def keep(self, trial: Trial, record: Record) -> None:
        """Keep a finished trial."""
        keep(self._file(trial), record)

    def settle(self) -> None:
        """Wait until the disk knows the names of the files in the folder, where the system can."""
        if sys.platform != "win32":
            handle = os.open(self.path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)

    def _file(self, trial: Trial) -> Path:
        return self._trials / f"{trial.condition}-{trial.trial}.trial"

    def _refuse_other_trials(self) -> None:
        if self._plan.exists():
            try:
                found = Identity.from_json(self._plan.read_text(encoding="utf-8"))
            except ValueError:
                found = None
            if found is None or any(self._trials.glob("*.trial")):
                self._own(found)

    def _own(self, found: Identity | None) -> None:
        if found is None:
            raise InvalidInput(
                "out",
                str(self.path),
                "this folder holds files of a rehearsal's names which are none",
                "Name another folder, or start anew with --fresh (fresh=True), which removes them.",
            )
        difference = self._identity.difference(found)
        if difference is not None:
            raise InvalidInput(
                "out",
                str(self.path),
                f"this folder holds {difference}",
                "Name another folder, or start anew with --fresh (fresh=True), which removes what is there.",
            )

    def _remove_unfinished(self) -> None:
        for folder in (self.path, self._trials):
            for file in folder.glob(".unfinished-*"):
                file.unlink(missing_ok=True)


def _identity_in(dataset: Path) -> Identity | None:
    """Read whose dataset a file is; None where it is not a rehearsal's."""
    import h5netcdf

    try:
        with h5netcdf.File(dataset, "r") as file:
            return Identity.from_attributes(file.attrs)
    except PermissionError:
        raise
    except (OSError, KeyError, ValueError):
        return None
