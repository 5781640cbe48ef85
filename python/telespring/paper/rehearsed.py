"""Rehearsals for the report: the study's own, which several sections read, and short ones beside it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from telespring.model import Study
from telespring.paper.scene import Scene

__all__ = ["rehearsed_study", "short_rehearsal"]


@contextmanager
def rehearsed_study(scene: Scene) -> Iterator[Path]:
    """Run the study's protocol, or resume it, and give the file of its dataset.

    It is in the scene's folder, where the next section finds it finished; without a folder it is gone after
    the block.
    """
    from telespring.rehearsal.run import run_protocol

    with TemporaryDirectory(prefix="telespring-") as temporary:
        folder = scene.rehearsal or Path(temporary)
        yield run_protocol(scene.study, folder, modules=scene.modules, replace_others=True).dataset


def short_rehearsal(study: Study, folder: Path, scene: Scene) -> Path:
    """Run the protocol of another study in a folder, with the scene's programs; return its dataset."""
    from telespring.rehearsal.run import run_protocol

    return run_protocol(study, folder, modules=scene.modules, replace_others=True).dataset
