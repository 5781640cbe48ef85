"""Phrases that the screens of a decision and of limits share."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from rich.text import Text

from telespring._core import is_stable, stiffness_limit
from telespring.decision.changes import WIDER_TIERS
from telespring.decision.question import Question
from telespring.model import Architecture, Dyad, Network, Operator, Robot
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.theory.verdicts import Verdict, Verdicts

if TYPE_CHECKING:
    from telespring._types import Unavailable

__all__ = [
    "CONTINUOUS_TIERS",
    "IN_ORDER",
    "MAYBE_TOO_SMALL",
    "TABLE_TITLE",
    "TierBound",
    "allowed_stiffness",
    "answers_by_buffer",
    "delay_clause",
    "describe_robots",
    "free_clause",
    "given_delay",
    "hand_effect",
    "hand_rows",
    "hands_name",
    "network_clause",
    "network_fits",
    "one_hand_lines",
    "range_notes",
    "sampling_clause",
    "sampling_note",
    "session_notes",
    "tier_bounds",
    "variation_clause",
]

#: What the tiers beyond one known delay leave out.
CONTINUOUS_TIERS = "The limit for any constant delay is that of continuous controllers."

#: What the age in a range assumes beside the ages.
IN_ORDER = "if no sample is played after a newer one (telespring plays none)"

TABLE_TITLE = "How stiff the spring may be, by what the network does"
MAYBE_TOO_SMALL = "The limit with sampled controllers may be more than 5 % too small: the search was cut off."
_WORST_OPERATOR = "Every limit holds for every hand in the range, the worst included."
_UNPROVEN_OVER_RANGE = "Not proven: a single hand has a limit there, but nothing proves one for the range."


class TierBound(NamedTuple):
    """What one tier allows, as a screen shows it: at one known constant delay sampled controllers count.

    Attributes
    ----------
    verdict
        The verdict of the tier.
    bound, attained
        The stiffness, N/m, and whether it is itself allowed.
    axis
        Name of the axis that sets it.
    is_satisfied
        Whether the stiffness in question is allowed.
    """

    verdict: Verdict
    bound: float | None
    attained: bool
    axis: str
    is_satisfied: bool

    @property
    def allowed(self) -> str:
        """The stiffnesses that the tier allows, without the unit."""
        return allowed_stiffness(self.bound, self.attained, self.verdict.unavailable)


def one_hand_lines(question: Question) -> list[Text]:
    """Say that the cases of free and of held handles leave out one hand that lets go alone, where they do."""
    if not question.leaves_out_one_hand:
        return []
    return [
        Text("Neither case covers one hand that lets go while the other holds. A range of hands from 0 does.")
    ]


def range_notes(bounds: Iterable[TierBound]) -> list[str]:
    """Say what limits over a range of operators mean."""
    is_unproven = any(each.verdict.unavailable == "not proven over the range" for each in bounds)
    return [_WORST_OPERATOR, _UNPROVEN_OVER_RANGE] if is_unproven else [_WORST_OPERATOR]


def tier_bounds(judged: Verdicts) -> list[TierBound]:
    """List the tiers that differ on this network, the one for one known constant delay first."""
    names = [axis.name for axis in judged.axes]
    rows = []
    for verdict in reversed(judged.tiers):
        if verdict.tier == "age in a range" and judged.network.is_constant:
            continue  # Only the hold of a sample varies its age: a constant delay allows more.
        axis = "–" if verdict.worst_axis is None else names[verdict.worst_axis]
        row = TierBound(verdict, verdict.stiffness_bound, verdict.attained, axis, verdict.satisfied)
        if verdict.tier == "constant delay" and judged.sampled_stable is not None:
            sampled = {each.name: each.sampled_stiffness_bound or 0.0 for each in judged.axes}
            limit = stiffness_limit(judged)
            worst = min(sampled, key=lambda name: sampled[name])
            row = row._replace(bound=limit, attained=False, axis=worst, is_satisfied=is_stable(judged))
        rows.append(row)
    return rows


def hand_rows(free: Verdicts, held: Verdicts) -> list[tuple[str, str, str, str]]:
    """List what each network allows with free and with held handles, and what a hand does.

    What is stable on any network is stable while the delay is bounded.
    """
    rows = []
    for own, other in zip(_nested(free), _nested(held), strict=True):
        rows.append((own[0], own[1].allowed, other[1].allowed, hand_effect(own[1].bound, other[1].bound)))
    return rows


def _nested(judged: Verdicts) -> list[tuple[str, TierBound]]:
    """List the tiers with the bound that holds there, which may be that for more networks.

    A constant delay has an exact limit; continuous controllers set that for any constant delay.
    """
    bounds = tier_bounds(judged)
    rows: list[tuple[str, TierBound]] = []
    for own in bounds:
        also = [each for each in bounds if each.verdict.tier in WIDER_TIERS.get(own.verdict.tier, ())]
        is_exact = own.verdict.tier == "any constant delay"
        best = max([own, *([] if is_exact else also)], key=lambda each: each.bound or 0.0)
        rows.append((own.verdict.tier, best))
    return rows


def hands_name(held: str) -> str:
    """Name the case of held handles, by what holds them."""
    return f"Handles {held}" if held.startswith("held") else f"Handles held ({held})"


def _named(name: str, answer: Text) -> Text:
    """Write the case that an answer is for before it; an empty name writes none."""
    return Text.assemble((f"{name}: ", "bold"), answer) if name else answer


def answers_by_buffer(
    name: str, buffered: Text, without: Text | None, *, is_promised: bool, buffer: str = ""
) -> list[Text]:
    """Write the answer of a case without a playout buffer, unless one is promised, and that with it.

    `without` is None if the delay does not vary: there is then one answer. `buffer` is the buffer's delay.
    """
    if without is None:
        return [_named(name, buffered)]
    clauses = [] if is_promised else [("without a playout buffer", without)]
    clauses.append((f"with a playout buffer{f' of {buffer}' if buffer else ''}", buffered))
    return [
        _named(f"{name}, {clause}" if name else f"{clause[0].upper()}{clause[1:]}", answer)
        for clause, answer in clauses
    ]


def sampling_note(judged: Verdicts) -> str:
    """Say which numbers sampled controllers put into the rules, and how they change the closed forms.

    Examples
    --------
    >>> import telespring as ts
    >>> sampling_note(ts.verdicts(ts.hman(), 20.0, 0.04, sample_period=0.001))[:40]
    'Sampling: h = 1 ms, T₁+T₂ = 82 ms. It pu'
    """
    h = judged.network.sample_period + judged.network.computing_time
    age = sum(budget.total for budget in judged.delay_budget)
    note = f"Sampling: h = {format_time(h, 6)}, T₁+T₂ = {format_time(age, 6)}."
    if judged.tier("bounded varying delay").stiffness_bound is None:
        return note
    return f"{note} It puts b − kh in place of b, and lowers the limit for any network."


def session_notes(session: Architecture, guard_stiffness: float = math.inf) -> tuple[str, ...]:
    """Say, for a study whose sides have the guard, whose answer it is; nothing for other sides.

    `guard_stiffness` is the one up to which a guard is proven, N/m.

    Examples
    --------
    >>> import telespring as ts
    >>> session_notes(ts.Architecture(strategy="guard"))[0][:46]
    'The answer is that of the bare spring. Above i'
    """
    if session.strategy != "guard":
        return ()
    proven = (
        f" (proven up to {format_stiffness(guard_stiffness)} with these controllers)"
        if math.isfinite(guard_stiffness)
        else ""
    )
    return (
        (
            "The answer is that of the bare spring. Above its limits the guard weakens the force, so that "
            f"no side gives out more energy than its account holds, whatever the network does{proven}."
        ),
    )


def given_delay(delay: tuple[float, float]) -> str:
    """Write a delay that was given, with as many digits as people write.

    Examples
    --------
    >>> given_delay((0.04, 0.04)), given_delay((0.04, 0.06))
    ('40 ms each way', '40 ms forward and 60 ms backward')
    """
    forward, backward = (format_time(value, 6) for value in delay)
    return f"{forward} each way" if delay[0] == delay[1] else f"{forward} forward and {backward} backward"


def delay_clause(delay: tuple[float, float]) -> str:
    """Write a delay within a sentence, without "each way" where both ways are equal.

    Examples
    --------
    >>> delay_clause((0.04, 0.04)), delay_clause((0.04, 0.06))
    ('40 ms', '40 ms forward and 60 ms backward')
    """
    return given_delay(delay).removesuffix(" each way")


def network_clause(network: Network) -> str:
    """Write how old a sample becomes on its way.

    Examples
    --------
    >>> network_clause(Network(0.04)), network_clause(Network(0.04, jitter=0.01))
    ('40 ms each way', '40 ms each way and up to 10 ms more (jitter)')
    """
    more = variation_clause(network)
    return f"{given_delay(network.delay)}{f' and {more}' if more else ''}"


def network_fits(verdict: Verdict, question: Question) -> Text:
    """Write whether a tier is about the network in question, for a narrow column."""
    match question.core.assumption(verdict):
        case "met":
            return Text("yes")
        case "met behind playout buffer":
            return Text("with buffer", style="yellow")
        case _:
            return Text("no", style="red")


def variation_clause(network: Network) -> str:
    """Write how much a delay varies; empty if it is constant.

    Examples
    --------
    >>> variation_clause(Network(0.04, jitter=0.01, max_gap=0.02))
    'up to 10 ms more (jitter), gaps of up to 20 ms'
    >>> variation_clause(Network(0.04, jitter=(0.01, 0.03)))
    'up to 10 ms more forward and 30 ms backward (jitter)'
    """
    parts = []
    if network.jitter > 0.0:
        forward, backward = (format_time(each, 6) for each in network.jitters)
        more = f"{forward} more" if forward == backward else f"{forward} more forward and {backward} backward"
        parts.append(f"up to {more} (jitter)")
    if network.max_gap > 0.0:
        parts.append(f"gaps of up to {format_time(network.max_gap, 6)}")
    return ", ".join(parts)


def describe_robots(
    dyad: Dyad,
    names: tuple[str | None, str | None] = (None, None),
    springs: tuple[Operator, Operator] | None = None,
) -> tuple[str, str]:
    """Write mass, damping and springs of their own of both robots, axis by axis, a line each.

    Examples
    --------
    >>> import telespring as ts
    >>> describe_robots(ts.Dyad(ts.Robot(1.2, 6.0), ts.Robot([2.0], [9.0])), ("left", None))
    ('Robot 1, left: 1.2 kg, 6 N·s/m on x', 'Robot 2: 2 kg, 9 N·s/m on x')
    """
    one, other = (
        f"Robot {number}{f', {name}' if name else ''}: {_describe_axes(robot)}{_own_spring(robot, spring)}"
        for number, (robot, name, spring) in enumerate(
            zip(dyad.robots, names, springs or (Operator(), Operator()), strict=True), start=1
        )
    )
    return one, other


def _own_spring(robot: Robot, spring: Operator) -> str:
    """Write the stiffness of a robot's own spring to the ground; empty without one."""
    values = [
        (str(name), format_number(stiffness, 3))
        for name, stiffness in zip(robot.axes, spring.stiffness, strict=False)
        if stiffness > 0.0
    ]
    if not values:
        return ""
    if len(values) == len(robot.axes) and len({text for _, text in values}) == 1:
        return f", with its own spring to the ground of {values[0][1]} N/m"
    each = " and ".join(f"{text} N/m on {name}" for name, text in values)
    return f", with its own spring to the ground of {each}"


