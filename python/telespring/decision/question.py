"""One question about a dyad and its network, judged at any stiffness, delay and damping."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from telespring import _core
from telespring._core import JudgedNetwork, check_usual
from telespring.model import Dyad, Network, Operator, OperatorRange, Study
from telespring.theory.verdicts import AxisTier, AxisVerdict, DelayLimit, Verdicts, verdicts

if TYPE_CHECKING:
    from telespring._types import Delay
    from telespring.study.robot_file import RobotRecord

__all__ = ["Question", "Texts", "are_axes_independent", "constant_delay_tier", "refuse_unusual"]

#: The content of recorded traces, forward and backward.
Texts: TypeAlias = tuple[str | None, str | None]


def constant_delay_tier(axis: AxisVerdict) -> AxisTier:
    """Return the verdict on one axis at one known constant delay."""
    return next(tier for tier in axis.tiers if tier.tier == "constant delay")


@dataclass(frozen=True)
class Question:
    """A dyad over a network, for one pair of operators or for ranges of them; the home of what is asked.

    What is decided about it is decided by its `core`, which the page asks, too.

    Attributes
    ----------
    dyad
        The robots, and their operators unless these are ranges.
    network
        The network and the timing of the controllers.
    operator_ranges
        The ranges of both operators; None for the dyad's own.
    has_playout_buffer
        Whether both sides promise to hold every sample until it is as old as the latest one, which makes the
        delay constant.
    robot_springs
        The robots' own springs to the ground, which the operators include and which stay when hands let go;
        None without any.
    ages
        What the study's network and session make of the ages in use, where `network` comes from a study.
    stated
        The network as that study states it; None without a study.
    study, traces
        The study, and the content of the recorded traces that it names: for the same question at another
        delay of the network.
    """

    dyad: Dyad
    network: Network
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None
    has_playout_buffer: bool = False
    robot_springs: tuple[Operator, Operator] | None = None
    ages: JudgedNetwork | None = None
    stated: Network | None = None
    study: Study | None = None
    traces: Texts = (None, None)

    @classmethod
    def of_study(
        cls,
        study: Study,
        operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
        *,
        delay: Delay | None = None,
        traces: Texts = (None, None),
    ) -> Question:
        """Ask about a study: its robots, with the ages that its network and session make of each motion.

        `delay` takes the place of the network's, s; `traces` are the recorded traces that the study names.

        Examples
        --------
        >>> import telespring as ts
        >>> study = ts.Study.paper().replace(network={"delay": 0.05, "loss": 0.01})
        >>> Question.of_study(study).network.jitters  # ages of 49 to 57 ms
        (0.008, 0.008)
        """
        plain = study.network if delay is None else study.replace(network={"delay": 0.0}).network
        stated = plain if delay is None else _at(plain, delay)
        ages = study.judged_network(delay, traces)
        question = cls.of(study, ages.network, operator_ranges, has_playout_buffer=ages.has_playout_buffer)
        return replace(question, ages=ages, stated=stated, study=study, traces=traces)

    @classmethod
    def of(
        cls,
        study: Study,
        network: Network,
        operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
        *,
        has_playout_buffer: bool | None = None,
    ) -> Question:
        """Ask about the robots of a study on this network, whatever the study's own network and session do.

        Ranges of hands take the place of the study's own operators.
        """
        springs = None
        if study.ground_stiffness.any():
            one, other = (Operator(stiffness=spring.tolist()) for spring in study.ground_stiffness)
            springs = one, other
        ranges = study.operator_ranges
        if operator_ranges is not None:
            ranges = operator_ranges
            if springs is not None:
                ranges = _with_spring(ranges[0], springs[0]), _with_spring(ranges[1], springs[1])
        has_buffer = study.has_playout_buffer if has_playout_buffer is None else has_playout_buffer
        return cls(study.dyad, network, ranges, has_buffer, springs)

    def at_network_delay(self, delay: Delay) -> Question:
        """Return the question on the same network with another one-way delay, s."""
        if self.study is None:
            return replace(self, network=_at(self.network, delay))
        ages = self.study.judged_network(delay, self.traces)
        assert self.stated is not None  # it comes with the study
        return replace(
            self,
            network=ages.network,
            has_playout_buffer=ages.has_playout_buffer,
            ages=ages,
            stated=_at(self.stated, delay),
        )

    @property
    def core(self) -> _core.Question:
        """The question as the core asks it."""
        return _core.Question(
            self.dyad,
            self.network,
            self.operator_ranges,
            self.has_playout_buffer,
            self.robot_springs,
            self.ages,
        )

    @property
    def is_bounded(self) -> bool:
        """Whether the ages of the motion in use have a bound."""
        return self.core.is_bounded

    @property
    def is_as_stated(self) -> bool:
        """Whether delay, jitter and gap are all that makes the ages: a playout buffer takes them up."""
        return self.core.is_as_stated

    @property
    def network_as_stated(self) -> Network:
        """The network as the study states it; without a study the one in question."""
        return self.network if self.stated is None else self.stated

    @property
    def unjudged(self) -> tuple[str, ...]:
        """What no verdict judges; if there is any, nothing is proven."""
        return () if self.ages is None else self.ages.unjudged

    @property
    def is_varying(self) -> bool:
        """Whether the age of the motion in use varies, if nobody promises a playout buffer."""
        return self.core.is_varying

    @property
    def sampling(self) -> tuple[float, float]:
        """Sample period and computing time of the controllers, s."""
        return self.network.sample_period, self.network.computing_time

    @property
    def is_held(self) -> bool:
        """Whether anything holds a handle besides the robot's own spring."""
        return self.core.is_held

    def released(self) -> Question:
        """Return the question with free handles: only the robots' own springs stay."""
        return self.with_operators(self.robot_springs)

    @property
    def leaves_out_one_hand(self) -> bool:
        """Whether neither this question nor the one with free handles has one hand that lets go alone."""
        least = most = self.dyad.operators
        if self.operator_ranges is not None:
            one, other = self.operator_ranges
            least, most = (one.low, other.low), (one.high, other.high)
        return all(self._robots_held(most)) and any(self._robots_held(least))

    def _robots_held(self, hands: tuple[Operator, Operator]) -> tuple[bool, bool]:
        """Check for each robot whether its hand holds it."""
        free = self.released().dyad.operators
        return self.with_operators((hands[0], free[1])).is_held, self.with_operators(
            (free[0], hands[1])
        ).is_held

    def with_operators(self, operators: tuple[Operator, Operator] | None) -> Question:
        """Return the question with these operators in place of hands and springs."""
        dyad = Dyad(*self.dyad.robots, operators, self.dyad.coupling_damping)
        return replace(self, dyad=dyad, operator_ranges=None)

    def judge(self, stiffness: float, attack_seed: int | None = None) -> Verdicts:
        """Return the verdicts at this stiffness, N/m; with a seed an attack is searched, too."""
        return _judged(self.dyad, stiffness, self.network, self.operator_ranges, attack_seed)

    def at_delay(self, delay: float | tuple[float, float]) -> Question:
        """Return the question at this constant delay, s."""
        period, computing = self.sampling
        return replace(self, network=Network(delay, sample_period=period, computing_time=computing))

    def held_by(self, judged: Verdicts) -> Dyad:
        """Return the dyad with the operators that allow the least stiffness at the delay, axis by axis."""
        if self.operator_ranges is None:
            return self.dyad
        pairs = [constant_delay_tier(axis).operators for axis in judged.axes]
        one, other = (
            Operator(
                [pair[side].mass for pair in pairs],
                [pair[side].damping for pair in pairs],
                [pair[side].stiffness for pair in pairs],
            )
            for side in range(2)
        )
        return Dyad(*self.dyad.robots, (one, other), self.dyad.coupling_damping)

    def delay_limit(self, judged: Verdicts) -> DelayLimit:
        """Return the first delay, the mean of both ways, that is unstable at the stiffness judged.

        Both ways grow in the proportion that they have in the network.
        """
        return self.core.delay_limit(judged)


