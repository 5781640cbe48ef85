"""How the gallery is run: every script, in the order of its number; one that fails stops the build."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["configuration"]


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
