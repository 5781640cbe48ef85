"""The folder of examples as one file, for readers who have a wheel and no sources."""

from __future__ import annotations

import zipfile
from pathlib import Path

__all__ = ["write"]

#: The first day that the format knows: the same files give the same bytes on every day.
_DATE = (1980, 1, 1, 0, 0, 0)


def write(target: Path, folder: Path) -> None:
    """Write the files of a folder into an archive, under the folder's own name."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            place = file.relative_to(folder)
            if not file.is_file() or any(part.startswith((".", "__")) for part in place.parts):
                continue
            entry = zipfile.ZipInfo(f"{folder.name}/{place.as_posix()}", _DATE)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, file.read_bytes(), zipfile.ZIP_DEFLATED)