def _at(network: Network, delay: Delay) -> Network:
    """Return a network with another delay, s."""
    timing = network.jitters, network.max_gap, network.sample_period, network.computing_time
    return Network(delay, *timing)


@lru_cache(maxsize=64, typed=True)
def _judged(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    ranges: tuple[OperatorRange, OperatorRange] | None,
    attack_seed: int | None,
) -> Verdicts:
    """Return the verdicts; one answer asks for the same ones several times."""
    return verdicts(dyad, stiffness, network, operator_range=ranges, attack_seed=attack_seed)


def _with_spring(hand: OperatorRange, spring: Operator) -> OperatorRange:
    low, high = (
        Operator(
            np.broadcast_to(end.mass, spring.stiffness.shape),
            np.broadcast_to(end.damping, spring.stiffness.shape),
            end.stiffness + spring.stiffness,
        )
        for end in (hand.low, hand.high)
    )
    return OperatorRange(low, high)


def are_axes_independent(records: tuple[RobotRecord | None, RobotRecord | None]) -> bool | None:
    """Return whether identification found the axes of both robots independent; None if it is not known."""
    independent = [None if record is None else record.independent for record in records]
    return False if False in independent else None if None in independent else True


def refuse_unusual(
    dyad: Dyad,
    network: Network,
    operator_ranges: tuple[OperatorRange, OperatorRange] | None = None,
    stiffness: float | None = None,
) -> None:
    """Refuse values that no laboratory has: their unit is probably wrong."""
    for number, robot in enumerate(dyad.robots, start=1):
        for i, (mass, damping) in enumerate(zip(robot.mass, robot.damping, strict=True)):
            check_usual("mass", f"robot{number}.mass[{i}]", float(mass))
            check_usual("damping", f"robot{number}.damping[{i}]", float(damping))
    check_usual("damping", "coupling_damping", float(np.max(dyad.coupling_damping)))
    ends = (
        dyad.operators
        if operator_ranges is None
        else [r for pair in operator_ranges for r in (pair.low, pair.high)]
    )
    for operator in ends:
        for quantity, values in (
            ("added mass", operator.mass),
            ("operator damping", operator.damping),
            ("ground stiffness", operator.stiffness),
        ):
            for value in values:
                check_usual(quantity, f"operator {quantity.split()[-1]}", float(value))
    if stiffness is not None:
        check_usual("stiffness", "stiffness", stiffness)
    for name, value in zip(("forward delay", "backward delay"), network.delay, strict=True):
        check_usual("delay", name, value)
    for name in ("jitter", "max_gap", "computing_time"):
        check_usual("time span", name, getattr(network, name))
    check_usual("controller period", "sample_period", network.sample_period)
