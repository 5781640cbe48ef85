"""The details below a decision: margins by axis, the age of samples, decay, uncertainty, arms."""

from __future__ import annotations

import math

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring.decision.decide import AxisDecision, Decision
from telespring.model import JudgedNetwork
from telespring.show.quantities import format_number, format_probability, format_stiffness, format_time
from telespring.show.screens.arms import (
    describe_arm_operators,
    describe_arm_pace,
    describe_arm_poses,
    describe_arm_stability,
    describe_arm_verdict,
)
from telespring.show.screens.layout import fitting_table
from telespring.show.screens.robots import outside_probability
from telespring.theory.verdicts import DelayBudget, OperatorPoint

__all__ = ["arms_note", "decision_details"]

#: So many stable intervals are listed per axis.
_INTERVALS = 6


def decision_details(decision: Decision) -> list[RenderableType]:
    """Lay out what stands behind a decision."""
    is_varying = decision.varying is not None and not decision.has_playout_buffer
    return [
        # They are those of one constant delay.
        *([] if is_varying else _margins(decision)),
        *([] if is_varying else [_describe_delay_budget(decision)]),
        *_describe_attack(decision),
        *_describe_decay_rate(decision),
        *([] if is_varying else _describe_uncertainty(decision)),
        *_describe_in_arms(decision),
    ]


def _margins(decision: Decision) -> list[RenderableType]:
    if decision.over_operator_ranges:
        return [Padding(_margins_over_ranges(decision), (1, 0, 0, 0))]
    headings = [
        "axis",
        "kₘ exact\nN/m",
        "kₘ paper\nN/m",
        "δₘ exact",
        "δₘ paper",
        "slowest root\n1/s",
        f"stable delays\nup to {format_time(decision.horizon, 6)}",
    ]
    rows: list[list[str | Text]] = []
    for axis in decision.axes:
        own = axis.worst_case
        printed = own.maximum_delay_paper
        rows.append(
            [
                Text(axis.name, style="green" if axis.stable else "red"),
                format_stiffness(axis.critical_stiffness).removesuffix(" N/m"),
                format_stiffness(own.critical_stiffness_paper).removesuffix(" N/m"),
                format_time(axis.maximum_delay, rounding="down"),
                "–" if math.isnan(printed) else format_time(printed, rounding="down"),
                format_number(own.spectral_abscissa),
                _format_stable_delays(axis),
            ]
        )
    title = f"Margins by axis{_if_continuous(decision)}: critical stiffness kₘ, maximum delay δₘ"
    table = fitting_table(title, headings, rows, right=(1, 2, 3, 4, 5))
    return [Padding(Group(table, *_sampled_margin(decision)), (1, 0, 0, 0))]


def _if_continuous(decision: Decision) -> str:
    """Say that margins are not those that the answer is judged by, where its controllers sample."""
    return "" if decision.sampled_stable is None else " if the controllers were continuous"


def _sampled_margin(decision: Decision) -> list[Text]:
    """Give the limit of the delay that the answer is judged by, where the answer does not tell it."""
    if decision.sampled_stable is None or decision.stable:
        return []
    end, period = decision.delay_limit, format_time(decision.verdicts.network.sample_period, 6)
    judged = f"With these controllers, sampled every {period}, "
    if math.isinf(end):
        return [Text(f"{judged}no constant delay destabilises it.")]
    if end == 0.0:
        only = "only a coupling without delay" if decision.delay_limit_attained else "no delay"
        return [Text(f"{judged}{only} is stable.")]
    within = "up to" if decision.delay_limit_attained else "below"
    which = "a delay" if decision.delay[0] == decision.delay[1] else "a delay, the mean of both ways,"
    return [Text(f"{judged}{which} {within} {format_time(end, rounding='down')} is stable.")]


