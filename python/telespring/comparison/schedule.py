"""What a comparison runs: a rehearsal for each architecture on each network, and one without a partner."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from telespring._core import Architecture, Condition, Experiment, Study
from telespring._errors import InvalidInput
from telespring.comparison.choices import LeftOut
from telespring.comparison.trying import refusal_of
from telespring.rehearsal.run import require_experiment
from telespring.study.conditions import condition_labels, distinct_labels

__all__ = ["QUICK_TRIALS", "Cell", "ComparisonSchedule", "schedule_comparison"]

#: Trials of each condition in a quick comparison.
QUICK_TRIALS = 4
#: Strategy and predictor of what a quick comparison runs.
_QUICK = (("spring", "hold"), ("guard", "hold"), ("guard", "shared-target"))


@dataclass(frozen=True)
class Cell:
    """One architecture on one network.

    Attributes
    ----------
    architecture, network
        Their places in the schedule.
    study
        Whose rehearsal it is.
    folder
        Name of its folder.
    """

    architecture: int
    network: int
    study: Study
    folder: str

    @property
    def experiment(self) -> Experiment:
        """The experiment of its study."""
        experiment = self.study.experiment
        assert experiment is not None  # `schedule_comparison` has checked it
        return experiment


@dataclass(frozen=True)
class ComparisonSchedule:
    """All rehearsals of a comparison.

    Attributes
    ----------
    study
        The study.
    architectures, labels
        What is compared, and how each is called.
    networks
        Names of the networks.
    network_studies
        The study on each of these networks, with its delays.
    conditions
        Stiffness and delay of all networks together.
    unconnected
        The study of the rehearsal without a partner.
    cells
        Architecture by architecture, each on all networks.
    left_out
        Usual architectures that the study cannot have.
    """

    study: Study
    architectures: tuple[Architecture, ...]
    labels: tuple[str, ...]
    networks: tuple[str, ...]
    network_studies: tuple[Study, ...]
    conditions: tuple[Condition, ...]
    unconnected: Study
    cells: tuple[Cell, ...]
    left_out: tuple[LeftOut, ...]

    @property
    def condition_labels(self) -> list[str]:
        """Names of the conditions."""
        return condition_labels(self.conditions)

    @property
    def experiment(self) -> Experiment:
        """The experiment on the first network: trials, times, agents."""
        return self.cells[0].experiment

    @property
    def trials(self) -> int:
        """Number of trials of all rehearsals together."""
        experiments = [cell.experiment for cell in self.cells]
        return self.experiment.trials + sum(each.trials * len(each.conditions) for each in experiments)


def schedule_comparison(
    study: Study, *, quick: bool = False, modules: Path | None = None
) -> ComparisonSchedule:
    """Plan the comparison of a study, or a quick one: few trials of the bare spring and the guard.

    `modules` is the folder in which recorded traces are looked up.

    Raises
    ------
    InvalidInput
        If the study cannot be rehearsed, has no connected condition, or names an architecture that it cannot
        have.
    """
    experiment = _comparable_experiment(study)
    names, network_studies = [], []
    trials = min(experiment.trials, QUICK_TRIALS) if quick else experiment.trials
    for name, network, delays in study.comparison.networks:
        changed = study.replace(comparison=None, protocol={"unconnected": False, "trials": trials})
        if delays is not None:
            changed = _with_delays(changed, experiment, delays)
        if network:
            changed = changed.replace(network=network)
        names.append(name)
        network_studies.append(changed)
    architectures, left_out = _possible_architectures(
        study,
        _quick_architectures(study) if quick else None,
        network_studies,
        modules,
    )
    labels = distinct_labels(architecture.label for architecture in architectures)
    cells: list[Cell] = []
    for a, architecture in enumerate(architectures):
        for n, network_study in enumerate(network_studies):
            words = (labels[a], names[n]) if len(names) > 1 else (labels[a],)
            folder = _folder_name(len(cells) + 1, *words)
            cells.append(Cell(a, n, network_study.replace(session=architecture), folder))
    return ComparisonSchedule(
        study=study,
        architectures=tuple(architectures),
        labels=tuple(labels),
        networks=tuple(names),
        network_studies=tuple(network_studies),
        conditions=_all_conditions(network_studies),
        unconnected=study.replace(
            comparison=None,
            session=None,
            network=None,
            protocol={"unconnected": True, "trials": trials, "conditions": []},
        ),
        cells=tuple(cells),
        left_out=tuple(left_out),
    )


def _comparable_experiment(study: Study) -> Experiment:
    experiment = require_experiment(study)
    if not any(stiffness is not None for stiffness, _ in experiment.conditions):
        raise InvalidInput(
            "protocol.conditions",
            "[]",
            "a comparison needs at least one condition with a spring",
            "Write conditions = [{stiffness = 71.2, delay = 0.1}], or leave it out for the usual ones.",
        )
    return experiment


def _with_delays(study: Study, experiment: Experiment, delays: Sequence[float]) -> Study:
    """Combine every stiffness of an experiment with the delays of one network."""
    stiffness = dict.fromkeys(k for k, _ in experiment.conditions if k is not None)
    return study.replace(protocol={"conditions": None, "stiffness": list(stiffness), "delay": list(delays)})


def _quick_architectures(study: Study) -> list[Architecture]:
    """List the bare spring and the guard, as the study describes them or with their usual settings."""
    described: dict[tuple[str, str], Architecture] = {
        (each.strategy, each.predictor): each
        for each in reversed(study.comparison.architectures)
        if each.playout == "fixed"
    }
    return [described.get(parts, Architecture(strategy=parts[0], predictor=parts[1])) for parts in _QUICK]


def _possible_architectures(
    study: Study, chosen: Sequence[Architecture] | None, networks: Sequence[Study], modules: Path | None
) -> tuple[list[Architecture], list[LeftOut]]:
    """Tell apart which architectures the study can have; refuse one that it names itself."""
    for network in networks:
        if (refused := refusal_of(network.replace(session=None), modules)) is not None:
            raise refused
    listed = study.comparison.architectures
    is_usual = listed == study.replace(comparison={"architectures": None}).comparison.architectures
    # The usual ones of a study with a damper are fewer.
    asked = chosen or (Study.paper().comparison.architectures if is_usual else listed)
    possible, left_out = [], []
    for place, architecture in enumerate(asked):
        refusals = (_refusal_of_architecture(network, architecture, modules) for network in networks)
        refused = next((each for each in refusals if each is not None), None)
        if refused is None:
            possible.append(architecture)
        elif is_usual or chosen:
            left_out.append(
                LeftOut(architecture.label, refused.field, refused.value, refused.allowed, refused.remedy)
            )
        else:
            raise InvalidInput(
                f"comparison.architectures[{place}]",
                architecture.label,
                refused.allowed,
                f"{refused.remedy} Or leave it out of the list.",
            )
    return possible, left_out


def _refusal_of_architecture(
    study: Study, architecture: Architecture, modules: Path | None
) -> InvalidInput | None:
    try:
        changed = study.replace(session=architecture)
    except InvalidInput as refused:
        return refused
    return refusal_of(changed, modules)


def _all_conditions(networks: Sequence[Study]) -> tuple[Condition, ...]:
    """Collect the conditions of all networks, each once, by stiffness and delay."""
    found = {
        (condition.stiffness, condition.delay): condition
        for study in networks
        for condition in require_experiment(study).conditions
    }
    return tuple(found[key] for key in sorted(found))


def _folder_name(number: int, *words: str) -> str:
    """Name a folder in letters that every file system has."""
    name = "-".join((str(number), *words)).replace(" + ", "+")
    return re.sub(r"[^A-Za-z0-9.+-]+", "-", name).strip("-.")[:80]