def _describe_axes(robot: Robot) -> str:
    axes = [
        (str(name), f"{format_number(mass)} kg, {format_number(damping)} N·s/m")
        for name, mass, damping in zip(robot.axes, robot.mass, robot.damping, strict=True)
    ]
    if len({text for _, text in axes}) == 1:
        return f"{axes[0][1]} on {' and '.join(name for name, _ in axes)}"
    return "; ".join(f"{text} on {name}" for name, text in axes)


def sampling_clause(period: float) -> str:
    """Write how the controllers work.

    Examples
    --------
    >>> sampling_clause(0.001), sampling_clause(0.0)
    ('controllers sampled every 1 ms', 'continuous controllers')
    """
    if period == 0.0:
        return "continuous controllers"
    return f"controllers sampled every {format_time(period, 6)}"


def free_clause(held: str) -> str:
    """Say at the end of a question that nobody holds the handles; nothing if somebody does.

    Examples
    --------
    >>> free_clause(""), free_clause("held by 120 N/m")
    (', handles free', '')
    """
    return "" if held else ", handles free"


def allowed_stiffness(bound: float | None, attained: bool, unavailable: Unavailable | None = None) -> str:
    """Write the stiffnesses that a bound allows, without the unit.

    Examples
    --------
    >>> allowed_stiffness(35.616, True), allowed_stiffness(99.7, False), allowed_stiffness(0.0, False)
    ('up to 35.61', 'below 99.7', 'none')
    >>> allowed_stiffness(None, False, "not proven over the range")
    'not proven'
    """
    if bound is None:
        return "not proven" if unavailable == "not proven over the range" else "no rule"
    if math.isinf(bound):
        return "no limit"
    if bound == 0.0:
        return "none"
    # A bound that is rounded down is itself allowed, but then so is everything below it.
    return f"{'up to' if attained else 'below'} {format_number(bound, rounding='down')}"


def hand_effect(free: float | None, held: float | None) -> str:
    """Say whether holding the handles raises a limit or lowers it.

    Examples
    --------
    >>> hand_effect(35.6, 120.0), hand_effect(35.6, 27.2), hand_effect(35.6, 35.6)
    ('helps', 'hurts', 'no difference')
    """
    if free is None or held is None:
        return "not known"
    if math.isclose(free, held, rel_tol=1e-3) or free == held:
        return "no difference"
    return "helps" if held > free else "hurts"