def _margins_over_ranges(decision: Decision) -> Group:
    """Keep what holds over the ranges apart from what belongs to the worst operators."""
    rows: list[list[str | Text]] = [
        [
            Text(axis.name, style="green" if axis.stable else "red"),
            format_stiffness(axis.critical_stiffness).removesuffix(" N/m"),
            format_time(axis.maximum_delay, rounding="down"),
        ]
        for axis in decision.axes
    ]
    where = f"over the ranges of operators{_if_continuous(decision)}"
    title = f"Margins by axis {where}: critical stiffness kₘ, maximum delay δₘ"
    lines = _sampled_margin(decision)
    for axis in decision.axes:
        if not axis.verdict.maximum_delay_proven:
            found = axis.verdict.least_maximum_delay
            lines.append(
                Text(
                    f"Axis {axis.name}: δₘ holds for every operator but may be too small, since the search "
                    "over the ranges was cut off; the operators found allow "
                    f"{format_time(found, rounding='down')}."
                )
            )
        own = axis.worst_case
        one, other = (_describe_operator(each) for each in own.operators)
        intervals = _format_stable_delays(axis).replace("\n", ", ")
        lines.append(
            Text(
                f"Axis {axis.name}, worst case at this delay: robot 1 {one}, robot 2 {other}. Slowest root "
                f"{format_number(own.spectral_abscissa)} 1/s; stable delays up to "
                f"{format_time(decision.horizon, 6)}: {intervals}."
            )
        )
    return Group(fitting_table(title, ("axis", "kₘ, N/m", "δₘ"), rows, right=(1, 2)), *lines)


def _describe_operator(operator: OperatorPoint) -> str:
    parts = [
        f"{format_number(value)} {unit}"
        for value, unit in ((operator.stiffness, "N/m"), (operator.damping, "N·s/m"), (operator.mass, "kg"))
        if value > 0.0
    ]
    return f"held by {', '.join(parts)}" if parts else "free"


def _format_stable_delays(axis: AxisDecision) -> str:
    intervals = [
        f"{format_time(start, rounding='up')} to {format_time(end, rounding='down')}"
        for start, end in axis.worst_case.stable_delays[:_INTERVALS]
    ]
    omitted = len(axis.worst_case.stable_delays) - len(intervals)
    return "\n".join(intervals + ([f"… {omitted} more"] if omitted else [])) or "none"


def _describe_delay_budget(decision: Decision) -> Padding:
    forward, backward = decision.verdicts.delay_budget
    judged = None if decision.is_as_stated else decision.question.ages
    if forward == backward:
        lines = [_delay_budget_line("each way", forward, judged)]
    else:
        lines = [
            _delay_budget_line("forward", forward, judged),
            _delay_budget_line("backward", backward, judged),
        ]
    return Padding(Text.assemble(("Age of the oldest sample, ", "bold"), "; ".join(lines)), (1, 0, 0, 0))


def _delay_budget_line(direction: str, budget: DelayBudget, judged: JudgedNetwork | None) -> str:
    """Write the sum for one way; ages that were judged in place of the stated ones are its first part."""
    names = ("network", "jitter", "gap", "sampling", "computing")
    parts = [(name, getattr(budget, name)) for name in names]
    if judged is not None and judged.ages is not None:
        parts = [("in use", budget.network + budget.jitter + budget.gap), *parts[3:]]
    terms = " + ".join(f"{format_time(seconds, 6)} {name}" for name, seconds in parts if seconds > 0.0)
    return f"{direction}: {f'{terms} = ' if terms else ''}{format_time(budget.total, 6)}"


def _describe_attack(decision: Decision) -> list[Text]:
    """Say between which stiffnesses nothing is known while the delay varies, where an attack was searched."""
    cases = [("", decision)] if decision.free is None else [("free: ", decision.free), ("held: ", decision)]
    parts = []
    for name, case in cases:
        varying = case.varying
        if varying is None or varying.attack is None:
            continue
        safe = format_stiffness(varying.stiffness_limit)
        parts.append(
            f"{name}safe up to {safe}, no attack was found"
            if math.isinf(varying.attack)
            else f"{name}safe up to {safe}, an attack is known at "
            f"{format_stiffness(varying.attack, rounding='up')}"
        )
    if not parts:
        return []
    return [Text.assemble(("While the delay varies, ", "bold"), f"{'; '.join(parts)}.")]


