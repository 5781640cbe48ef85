"""What the parts of a study have in common: what they look at, and what they give back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from telespring.model import Dyad, Robot, Study, hman
from telespring.paper.reference import Reference, reference_of, refuse_what_cannot_be_drawn
from telespring.theory.axis import Axis, axes_of, free_axis

__all__ = ["Found", "Part", "Scene"]


@dataclass(frozen=True)
class Scene:
    """A study with what every part asks of it.

    Attributes
    ----------
    study
        What was asked.
    axes
        Its axes, operators added to the robots.
    reference
        K and Δ of these axes (Eq. 11), for the middle of the operators' ranges.
    alike, alike_axis, alike_reference
        The paper's one-axis studies: two robots that are both robot 1 on its first axis, handles free,
        as a dyad and as an axis, with their K and Δ.
    rehearsal
        The folder that keeps the experiment's trials; they are not kept where it is None.
    modules
        Where agents and targets in Python are looked up first.
    """

    study: Study
    axes: list[Axis]
    reference: Reference
    alike: Dyad
    alike_axis: Axis
    alike_reference: Reference
    rehearsal: Path | None = None
    modules: Path | None = None

    @classmethod
    def of(cls, study: Study, rehearsal: Path | None = None, modules: Path | None = None) -> Scene:
        """Look at a study.

        Parameters
        ----------
        study, rehearsal, modules
            The attributes of these names.

        Raises
        ------
        telespring.InvalidInput
            Where a figure of these robots would leave the ranges in which the core computes.
        """
        dyad = study.dyad
        axes = axes_of(dyad)
        mass, damping = float(dyad.robots[0].mass[0]), float(dyad.robots[0].damping[0])
        alike_axis = free_axis(mass, damping, mass, damping)
        refuse_what_cannot_be_drawn(dyad, axes, alike_axis)
        return cls(
            study=study,
            axes=axes,
            reference=reference_of(axes),
            alike=Dyad(Robot([mass], [damping]), Robot([mass], [damping])),
            alike_axis=alike_axis,
            alike_reference=reference_of([alike_axis]),
            rehearsal=rehearsal,
            modules=modules,
        )

    @property
    def of_the_paper(self) -> bool:
        """True for the paper's own robots with free handles, of which it prints results."""
        return [axis.parameters for axis in self.axes] == [axis.parameters for axis in axes_of(hman())]

    @property
    def of_the_papers_experiment(self) -> bool:
        """True where the paper's robots also do its task with its two kinds of agents, as in its Table I."""
        experiment, printed = self.study.experiment, Study.paper().experiment
        if experiment is None or printed is None or not self.of_the_paper:
            return False
        kinds = [[agent["kind"] for agent in each.agents] for each in (experiment, printed)]
        return bool(experiment.task == printed.task and kinds[0] == kinds[1])

    def robot_name(self, index: int) -> str:
        """Name robot 0 or 1 as the study does, else by its number."""
        return self.study.robot_names[index] or f"robot {index + 1}"

    @property
    def dyad(self) -> Dyad:
        """The study's robots and operators."""
        return self.study.dyad


@dataclass(frozen=True)
class Found:
    """What one part found.

    Attributes
    ----------
    numbers
        Keys of `study.json` with their values, in SI units; no part gives another one's key.
    drawings
        Name to the text of one `<svg>` element.
    """

    numbers: Mapping[str, Any] = field(default_factory=dict)
    drawings: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Part:
    """One part of a study: its name, as a progress bar shows it, and how it is found."""

    name: str
    find: Callable[[Scene], Found]
