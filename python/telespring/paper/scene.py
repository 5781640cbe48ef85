"""A study as the sections of the report see it, with its axes and the reference values K and Δ."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from telespring.model import Architecture, Dyad, DyadAxis, Robot, Study, hman
from telespring.paper.reference import Reference, check_figure_ranges, reference_of
from telespring.show.figures import StudyMark

__all__ = ["DEFAULT_DELAY", "Scene"]

#: One-way delay of a study that gives none, s.
DEFAULT_DELAY = 0.1


@dataclass(frozen=True)
class Scene:
    """A study with what the sections of the report share.

    Attributes
    ----------
    study
        The study to reproduce the paper for; without a stiffness or a delay of its own, with `DEFAULT_DELAY`
        and twice K.
    is_condition_given
        Whether the study itself has a stiffness and a delay.
    axes
        Its axes, operators added to the robots.
    reference
        K and Δ of these axes (Eq. 11), for the middle of the operators' ranges.
    identical, identical_axis, identical_reference
        The paper's one-axis case: two robots that are both robot 1 on its first axis, handles free, as a
        dyad and as an axis, with their K and Δ.
    rehearsal
        Folder for the experiment's trials; None: they are not kept.
    modules
        Folder in which Python agents and targets are looked up first.
    """

    study: Study
    is_condition_given: bool
    axes: list[DyadAxis]
    reference: Reference
    identical: Dyad
    identical_axis: DyadAxis
    identical_reference: Reference
    rehearsal: Path | None = None
    modules: Path | None = None

    @classmethod
    def of(cls, study: Study, rehearsal: Path | None = None, modules: Path | None = None) -> Scene:
        """Prepare a study; refuse robots whose figures would leave the ranges in which the core computes."""
        dyad = study.dyad
        axes = list(dyad)
        mass, damping = float(dyad.robots[0].mass[0]), float(dyad.robots[0].damping[0])
        identical_axis = DyadAxis(mass, damping, mass, damping)
        check_figure_ranges(dyad, axes, identical_axis)
        reference = reference_of(axes)
        given = study.has_stiffness and study.has_delay
        if not study.has_stiffness:
            study = study.replace(coupling={"stiffness": 2.0 * reference.stiffness})
        if not study.has_delay:
            study = study.replace(network={"delay": DEFAULT_DELAY})
        return cls(
            study=study,
            is_condition_given=given,
            axes=axes,
            reference=reference,
            identical=Dyad(Robot([mass], [damping]), Robot([mass], [damping])),
            identical_axis=identical_axis,
            identical_reference=reference_of([identical_axis]),
            rehearsal=rehearsal,
            modules=modules,
        )

    @property
    def of_the_paper(self) -> bool:
        """Whether these are the paper's own robots with free handles, for which it prints results."""
        paper = hman()
        return [axis.parameters for axis in self.axes] == [paper[name].parameters for name in paper.axes]

    @property
    def of_the_papers_experiment(self) -> bool:
        """Whether the paper's robots do its task with its kinds of agents and its spring, as in Table I."""
        experiment, printed = self.study.experiment, Study.paper().experiment
        if experiment is None or printed is None or not self.of_the_paper:
            return False
        kinds, printed_kinds = ([agent.kind for agent in e.agents] for e in (experiment, printed))
        is_bare_spring = self.study.session == Architecture()
        return experiment.task == printed.task and kinds == printed_kinds and is_bare_spring

    @property
    def mark(self) -> StudyMark | None:
        """The study on a map: stiffness, delay, and that behind a playout buffer; None without them."""
        if not self.is_condition_given:
            return None
        study, network = self.study, self.study.network
        delay = 0.5 * sum(study.delay)
        return StudyMark(study.stiffness, delay, delay + network.jitter + network.max_gap)

    def robot_name(self, index: int) -> str:
        """Name of robot 0 or 1 in the study, or else its number."""
        return self.study.robot_names[index] or f"robot {index + 1}"

    @property
    def dyad(self) -> Dyad:
        """The robots and operators of the scene's study."""
        return self.study.dyad

    def describe_study(self) -> dict[str, Any]:
        """Return the key `study` of `study.json`: coupling, network and axes as they were read."""
        study = self.study
        return {
            "name": study.name,
            "of_the_paper": self.of_the_paper,
            "stiffness": study.stiffness if self.is_condition_given else None,
            "delay": {"forward": study.delay[0], "backward": study.delay[1]}
            if self.is_condition_given
            else None,
            "operator_ranges": study.operator_ranges is not None,
            "jitter": study.network.jitter,
            "max_gap": study.network.max_gap,
            "sample_period": study.network.sample_period,
            "computing_time": study.network.computing_time,
            "axes": [
                {
                    "axis": axis.name,
                    "mass": list(axis.masses),
                    "damping": list(axis.dampings),
                    "operator_stiffness": list(axis.ground_stiffness),
                    "coupling_damping": axis.coupling_damping,
                }
                for axis in self.axes
            ],
        }
