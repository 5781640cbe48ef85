"""The folder of a comparison: what each rehearsal left, and the results."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from telespring._files import replacing, write_whole
from telespring.comparison.cell_file import CELL_FILE, read_cell_file, write_cell_file
from telespring.rehearsal.claims import dataset_identity, require_claimable, require_same
from telespring.rehearsal.run import remove_rehearsal
from telespring.rehearsal.store import LOCK_FILE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["COMPARISON_FILES", "IDENTITY_FILE", "UNCONNECTED_FOLDER", "ComparisonIdentity", "ComparisonStore"]

_DATASET = "comparison.nc"
#: Which comparison a folder with finished trials belongs to.
IDENTITY_FILE = "comparison.json"
_SUMMARY, _STUDY = "compare.json", "recommended.toml"
#: What a comparison writes into its folder, besides the folders of its rehearsals.
COMPARISON_FILES = (_DATASET, IDENTITY_FILE, _SUMMARY, _STUDY, LOCK_FILE)
#: The folder of the rehearsal without a partner.
UNCONNECTED_FOLDER = "0-unconnected"
#: Changes when a variable or attribute of the dataset changes its meaning or is removed.
_SCHEMA = "telespring comparison 1"


@dataclass(frozen=True)
class ComparisonIdentity:
    """Everything that the numbers of a comparison depend on.

    Attributes
    ----------
    name, study
        Name and text of the study.
    is_quick
        Whether it is a quick comparison.
    programs
        Agents, target and recorded traces: by their place in the study, their name and a hash of their file.
    folders
        Names of the folders of its rehearsals.
    version
        Of the compiled core.
    schema
        Of the dataset.
    """

    name: str
    study: str
    is_quick: bool
    programs: dict[str, dict[str, str]]
    folders: tuple[str, ...]
    version: str
    schema: str = _SCHEMA

    def to_json(self) -> str:
        """Return the identity as text: equal texts are equal comparisons."""
        return json.dumps(asdict(self), sort_keys=True, ensure_ascii=False)

    def describe_difference(self, text: str) -> str | None:
        """Describe in what the comparison with this identity differs from this one; None if in nothing.

        ValueError, KeyError or TypeError if the text is no identity.
        """
        if text == self.to_json():
            return None
        other = json.loads(text)
        if (other["schema"], other["version"]) != (self.schema, self.version):
            return f"a comparison by telespring {other['version']}; this is {self.version}"
        if other["study"] != self.study:
            if other["name"] != self.name:
                return f"a comparison of another study, {other['name']!r}"
            return f"a comparison of a study of the same name, {other['name']!r}, with different contents"
        if other["is_quick"] != self.is_quick:
            return "a quick comparison" if other["is_quick"] else "a comparison that is not quick"
        return "a comparison with another version of a Python file or a recorded trace"


class ComparisonStore:
    """The files of one comparison in a folder.

    Parameters
    ----------
    path
        The folder; it need not exist.
    identity
        Identity of the comparison.

    Attributes
    ----------
    path, dataset, summary, study : pathlib.Path
        The folder, and in it `comparison.nc`, `compare.json` and `recommended.toml`.
    """

    def __init__(self, path: Path, identity: ComparisonIdentity) -> None:
        self.path = path
        self.dataset, self.summary, self.study = path / _DATASET, path / _SUMMARY, path / _STUDY
        self._identity = identity
        self._identity_file = path / IDENTITY_FILE

    def is_complete(self) -> bool:
        """Check whether the dataset of this comparison exists; InvalidInput if it is that of another."""
        if not self.dataset.exists():
            return False
        self._require_same(dataset_identity(self.dataset))
        return True

    def require_own_trials(self) -> None:
        """Refuse a folder with finished trials of another comparison."""
        require_claimable(self._identity_file, "comparison", self._describe, self._has_trials)

    def begin(self) -> None:
        """Claim the folder for this comparison; InvalidInput if it holds another with finished trials."""
        self.require_own_trials()
        write_whole(self._identity_file, self._identity.to_json())
        for folder in (self.path, *self._cells(self._identity.to_json())):
            for file in folder.glob(".unfinished-*"):
                file.unlink(missing_ok=True)

    def read_cell(self, folder: str) -> xr.Dataset | None:
        """Read what was measured in a finished rehearsal; None if it is not finished."""
        return read_cell_file(self.path / folder / CELL_FILE)

    def write_cell(self, folder: str, measured: xr.Dataset) -> None:
        """Keep what was measured in a rehearsal, and remove the rehearsal."""
        write_cell_file(self.path / folder / CELL_FILE, measured)
        remove_rehearsal(self.path / folder)

    def write_dataset(self, comparison: xr.Dataset) -> None:
        """Write the dataset, complete or absent."""
        signals = ("account", "position", "coupling_force")
        encoding: dict[str, dict[str, Any]] = {
            str(name): {"zlib": True, "complevel": 4, "shuffle": True}
            for name, variable in comparison.data_vars.items()
            if variable.dtype.kind == "f" and (variable.size > 1000 or name in signals)
        }
        identified = comparison.assign_attrs(identity=self._identity.to_json(), schema=_SCHEMA)
        with replacing(self.dataset) as beside:
            identified.to_netcdf(beside, engine="h5netcdf", encoding=encoding)

    def read_dataset(self) -> xr.Dataset:
        """Read the dataset."""
        import xarray as xr

        return xr.load_dataset(self.dataset, engine="h5netcdf")

    def remove_cells(self) -> None:
        """Remove the folders of the rehearsals, whose numbers the dataset contains."""
        self._remove_cells(self._identity.to_json())
        self._identity_file.unlink(missing_ok=True)

    def remove_comparison(self) -> None:
        """Remove the comparison in the folder, whichever it is, and nothing else."""
        if self._identity_file.exists():
            self._remove_cells(self._identity_file.read_text(encoding="utf-8"))
        if self.dataset.exists():
            identity = dataset_identity(self.dataset) or ""
            self._remove_cells(identity)
        for file in (self.dataset, self.summary, self.study, self._identity_file):
            file.unlink(missing_ok=True)

    def _remove_cells(self, identity: str) -> None:
        for folder in self._cells(identity):
            (folder / CELL_FILE).unlink(missing_ok=True)
            remove_rehearsal(folder)
            for file in (folder / LOCK_FILE, *folder.glob(".unfinished-*")):
                file.unlink(missing_ok=True)
            with suppress(OSError):  # it contains other files
                folder.rmdir()

    def _cells(self, identity: str) -> list[Path]:
        """List the folders of the rehearsals of a comparison that exist."""
        try:
            names = [str(name) for name in json.loads(identity)["folders"]]
        except (ValueError, KeyError, TypeError):
            return []
        # A name with a separator was not written here.
        return [self.path / name for name in names if Path(name).name == name and (self.path / name).is_dir()]

    def _has_trials(self, identity: str) -> bool:
        """Check whether trials of the comparison with this identity are finished."""
        return any(True for folder in self._cells(identity) for _ in _finished(folder))

    def _describe(self, stored: str | None) -> str | None:
        """Describe in what a stored comparison differs from this one; None if it is the same."""
        return self._identity.describe_difference(stored or "")

    def _require_same(self, stored: str | None) -> None:
        """Refuse the folder of another comparison; None is a file that is not a comparison's."""
        require_same(self.path, "comparison", stored, self._describe)


def _finished(folder: Path) -> Iterator[Path]:
    """List what finished trials left in the folder of a rehearsal."""
    yield from folder.glob("trials/*.trial")
    yield from (file for file in (folder / "rehearsal.nc", folder / CELL_FILE) if file.exists())