def _describe_decay_rate(decision: Decision) -> list[Padding]:
    if decision.decay_rate is None:
        return []
    ranges = []
    for low, high in decision.decay_stiffness:
        start = f"{format_number(low, rounding='up')}"
        ranges.append(f"above {start} N/m" if math.isinf(high) else f"{start} to {format_stiffness(high)}")
    stiffness = " or ".join(ranges) or "none"
    if limits := _limits_of(decision):
        stiffness += f" ({', '.join(limits)})"
    rate = format_number(decision.decay_rate)
    title = f"Stiffness at which every motion decays at a rate of at least {rate} 1/s: "
    return [Padding(Text.assemble((title, "bold"), stiffness), (1, 0, 0, 0))]


def _describe_uncertainty(decision: Decision) -> list[RenderableType]:
    """Show how well the margins are known where the robots have errors."""
    known = decision.uncertainty
    if known is None:
        return []
    stable = known.stable
    probability = format_probability(stable.value, stable.standard_error, stable.draws)
    worst = ", for the worst case of each axis" if decision.over_operator_ranges else ""
    sentence = Text.assemble(
        ("Given the uncertainty of the robots' parameters, ", "bold"),
        f"the dyad is stable at this constant delay with probability {probability}{worst}. "
        f"{outside_probability(decision)}",
    )
    continuous = ", continuous controllers" if decision.sampled_stable is not None else ""
    rows = []
    for axis in known.axes:
        low, high = axis.critical_stiffness
        first, last = axis.maximum_delay
        delays = f"{format_time(first, rounding='down')} to {format_time(last, rounding='up')}"
        rows.append(
            (
                str(axis.axis),
                f"{format_number(low, rounding='down')} to {format_number(high, rounding='up')} N/m",
                "no limit" if math.isinf(first) else delays,
            )
        )
    table = fitting_table(f"95 % intervals{continuous}", ("axis", "kₘ", "δₘ"), rows, right=(1, 2))
    return [Padding(sentence, (1, 0, 0, 0)), table]


def arms_note(decision: Decision) -> str:
    """Say that the arms and agents of the rehearsal are not in the answer, where they may change it."""
    arms = decision.arms
    if arms is None:
        return ""
    held = "In the rehearsal the study's arms and agents hold the handles"
    if arms.operators is None:
        return f"{held}. The answer leaves them out; stability with them is {describe_arm_stability(arms)}"
    if all(condition.stable for condition in arms.conditions):
        return ""
    return f"{held}. The answer leaves them out; with them the dyad is UNSTABLE, as the last lines show."


def _describe_in_arms(decision: Decision) -> list[Padding]:
    """Show how the arms and agents that the study file names change the answer."""
    arms = decision.arms
    if arms is None:
        return []
    held = "In the rehearsal, arms and agents hold the handles"
    if arms.operators is None:
        return []  # said before the answer
    (condition,) = arms.conditions
    verdict = ("stable", "bold green") if condition.stable else ("unstable", "bold red")
    places, pace = "", describe_arm_pace(condition)
    if condition.worst_position is not None:
        pace = f"{describe_arm_verdict(condition).partition(', ')[2]}, {pace}"
    if condition.unstable_poses and arms.poses is not None:
        places = f" in {condition.unstable_poses} of {len(arms.poses.positions)} poses"
    elif condition.unstable_axes:
        places = f" on {' and '.join(condition.unstable_axes)}"
    controllers = "" if decision.sampled_stable is None else " with continuous controllers"
    held_by = f"{held} ({describe_arm_operators(arms.operators)}). With them the dyad is "
    lines = [Text.assemble(held_by, verdict, f"{places}{controllers} ({pace}).")]
    if arms.poses is not None:
        lines.append(Text(f"{describe_arm_poses(arms.poses)}."))
    return [Padding(Group(*lines), (1, 0, 0, 0))]


def _limits_of(decision: Decision) -> list[str]:
    """Name what the margins on the screen that follow leave out."""
    limits = ["continuous controllers"] if decision.sampled_stable is not None else []
    return limits + (["the worst case of each axis"] if decision.over_operator_ranges else [])
