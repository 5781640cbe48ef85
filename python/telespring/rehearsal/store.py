"""The folder of a rehearsal: its lock, its finished trials, and its dataset."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.rehearsal.claims import require_claimable, require_same
from telespring.rehearsal.identity import RehearsalIdentity
from telespring.rehearsal.schedule import ScheduledTrial
from telespring.rehearsal.trial_file import TrialRecord, read_trial_file, write_trial_file

__all__ = ["IDENTITY_FILE", "LOCK_FILE", "REHEARSAL_FILES", "RehearsalStore", "create_folder", "lock_folder"]

#: The locked file in the folder. It stays: without it two processes could lock two files of this name.
LOCK_FILE = ".rehearsal.lock"
_DATASET = "rehearsal.nc"
#: Which rehearsal a folder with finished trials belongs to.
IDENTITY_FILE = "rehearsal.json"
#: What a rehearsal writes into its folder and, to start over, removes from it, besides its trials.
REHEARSAL_FILES = (_DATASET, IDENTITY_FILE, LOCK_FILE)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold a rehearsal's folder until the block ends or this process dies, even by SIGKILL.

    InvalidInput where another process holds it.
    """
    from filelock import FileLock, Timeout

    path = folder / LOCK_FILE
    lock = FileLock(path, blocking=False, preserve_lock_file=True, on_acquired=_write_process_id_to_lock)
    try:
        lock.acquire()
    except Timeout:
        owner = ""
        with suppress(OSError):  # a locked file cannot be read on every system
            owner = path.read_text(encoding="utf-8", errors="replace").strip()
        raise InvalidInput(
            "out",
            str(folder),
            "only one process at a time may write into a folder, and "
            + (f"process {owner}" if owner else "another process")
            + " is using this one",
            "Wait until it has ended, or choose another folder.",
        ) from None
    try:
        yield
    finally:
        lock.release()


def create_folder(folder: Path) -> None:
    """Create the folder of results if it is missing; InvalidInput if a file has its name."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise InvalidInput(
            "out", str(folder), "a folder is required, but this is a file", "Choose a folder."
        ) from None


def _write_process_id_to_lock(descriptor: int) -> None:
    os.ftruncate(descriptor, 0)
    os.write(descriptor, f"{os.getpid()}\n".encode())


class RehearsalStore:
    """The finished trials of one rehearsal in a folder, or its dataset.

    Parameters
    ----------
    path
        The folder; it need not exist.
    identity
        Identity of the rehearsal.

    Attributes
    ----------
    path : pathlib.Path
        The folder.
    dataset : pathlib.Path
        The dataset, once all trials are finished; complete or absent.
    """

    def __init__(self, path: Path, identity: RehearsalIdentity) -> None:
        self.path = path
        self.dataset = path / _DATASET
        self._identity = identity
        self._identity_file = path / IDENTITY_FILE
        self._trials = path / "trials"

    def is_complete(self) -> bool:
        """Check whether the dataset of this rehearsal exists; InvalidInput if it is that of another."""
        if not self.dataset.exists():
            return False
        self._require_same(_read_dataset_identity(self.dataset))
        return True

    def holds_other_rehearsal(self) -> bool:
        """Check whether the folder holds another rehearsal, or other files with a rehearsal's names."""
        try:
            self.is_complete()
            require_claimable(self._identity_file, "rehearsal", self._describe, self._has_trials)
        except InvalidInput:
            return True
        return False

    def begin(self) -> None:
        """Claim the folder for this rehearsal, and remove what a killed process left half-written."""
        identity = self._identity.to_json()
        require_claimable(self._identity_file, "rehearsal", self._describe, self._has_trials)
        if not self._has_trials(identity):
            write_whole(self._identity_file, identity)
        self._trials.mkdir(exist_ok=True)
        self._remove_unfinished()

    def remove_rehearsal(self) -> None:
        """Remove the rehearsal in the folder, whichever it is, and nothing else."""
        self.dataset.unlink(missing_ok=True)
        self.remove_trials()

    def remove_trials(self) -> None:
        """Remove the files of the trials, which the dataset contains."""
        if self._trials.is_dir():
            for file in self._trials.glob("*.trial"):
                file.unlink()
        self._remove_unfinished()
        with suppress(OSError):  # the folder contains other files
            self._trials.rmdir()
        # Last, so that no trials are left without their identity.
        self._identity_file.unlink(missing_ok=True)

    def read_trial(self, trial: ScheduledTrial) -> TrialRecord | None:
        """Read a finished trial; None if it is missing, corrupt or of another rehearsal."""
        record = read_trial_file(self._trial_file(trial))
        if record is None or record.fingerprint != self._identity.fingerprint:
            return None
        return record if (record.condition, record.trial) == (trial.condition, trial.trial) else None

    def finished_trials(self, trials: Iterable[ScheduledTrial]) -> list[ScheduledTrial]:
        """List the trials that are finished and readable."""
        return [trial for trial in trials if self.read_trial(trial) is not None]

    def write_trial(self, trial: ScheduledTrial, record: TrialRecord) -> None:
        """Keep a finished trial."""
        write_trial_file(self._trial_file(trial), record)

    def take_trial(self, trial: ScheduledTrial, other: RehearsalStore) -> bool:
        """Take over a trial that another folder of the same rehearsal has finished; False if it has not.

        The file is linked where the file system can do that, and copied otherwise.
        """
        if other.read_trial(trial) is None:
            return False
        source, target = other._trial_file(trial), self._trial_file(trial)
        temporary = target.with_name(f".unfinished-{target.name}")
        temporary.unlink(missing_ok=True)
        try:
            os.link(source, temporary)
        except OSError:  # another file system
            shutil.copyfile(source, temporary)
        temporary.replace(target)
        return True

    def require_own_trials(self) -> None:
        """Refuse a folder whose trials are not of this rehearsal."""
        require_claimable(self._identity_file, "rehearsal", self._describe, self._has_trials)

    def flush_folder(self) -> None:
        """Wait until the names of the files in the folder are on the disk, where the system can do that."""
        if sys.platform != "win32":
            handle = os.open(self.path, os.O_RDONLY)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)

    def _trial_file(self, trial: ScheduledTrial) -> Path:
        return self._trials / f"{trial.condition}-{trial.trial}.trial"

    def _has_trials(self, _: str) -> bool:
        """Check whether trials are finished; all trials in a folder are of the same rehearsal."""
        return any(self._trials.glob("*.trial"))

    def _describe(self, stored: str | None) -> str | None:
        """Describe in what a stored rehearsal differs from this one; None if it is the same."""
        return self._identity.describe_difference(RehearsalIdentity.from_json(stored or ""))

    def _require_same(self, identity: RehearsalIdentity | None) -> None:
        """Refuse the folder of another rehearsal; None is a file that is not a rehearsal's."""
        stored = None if identity is None else identity.to_json()
        require_same(self.path, "rehearsal", stored, self._describe)

    def _remove_unfinished(self) -> None:
        for folder in (self.path, self._trials):
            for file in folder.glob(".unfinished-*"):
                file.unlink(missing_ok=True)


def _read_dataset_identity(dataset: Path) -> RehearsalIdentity | None:
    """Read the identity of a dataset; None where the file is not a rehearsal's dataset."""
    import h5netcdf

    try:
        with h5netcdf.File(dataset, "r") as file:
            return RehearsalIdentity.from_attributes(file.attrs)
    except PermissionError:
        raise
    except (OSError, KeyError, ValueError):
        return None
