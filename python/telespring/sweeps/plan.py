"""The points of a sweep and the study at each of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any

from telespring._core import Experiment, Study, trial_seed
from telespring._errors import InvalidInput
from telespring.rehearsal.schedule import ScheduledTrial
from telespring.sweeps.draws import drawn_robots, require_uncertainty
from telespring.sweeps.over import Over, read_overs

__all__ = ["QUICK_TRIALS", "SweepPlan", "plan_sweep"]

#: Trials of each condition, and draws, in a quick sweep.
QUICK_TRIALS, QUICK_DRAWS = 2, 3
_MOST_UNITS = 100_000_000
#: Keys that decide how many conditions a protocol has.
_OF_THE_CONDITIONS = {f"protocol.{key}" for key in ("unconnected", "stiffness", "delay", "conditions")}


@dataclass(frozen=True)
class SweepPlan:
    """Everything that a sweep computes, small enough to be sent to every worker.

    Attributes
    ----------
    study
        The study at no point in particular.
    over
        The keys with their values: the points are all combinations, the last key fastest.
    draws
        Draws of the robots at each combination; 0 without Monte Carlo.
    seed
        Of the draws.
    conditions, trials
        Conditions of the protocol at every point, and trials of each; no trials without a rehearsal.
    """

    study: Study
    over: tuple[Over, ...]
    draws: int
    seed: int
    conditions: int
    trials: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions: those of the keys, and of the draws if there are any."""
        lengths = tuple(len(each.values) for each in self.over)
        return (*lengths, self.draws) if self.draws else lengths

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def units(self) -> int:
        """Number of trials of all points together."""
        return self.points * self.conditions * self.trials

    def study_at(self, point: int) -> Study:
        """Return the study at a point as its author knows it; InvalidInput says where it cannot be.

        Protocol and controllers follow from it. Its robots are the identified ones: see `drawn_at`.
        """
        places = self._places(point)
        with self._saying_where(places):
            study = _changed(self.study, self.over, places)
            self._check_conditions(study)
        return study

    def drawn_at(self, point: int) -> Study:
        """Return the study at a point with the robots that are truly there: drawn, if robots are."""
        study = self.study_at(point)
        if not self.draws:
            return study
        places = self._places(point)
        with self._saying_where(places):
            # A draw may be lighter than what a study is usually asked for.
            return study.replace(allow_unusual=True, **drawn_robots(study, self.seed, places[-1]))

    def _places(self, point: int) -> list[int]:
        """Return the places of a point along all dimensions."""
        places = []
        for length in reversed(self.shape):
            point, here = divmod(point, length)
            places.append(here)
        return places[::-1]

    @contextmanager
    def _saying_where(self, places: Sequence[int]) -> Iterator[None]:
        """Add the values of the keys to a refusal."""
        try:
            yield
        except InvalidInput as refused:
            values = zip(self.over, places, strict=False)
            where = ", ".join(f"{each.key}={each.value(here)}" for each, here in values)
            raise InvalidInput(
                refused.field, refused.value, f"{refused.allowed}, at {where or 'this draw'}", refused.remedy
            ) from None

    def scheduled(self, unit: int, experiment: Experiment) -> ScheduledTrial:
        """Return the trial of a unit: condition by condition within its point."""
        condition, trial = divmod(unit % (self.conditions * self.trials), self.trials)
        # The order of running is nobody's business here.
        return ScheduledTrial(condition, trial, trial_seed(experiment.seed, condition, trial), order=0)

    def point_of(self, unit: int) -> int:
        """Return the point of a trial."""
        return unit // (self.conditions * self.trials)

    def values_by_themselves(self) -> Iterator[Study]:
        """Yield the study with each value of each key, the others being their first."""
        for i, each in enumerate(self.over):
            for place in range(len(each.values)):
                yield _changed(self.study, self.over, [place if j == i else 0 for j in range(len(self.over))])

    def _check_conditions(self, study: Study) -> None:
        experiment = study.experiment
        if not self.trials or experiment is None:
            return
        size = len(experiment.conditions), experiment.trials
        if size != (self.conditions, self.trials):
            keys: set[str] = {"protocol.trials"} if size[1] != self.trials else set()
            if size[0] != self.conditions:
                keys |= _OF_THE_CONDITIONS
            swept = [each.key for each in self.over if each.key in keys]
            raise InvalidInput(
                "protocol",
                f"{size[0]} conditions × {size[1]} trials",
                f"every point needs as many as the first, {self.conditions} × {self.trials}",
                f"Run a sweep for each number of them, in a folder of its own, rather than over {swept[0]}."
                if swept
                else "Write protocol.stiffness, protocol.delay and protocol.trials into the study.",
            )


def plan_sweep(
    study: Study,
    over: Mapping[str, Any] | Sequence[str] | None,
    *,
    draws: int = 0,
    seed: int = 1,
    trials: bool = True,
    quick: bool = False,
) -> SweepPlan:
    """Plan a sweep; InvalidInput where a value of a key is refused by itself."""
    keys = read_overs(over)
    if not keys and not draws:
        raise InvalidInput(
            "over",
            "",
            "something to sweep over",
            "Write --over key=values, or --draws N for robots drawn from their uncertainty.",
        )
    if draws < 0 or not 0 <= seed < 2**63:
        raise InvalidInput(
            "draws",
            f"{draws}, seed {seed}",
            "draws of 0 or more, and a seed from 0 to 2⁶³ − 1",
            "Correct it.",
        )
    if quick:
        keys, draws = tuple(each.thinned() for each in keys), min(draws, QUICK_DRAWS)
        experiment = study.experiment
        if experiment is not None and experiment.trials > QUICK_TRIALS:
            study = study.replace(protocol={"trials": QUICK_TRIALS})
    first = _changed(study, keys, [0] * len(keys))
    experiment = first.experiment if trials else None
    conditions = 1 if experiment is None else len(experiment.conditions)
    plan = SweepPlan(study, keys, draws, seed, conditions, 0 if experiment is None else experiment.trials)
    if max(plan.points, plan.units) > _MOST_UNITS:
        raise InvalidInput(
            "over",
            f"{plan.points} points, {plan.units} trials",
            f"a sweep has at most {_MOST_UNITS}",
            "Take fewer values; telespring.survey_dyads counts 10⁹ dyads without storing them.",
        )
    # A slip is refused before anything runs.
    studies = [first, *islice(plan.values_by_themselves(), 1000)]
    if draws:
        require_uncertainty(studies)
    return plan


def _changed(study: Study, over: Sequence[Over], places: Sequence[int]) -> Study:
    """Return a study with one value of each key."""
    changes: dict[str, dict[str, Any]] = {}
    for each, place in zip(over, places, strict=False):
        for section, keys in each.changes(place).items():
            changes.setdefault(section, {}).update(keys)
    return study.replace(**changes) if changes else study
