"""The files that a study names, copied beside the recommended study so that it can be rehearsed there."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from telespring._errors import InvalidInput
from telespring._files import write_whole
from telespring.comparison.schedule import ComparisonSchedule

__all__ = ["Companion", "study_companions"]


@dataclass(frozen=True)
class Companion:
    """A recorded trace, or the module of an agent or a target.

    Attributes
    ----------
    name
        Its path relative to the folder of the study.
    source
        Where it is.
    digest
        SHA-256 of its content.
    """

    name: str
    source: Path
    digest: str

    def check(self, folder: Path) -> None:
        """Refuse a folder in which another file has its name."""
        target = folder / self.name
        if target.exists() and not target.samefile(self.source) and _digest(target) != self.digest:
            raise InvalidInput(
                "out",
                str(folder),
                f"{self.name} of the study is copied there, and another file of this name is in the way",
                "Choose another folder, or remove that file if it is an older copy.",
            )

    def copy(self, folder: Path) -> None:
        """Copy it to a folder, unless it is there."""
        target = folder / self.name
        if not target.exists():
            write_whole(target, self.source.read_bytes())


def study_companions(schedule: ComparisonSchedule, modules: Path | None) -> list[Companion]:
    """List the files of a study in its folder.

    A module that is installed and a trace with an absolute path are found from everywhere. What is outside
    of the folder stays there.
    """
    folder = Path() if modules is None else modules
    names: dict[str, None] = {}
    for cell in schedule.cells:
        experiment = cell.experiment
        references = [agent.class_ for agent in experiment.agents] + [experiment.task.function]
        names |= {f"{reference.partition(':')[0]}.py": None for reference in references if reference}
        names |= {name: None for name in experiment.trace_files if name}
    return [
        Companion(name, folder / name, _digest(folder / name))
        for name in names
        if not Path(name).is_absolute() and ".." not in Path(name).parts and (folder / name).is_file()
    ]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
