"""Which rehearsal, comparison or sweep a folder belongs to: one rule for all.

A folder is claimed by a file with the identity of what runs in it. Another identity may take its place as
long as no trial is finished: an agent that failed at once may be corrected. A file of that name that is no
identity is somebody's, and stays.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from telespring._errors import InvalidInput

__all__ = ["Describe", "dataset_identity", "require_claimable", "require_same"]

#: What a folder holds.
Kind = Literal["rehearsal", "comparison", "sweep"]

#: In what the thing with this identity differs from one's own; None if in nothing. ValueError, KeyError or
#: TypeError for a text that is no identity; None is a file without one.
Describe = Callable[[str | None], str | None]


def require_same(folder: Path, kind: Kind, stored: str | None, describe: Describe) -> None:
    """Refuse the folder unless this stored identity is one's own."""
    try:
        difference = describe(stored)
    except (ValueError, KeyError, TypeError):
        raise InvalidInput(
            "out",
            str(folder),
            f"this folder has files that are named like those of a {kind} but are not from one",
            "Choose another folder, or start over with --fresh (fresh=True), which removes them.",
        ) from None
    if difference is not None:
        raise InvalidInput(
            "out",
            str(folder),
            f"this folder contains {difference}",
            "Choose another folder, or start over with --fresh (fresh=True), which removes it.",
        )


def require_claimable(
    identity_file: Path, kind: Kind, describe: Describe, has_finished: Callable[[str], bool]
) -> None:
    """Refuse a folder with finished trials of another identity, or with a file that is no identity.

    `has_finished` says whether trials of the stored identity are finished.
    """
    if not identity_file.exists():
        return
    stored = identity_file.read_bytes().decode(errors="replace")
    try:
        describe(stored)
    except (ValueError, KeyError, TypeError):
        is_identity = False
    else:
        is_identity = True
    if not is_identity or has_finished(stored):
        require_same(identity_file.parent, kind, stored, describe)


def dataset_identity(dataset: Path) -> str | None:
    """Read the identity that a netCDF dataset carries; None where the file has none."""
    import h5netcdf

    try:
        with h5netcdf.File(dataset, "r") as file:
            return str(file.attrs["identity"])
    except PermissionError:
        raise
    except (OSError, KeyError):
        return None
