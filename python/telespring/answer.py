"""The answer of the command `decide` and of `telespring.decide`: one object that shows itself."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, replace
from functools import cache
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console

from telespring._core import Coupling, Dyad, Network, OperatorRange, Study
from telespring._errors import InvalidInput
from telespring._html import table
from telespring._types import Delay, Status
from telespring.decision.arm_stability import arm_stability
from telespring.decision.decide import Decision
from telespring.decision.decide import decide as judge
from telespring.decision.limits import COMMON_DELAYS, Limits, limits
from telespring.decision.question import Question, Texts, refuse_unusual
from telespring.show.decision_json import decision_json
from telespring.show.limits_json import limits_json
from telespring.show.quantities import format_number, format_time
from telespring.show.screens.ages import ages_notes
from telespring.show.screens.decision import decision_screen
from telespring.show.screens.holders import describe_holders
from telespring.show.screens.limits import limits_screen
from telespring.show.screens.questions import delay_clause, describe_robots, session_notes

if TYPE_CHECKING:
    from rich.console import RenderableType

    from telespring.study.robot_file import RobotRecord

__all__ = ["Answer", "answer_study", "decide"]

_COLUMNS = 80
_CONTINUOUS = (
    "The network has no sample period: the controllers are taken as continuous. The command samples them "
    "every {period}; give the Network sample_period={seconds:g} for that."
)
_ARMS_LEFT_OUT = "The limits are without the arms and agents that hold the handles in the study's rehearsal."


@dataclass(frozen=True, repr=False, eq=False)
class Answer:
    """Whether a dyad is stable and by what margin; or, without a stiffness or a delay, what may be used.

    `print(answer)` shows what the command `telespring decide` shows, and `to_dict()` is its `--json`.

    Attributes
    ----------
    decision
        Verdicts, margins and remedies; None without a stiffness or without a delay.
    limits
        What may be used; None with both.
    heading
        Lines that name the study and its robots.
    holders
        What holds the handles, in a few words.
    notes
        Sentences that say how the question was understood.
    """

    decision: Decision | None
    limits: Limits | None
    heading: tuple[str, ...]
    holders: str
    notes: tuple[str, ...] = ()

    @property
    def status(self) -> Status | None:
        """The word "stable", "marginal", "unstable" or "not proven"; None where limits were asked."""
        return None if self.decision is None else self.decision.status

    @property
    def is_stable(self) -> bool:
        """Whether `telespring decide --check` passes: stable with the reserve, also if both hands let go.

        One hand that lets go alone counts where the ranges of hands begin at 0.

        The arms and agents that a study names count too, where stability with them is known.
        """
        decision = self.decision
        if decision is None or decision.status != "stable":
            return False
        arms = decision.arms
        is_stable_in_arms = arms is None or all(condition.stable for condition in arms.conditions)
        return is_stable_in_arms and (decision.free is None or decision.free.status == "stable")

    @property
    def stiffness_limit(self) -> float | None:
        """Every smaller stiffness is stable, N/m, without a playout buffer that nobody promised.

        Infinite if there is no limit; None if no delay was given; 0 where nothing is proven.
        """
        if self._is_unjudged:
            return 0.0
        if self.decision is not None:
            varying, limit = self.decision.varying, self.decision.stiffness_limit
            is_promised = self.decision.has_playout_buffer
        elif self.limits is not None and self.limits.is_delay_given:
            varying, limit = self.limits.delays[0].varying, self.limits.delays[0].stiffness_limit
            is_promised = self.limits.has_playout_buffer
        else:
            return None
        return limit if varying is None or is_promised else varying.stiffness_limit

    @property
    def _is_unjudged(self) -> bool:
        """Whether something about the study is not judged, so that nothing is proven."""
        found = self.decision or (self.limits.delays[0] if self.limits is not None else None)
        return found is not None and bool(found.question.unjudged)

    def to_dict(self) -> dict[str, Any]:
        """Return what `telespring decide --json` prints, in SI units."""
        if self.decision is not None:
            return decision_json(self.decision)
        assert self.limits is not None
        return limits_json(self.limits)

    def screen(self) -> RenderableType:
        """Return what `telespring decide` shows, for a console of rich."""
        if self.decision is not None:
            return decision_screen(self.decision, self.heading, self.holders, self.notes)
        assert self.limits is not None
        return limits_screen(self.limits, self.heading, self.holders, self.notes)

    def __str__(self) -> str:
        text = io.StringIO()
        console = Console(file=text, width=_COLUMNS, highlight=False, color_system=None)
        console.print(self.screen())
        return "\n".join(line.rstrip() for line in text.getvalue().splitlines())

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {_in_short(name, value, unit)}" for name, value, unit in self._values())
        return f"<Answer: {values}>"

    def _repr_html_(self) -> str:
        rows = {
            f"{name}, {unit}" if unit else name: _in_short(name, value, "")
            for name, value, unit in self._values()
        }
        return table("; ".join(self.heading), rows)

    def _values(self) -> list[tuple[str, float | str, str]]:
        """List what a short answer says: name, value and unit."""
        if self.decision is not None:
            decision = self.decision
            found: list[tuple[str, float | str, str]] = [
                ("status", decision.status, ""),
                ("stiffness", decision.stiffness, "N/m"),
                ("delay each way", decision.delay[0], "s"),
                ("sample period", decision.verdicts.network.sample_period, "s"),
                ("stiffness limit", self.stiffness_limit or 0.0, "N/m"),
            ]
            if decision.delay[0] != decision.delay[1]:
                found[2] = ("delay, mean of both ways", 0.5 * sum(decision.delay), "s")
            if decision.varying is None or decision.has_playout_buffer:
                found.append(("delay limit", decision.delay_limit, "s"))
            elif decision.is_as_stated:
                found.append(("status with a playout buffer", decision.constant_delay_status, ""))
            return found
        assert self.limits is not None
        found = [("sample period", self.limits.delays[0].verdicts.network.sample_period, "s")]
        for row in self.limits.delays if self.limits.stiffness is None else ():
            usable = row.recommended_stiffness
            if row.varying is not None and not self.limits.has_playout_buffer:
                usable = row.varying.recommended_stiffness
            found.append((f"usable at {delay_clause(row.delay)}", usable, "N/m"))
        given = self.limits.stiffness
        if given is not None:
            usable = given.recommended_delay
            if given.recommended_delay_while_varying is not None and not self.limits.has_playout_buffer:
                usable = given.recommended_delay_while_varying
            found += [("stiffness", given.stiffness, "N/m"), ("usable delay each way", usable, "s")]
        return found


def _in_short(name: str, value: float | str, unit: str) -> str:
    if isinstance(value, str):
        return value
    if math.isinf(value):
        return "no limit"
    # What may be used must not be rounded up; what was given is not a limit.
    is_limit = name.startswith("usable") or name.endswith("limit")
    return f"{format_number(value, 5, rounding='down' if is_limit else 'nearest')} {unit}".rstrip()


def decide(
    subject: Dyad | Study,
    stiffness: float | None = None,
    delay: Delay | Network | None = None,
    *,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None = None,
    playout_buffer: bool | None = None,
    horizon: float | None = None,
    decay_rate: float | None = None,
    modules: Path | None = None,
    allow_unusual: bool = False,
    attack_seed: int | None = None,
    traces: Texts = (None, None),
) -> Answer:
    """Decide whether a dyad is stable, by what margin, and what to change; or what may be used.

    This is the command `telespring decide`: controllers are sampled every 1 ms unless a network says
    otherwise, and the answer for free handles stands beside that for held ones.

    Parameters
    ----------
    subject : Dyad or Study
        The robots and what holds them; or a study, of which stiffness, delay and operators may be replaced.
    stiffness : float, optional
        Stiffness of the virtual spring, N/m. Without it the answer is the stiffness that you may use.
    delay : float, (float, float) or Network, optional
        One-way delay each way, s, or the pair (forward, backward); or a network, whose controllers are
        continuous unless it has a sample period (a note of the answer says so). Without it the answer
        lists what common delays allow.
    operator_range : OperatorRange or pair of OperatorRange, optional
        Operators that replace the dyad's own; the answer holds for all of them.
    playout_buffer : bool, optional
        Whether both sides hold every sample until it is as old as the latest one can be, so that a delay with
        jitter or gaps is constant. The default is what the study says, or False.
    horizon : float, optional
        List stable delays up to this one, s. The default is 1 s, or twice the delay if that is more.
    decay_rate : float, optional
        Also find the stiffnesses at which every motion decays at this rate or faster, 1/s.
    modules : Path, optional
        Where a target in Python that the study names is looked up first: the folder of its file.
    allow_unusual : bool
        Whether to accept values that no laboratory has, such as a delay of 80 s.
    attack_seed : int, optional
        Also search, from seeded starts, the lowest stiffness at which a delay that varies by the network's
        jitter and gaps can make the motion grow: `answer.decision.varying.attack`. It takes about a second,
        and several where the ages are spread wide.
    traces : (str or None, str or None)
        The content of the recorded traces that a study names (`Study.trace_files`), forward and backward. The
        command reads the files; without them a study with a trace is "not proven".

    Returns
    -------
    Answer
        The answer; `print` shows it whole. A study is judged with the ages that its network and session
        make of each motion: `Study.judged_network`.

    Raises
    ------
    InvalidInput
        If a value is out of range, or no laboratory has it.

    Examples
    --------
    >>> import telespring as ts
    >>> mine = ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot(2.0, 9.0))
    >>> ts.decide(mine, 150.0, 0.04)
    <Answer: status stable, stiffness 150 N/m, delay each way 0.04 s, sample period 0.001 s, ...>
    >>> ts.decide(mine, delay=0.04).limits.delays[0].usable_stiffness  # N/m
    190.4...
    >>> jittery = ts.Network(0.04, jitter=0.04, sample_period=0.001)
    >>> [ts.decide(mine, 100.0, jittery, playout_buffer=given).status for given in (True, False)]
    ['stable', 'not proven']
    """
    values: dict[str, object] = {
        "stiffness": stiffness,
        "horizon": horizon,
        "decay_rate": decay_rate,
        "delay": delay,
    }
    for field, value in values.items():
        is_number = isinstance(value, Real) and not isinstance(value, bool | np.bool_)
        if (value is not None and not is_number and field != "delay") or isinstance(value, bool | np.bool_):
            raise InvalidInput(field, repr(value)[:60], "a real number is required", "Give one number.")
    if not isinstance(playout_buffer, bool | None):
        raise InvalidInput(
            "playout_buffer",
            repr(playout_buffer)[:60],
            "True, False or None is required",
            "Pass True only if both sides hold every sample until it is as old as the latest one can be.",
        )
    if isinstance(subject, Study):
        study = _changed(subject, stiffness, delay, allow_unusual=allow_unusual)
        if playout_buffer is not None and playout_buffer != study.has_playout_buffer:
            study = study.replace(network={"playout_buffer": playout_buffer})
        dyad, ranges = study.dyad, None
        stiffness = study.stiffness if study.has_stiffness else None
        network = study.network if study.has_delay else study.replace(network={"delay": 0.0}).network
        is_delay_given = study.has_delay
    elif isinstance(subject, Dyad):
        study, dyad, ranges = None, subject, None
        is_delay_given = delay is not None
        network = (
            delay if isinstance(delay, Network) else Network(delay or 0.0, sample_period=_sample_period())
        )
    else:
        raise InvalidInput(
            "subject",
            repr(subject)[:60],
            "a Dyad or a Study is required",
            "Pass Dyad(Robot(mass, damping), Robot(mass, damping)).",
        )
    if stiffness is not None:
        stiffness = Coupling(stiffness).stiffness  # refuses what is no stiffness
    if operator_range is not None:
        ranges = _both(operator_range)
    if not allow_unusual and (study is None or operator_range is not None):
        refuse_unusual(dyad, network, ranges, stiffness)
    question = (
        Question(dyad, network, ranges, bool(playout_buffer))
        if study is None
        else _question_of(study, ranges, traces)
    )
    return _answer(
        question,
        stiffness,
        study=study,
        is_delay_given=is_delay_given,
        horizon=horizon,
        decay_rate=decay_rate,
        modules=modules,
        notes=_sampling_notes(delay),
        attack_seed=attack_seed,
    )


def answer_study(
    study: Study,
    *,
    name: str | None = None,
    robot_names: tuple[str | None, str | None] | None = None,
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    notes: tuple[str, ...] = (),
    horizon: float | None = None,
    decay_rate: float | None = None,
    modules: Path | None = None,
    attack_seed: int | None = None,
    traces: Texts = (None, None),
) -> Answer:
    """Answer the question of a study, whose values were checked as it was read.

    `name` and `robot_names` are shown instead of the study's own, `records` is what identification
    recorded, `traces` are those of the network, and `notes` say how the question was understood.
    """
    return _answer(
        _question_of(study, None, traces),
        study.stiffness if study.has_stiffness else None,
        study=study,
        is_delay_given=study.has_delay,
        horizon=horizon,
        decay_rate=decay_rate,
        modules=modules,
        name=name,
        robot_names=robot_names,
        records=records,
        notes=notes,
        attack_seed=attack_seed,
    )


def _answer(
    question: Question,
    stiffness: float | None,
    *,
    study: Study | None,
    is_delay_given: bool,
    horizon: float | None,
    decay_rate: float | None,
    modules: Path | None,
    name: str | None = None,
    robot_names: tuple[str | None, str | None] | None = None,
    records: tuple[RobotRecord | None, RobotRecord | None] = (None, None),
    notes: tuple[str, ...] = (),
    attack_seed: int | None = None,
) -> Answer:
    names = robot_names or ((None, None) if study is None else study.robot_names)
    title = (study.name if study is not None else "") if name is None else name
    springs = question.robot_springs
    heading = (*((title,) if title else ()), *describe_robots(question.dyad, names, springs))
    if study is not None:
        said = ages_notes(question.ages, question.stated, is_delay_given=is_delay_given)
        proven = study.guard_overdraft(1.0).proven_stiffness
        notes = (*notes, *session_notes(study.session, proven), *said)
    holders = describe_holders(question.dyad, question.operator_ranges, springs)
    if attack_seed is not None and (question.network.is_constant or not question.is_bounded):
        raise InvalidInput(
            "attack_seed",
            f"{attack_seed}",
            "an attack varies the delay, and this delay is constant"
            if question.is_bounded
            else "an attack keeps the ages of the samples in a range, and nothing bounds these",
            "Give the network a jitter or a longest gap, or leave it out.",
        )
    if stiffness is None or not is_delay_given:
        asked = ("horizon", horizon), ("decay_rate", decay_rate), ("attack_seed", attack_seed)
        for field, value in asked:
            if value is not None:
                raise InvalidInput(
                    field,
                    f"{value:g}",
                    "it concerns one stiffness and one delay",
                    "Give stiffness and delay, or leave it out.",
                )
        delays = None if is_delay_given else COMMON_DELAYS
        found = limits(
            question,
            stiffness,
            delays=delays,
            uncertainty=(None, None) if study is None else study.uncertainty,
            records=records,
            compare_free=True,
        )
        if study is not None and study.names_arms_or_agents:
            notes = (*notes, _ARMS_LEFT_OUT)
        return Answer(None, found, heading, holders, notes)
    if horizon is not None and not 0.0 < horizon <= 1000.0:
        raise InvalidInput(
            "horizon",
            f"{horizon:g}",
            "a horizon must be a number above 0 and up to 1000 s",
            "Leave it out for the default.",
        )
    decision = judge(
        question,
        stiffness,
        horizon=horizon,
        decay_rate=decay_rate,
        uncertainty=(None, None) if study is None else study.uncertainty,
        records=records,
        compare_free=True,
        attack_seed=attack_seed,
    )
    if study is not None and study.names_arms_or_agents and study.experiment is not None:
        condition = (decision.stiffness, decision.constant_delay)
        decision = replace(decision, arms=arm_stability(study, [condition], modules))
    return Answer(decision, None, heading, holders, notes)


def _sampling_notes(delay: Delay | Network | None) -> tuple[str, ...]:
    """Say that a network without a sample period is judged otherwise than by the command."""
    if not isinstance(delay, Network) or delay.sample_period > 0.0:
        return ()
    period = _sample_period()
    return (_CONTINUOUS.format(period=format_time(period), seconds=period),)


def _both(
    given: OperatorRange | tuple[OperatorRange, OperatorRange],
) -> tuple[OperatorRange, OperatorRange]:
    pair = tuple(given) if isinstance(given, tuple | list) else (given, given)
    if len(pair) != 2 or not all(isinstance(each, OperatorRange) for each in pair):
        raise InvalidInput(
            "operator_range",
            repr(given)[:60],
            "an OperatorRange, a pair of them, or None is required",
            "Pass OperatorRange(low, high), two operators.",
        )
    return pair[0], pair[1]


def _changed(
    study: Study, stiffness: float | None, delay: Delay | Network | None, *, allow_unusual: bool
) -> Study:
    changes: dict[str, object] = {}
    if stiffness is not None:
        changes["coupling"] = {"stiffness": stiffness}
    if isinstance(delay, Network):
        changes["network"] = delay
    elif delay is not None:
        forward, backward = Network(delay).delay  # refuses what is no delay
        changes["network"] = {"delay": {"forward": forward, "backward": backward}}
    if allow_unusual:
        changes["allow_unusual"] = True
    return study.replace(**changes) if changes else study


def _question_of(study: Study, ranges: tuple[OperatorRange, OperatorRange] | None, traces: Texts) -> Question:
    """Return the question of a study; one without a delay is asked at several."""
    return Question.of_study(study, ranges, delay=None if study.has_delay else 0.0, traces=traces)


@cache
def _sample_period() -> float:
    """Return the sample period of a study that gives none, s."""
    robot = {"mass": 1.0, "damping": 1.0}
    return Study.from_toml("", robot1=robot, robot2=robot, network={"delay": 0.0}).network.sample_period
