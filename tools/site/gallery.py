"""How the gallery is run: every script, in the order of its number; one that fails stops the build.

sphinx-gallery runs a script anew when it has changed. Its picture depends on the package, too: where that has
changed, all are run.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

__all__ = ["configuration", "forget_stale_pictures"]


def configuration(docs: Path) -> dict[str, Any]:
    """Return the settings of sphinx-gallery."""
    return {
        "examples_dirs": [str(docs / "gallery")],
        "gallery_dirs": ["_generated/gallery"],
        "filename_pattern": r"/plot_",
        "within_subsection_order": "FileNameSortKey",
        "remove_config_comments": True,
        "show_memory": False,
        "min_reported_time": 1e9,  # times differ from build to build
        "write_computation_times": False,
        "download_all_examples": False,
        "show_signature": False,
        "image_srcset": ["2x"],
        "abort_on_example_error": True,
        "matplotlib_animations": False,
        "capture_repr": (),
    }


def _digest(package: Path) -> str:
    found = hashlib.sha256()
    for path in sorted(path for kind in ("*.py", "*.so", "*.toml") for path in package.rglob(kind)):
        found.update(f"{path.relative_to(package)}\0".encode())
        found.update(path.read_bytes())
    return found.hexdigest()


def forget_stale_pictures(gallery: Path, package: Path) -> None:
    """Let sphinx-gallery run every script anew if the package is another one than last time."""
    gallery.mkdir(parents=True, exist_ok=True)
    note, digest = gallery / "package.sha256", _digest(package)
    if not note.exists() or note.read_text(encoding="ascii") != digest:
        for path in gallery.glob("*.md5"):
            path.unlink()
        note.write_text(digest, encoding="ascii")
