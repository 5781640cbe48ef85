"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from telespring.decision.decide import AxisDecision, Decision
from telespring.show.quantities import format_number, format_probability, format_stiffness, format_time
from telespring.show.screens.arms import (
    describe_arm_operators,
    describe_arm_pace,
    describe_arm_poses,
    describe_arm_stability,
    describe_arm_verdict,
)
from telespring.show.screens.robots import robot_notes
from telespring.show.tiers import TIERS
from telespring.theory.verdicts import DelayBudget

__all__ = ["decision_screen"]

#: Whether a tier's assumption holds on this network, for a narrow column.
_APPLIES = {
    "met": Text("yes"),
    "met behind playout buffer": Text("if buffered", style="yellow"),
    "not met": Text("no", style="red"),
}

#: So many stable intervals are listed per axis.
_INTERVALS = 6


def decision_screen(decision: Decision, title: str) -> RenderableType:
    """Lay a decision out for the terminal: headline, verdicts, margins, delay budget and what to change."""
    return Group(
        _decision_headline(decision, title),
        *_decision_warnings(decision),
        _decision_verdict_table(decision),
        *_decision_verdict_notes(decision),
        _decision_margin_table(decision),
        _describe_delay_budget(decision),
        *_describe_decay_rate(decision),
        *_describe_decision_uncertainty(decision),
        *_describe_decision_in_arms(decision),
        _suggested_change_lines(decision),
    )


def _decision_warnings(decision: Decision) -> list[RenderableType]:
    lines = [Text.assemble(("Warning: ", "bold yellow"), note) for note in robot_notes(decision)]
    return [Padding(Group(*lines), (0, 0, 1, 0))] if lines else []


def _given_delay(delay: tuple[float, float]) -> str:
    """Write a delay that was given, with as many digits as people write."""
    forward, backward = (format_time(value, 6) for value in delay)
    return f"{forward} each way" if delay[0] == delay[1] else f"{forward} forward and {backward} backward"


def _describe_constant_delay(decision: Decision) -> str:
    if not decision.buffered:
        return "at this constant delay"
    delay = _given_delay(decision.constant_delay).removesuffix(" each way")
    return f"at a constant delay of {delay} (behind a playout buffer)"


def _decision_headline(decision: Decision, title: str) -> Text:
    question = f"{title}: {format_number(decision.stiffness, 6)} N/m over {_given_delay(decision.delay)}\n"
    where = _describe_constant_delay(decision)
    if decision.stable:
        # A verdict axis by axis does not cover axes that are not independent.
        word = "STABLE AXIS BY AXIS ONLY" if decision.axes_independent is False else "STABLE"
        style = "bold green" if word == "STABLE" else "bold yellow"
        return Text.assemble((question, "bold"), (word, style), f" {where}. {_decision_margins(decision)}\n")
    names = [axis.name for axis in decision.axes if not axis.stable]
    unstable = f"{'axis' if len(names) == 1 else 'axes'} {', '.join(names)}"
    return Text.assemble(
        (question, "bold"), ("UNSTABLE", "bold red"), f" on {unstable} {where}{_decision_growth(decision)}.\n"
    )


def _decision_growth(decision: Decision) -> str:
    """Describe how an unstable dyad leaves its rest, where the growth of the worst operators is known."""
    worst = decision.worst_axis
    if decision.continuous_stable:
        why = " with sampled controllers"
        growth = worst.sampled_abscissa or 0.0
    elif decision.over_operator_ranges:
        return " for some operators in their ranges"
    else:
        why = ""
        growth = worst.spectral_abscissa if worst.sampled_abscissa is None else worst.sampled_abscissa
    if growth > 0.0:
        return f"{why}: the motion grows by a factor of e every {format_time(1 / growth)} (axis {worst.name})"
    return f"{why}: the motion oscillates without decay (axis {worst.name})"


def _decision_margins(decision: Decision) -> str:
    """Describe how far delay and stiffness may go from a stable point."""
    sentences = [_describe_delay_margin(decision)]
    if decision.sampled_stable is not None:
        sentences = [
            f"With continuous controllers: {_lower_first(sentence)}" for sentence in sentences if sentence
        ]
    more = decision.stiffness_limit / decision.stiffness - 1.0
    if 0.0 < more < math.inf:
        # The stiffness margin accounts for sampling; where the delay margin does not, it comes after.
        place = 0 if decision.sampled_stable is not None else 1
        sentences.insert(
            place, f"The stiffness may grow by {format_number(more, rounding='down', shift=2)} %."
        )
    return " ".join(sentence for sentence in sentences if sentence)


def _lower_first(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:]


def _describe_delay_margin(decision: Decision) -> str:
    delay = decision.mean_delay
    end, end_axis = min((axis.maximum_delay, axis.name) for axis in decision.axes)
    if math.isinf(end):
        return "No constant delay, however long, destabilises it."
    start, start_axis = 0.0, ""
    middle = ""
    cut_off = math.inf
    if delay >= end:
        # Some axis is in a later interval, and these are known for one operator only.
        around = [(axis.stable_around, axis.name) for axis in decision.axes]
        known = [(interval, name) for interval, name in around if interval is not None]
        if len(known) < len(around):
            return ""
        start, start_axis = max((interval[0], name) for interval, name in known)
        end, end_axis = min((interval[1], name) for interval, name in known)
        if decision.over_operator_ranges:
            middle = "For operators in the middle of their ranges, "
        cut_off = max(decision.horizon, 2.0 * delay)
    limit = format_time(end, rounding="down")
    if end >= cut_off:
        sentence = f"The delay may grow to {limit} at least"
    else:
        growth = format_time(end - delay, rounding="down")
        sentence = f"The delay may grow by {growth}, to {limit} (axis {end_axis})"
    if start > 0.0:
        fall, low = format_time(delay - start, rounding="down"), format_time(start, rounding="up")
        sentence += f", and shrink by {fall}, to {low} (axis {start_axis})"
    return (middle + _lower_first(sentence) if middle else sentence) + "."


def _empty_decision_table(title: str = "") -> Table:
    # One space between columns, so that 80 of them hold the rules.
    return Table(
        title=title or None,
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )


def _decision_verdict_table(decision: Decision) -> Table:
    table = _empty_decision_table("How stiff can the spring be?")
    table.add_column("network", no_wrap=True)
    table.add_column("rule", ratio=1, overflow="fold")
    table.add_column("k, N/m", justify="right", no_wrap=True)
    table.add_column("axis", no_wrap=True)
    table.add_column("holds", no_wrap=True)
    table.add_column("applies", no_wrap=True)
    names = [axis.name for axis in decision.axes]
    verdicts = decision.verdicts
    for verdict in reversed(verdicts.tiers):
        formula = TIERS[verdict.tier].formula
        if verdict.stiffness_bound is None:
            table.add_row(verdict.tier, formula, "no rule", "–", "–", "–")
            continue
        table.add_row(
            verdict.tier,
            formula,
            _allowed_stiffness(verdict.stiffness_bound, verdict.attained),
            "–" if verdict.worst_axis is None else names[verdict.worst_axis],
            _yes_or_no(verdict.satisfied),
            _APPLIES[verdict.assumption],
        )
    paper = verdicts.paper
    table.add_row(
        "paper",
        TIERS["paper"].formula,
        _allowed_stiffness(paper.critical_stiffness, attained=True),
        names[paper.critical_axis],
        _yes_or_no(paper.stable),
        _APPLIES[verdicts.tier("constant delay").assumption],
    )
    return table


def _allowed_stiffness(bound: float, attained: bool) -> str:
    """Write the stiffnesses that a bound allows."""
    if math.isinf(bound):
        return "no limit"
    if bound == 0.0:
        return "none"
    # A bound that is rounded down is itself allowed, but then so is everything below it.
    return f"{'up to' if attained else 'below'} {format_number(bound, rounding='down')}"


def _yes_or_no(is_so: bool) -> Text:
    return Text("yes", style="green") if is_so else Text("no", style="red")


def _decision_verdict_notes(decision: Decision) -> list[Text]:
    notes = []
    allowed = decision.verdicts.stiffness_allowed
    if allowed is not None:
        stiffness = _allowed_stiffness(allowed.stiffness, allowed.attained)
        allowed_text = {"no limit": "any stiffness", "none": "no stiffness"}.get(
            stiffness, f"a stiffness {stiffness} N/m"
        )
        unbuffered = " without a playout buffer" if decision.buffered else ""
        notes.append(Text(f"This network allows {allowed_text}{unbuffered} ({allowed.tier})."))
    if not decision.verdicts.paper.agrees:
        notes.append(Text("The paper's formulas are wrong here.", style="yellow"))
    if decision.sampled_stable is not None:
        state = "stable" if decision.sampled_stable else "UNSTABLE"
        notes.append(Text(f"With sampled controllers, {_describe_constant_delay(decision)}: {state}."))
    if decision.over_operator_ranges:
        notes.append(
            Text(
                "The stiffnesses above, kₘ exact and δₘ exact are the worst over the ranges of operators; "
                "the other margins are for operators in the middle of their ranges."
            )
        )
    return notes


def _decision_margin_table(decision: Decision) -> Padding:
    table = _empty_decision_table("Margins by axis: critical stiffness kₘ, maximum delay δₘ")
    table.add_column("\naxis")
    for name in ("kₘ exact\nN/m", "kₘ paper\nN/m", "δₘ exact\n", "δₘ paper\n", "slowest root\n1/s"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column(f"stable delays\nup to {format_time(decision.horizon, 6)}")
    for axis in decision.axes:
        printed = axis.maximum_delay_paper
        table.add_row(
            Text(axis.name, style="green" if axis.stable else "red"),
            format_stiffness(axis.critical_stiffness).removesuffix(" N/m"),
            format_stiffness(axis.critical_stiffness_paper).removesuffix(" N/m"),
            format_time(axis.maximum_delay, rounding="down"),
            "–" if math.isnan(printed) else format_time(printed, rounding="down"),
            format_number(axis.spectral_abscissa),
            _format_stable_delays(axis),
        )
    return Padding(table, (1, 0, 0, 0))


def _format_stable_delays(axis: AxisDecision) -> str:
    intervals = [
        f"{format_time(start, rounding='up')} to {format_time(end, rounding='down')}"
        for start, end in axis.stable_delays[:_INTERVALS]
    ]
    omitted = len(axis.stable_delays) - len(intervals)
    return "\n".join(intervals + ([f"… {omitted} more"] if omitted else [])) or "none"


def _describe_delay_budget(decision: Decision) -> Padding:
    forward, backward = decision.verdicts.delay_budget
    if forward == backward:
        lines = [_delay_budget_line("each way", forward)]
    else:
        lines = [_delay_budget_line("forward", forward), _delay_budget_line("backward", backward)]
    return Padding(
        Text.assemble(("Age of the oldest sample in use, ", "bold"), "; ".join(lines)), (1, 0, 0, 0)
    )


def _delay_budget_line(direction: str, budget: DelayBudget) -> str:
    names = ("network", "jitter", "gap", "sampling", "computing")
    parts = [(name, getattr(budget, name)) for name in names]
    terms = " + ".join(f"{format_time(seconds, 6)} {name}" for name, seconds in parts if seconds > 0.0)
    return f"{direction}: {f'{terms} = ' if terms else ''}{format_time(budget.total, 6)}"


def _describe_margin_limits(decision: Decision) -> list[str]:
    """Name what the margins on the screen that follow leave out."""
    limits = ["continuous controllers"] if decision.sampled_stable is not None else []
    return limits + (["operators in the middle of their ranges"] if decision.over_operator_ranges else [])


def _describe_decay_rate(decision: Decision) -> list[Padding]:
    if decision.decay_rate is None:
        return []
    ranges = []
    for low, high in decision.decay_stiffness:
        start = f"{format_number(low, rounding='up')}"
        ranges.append(f"above {start} N/m" if math.isinf(high) else f"{start} to {format_stiffness(high)}")
    stiffness = " or ".join(ranges) or "none"
    if limits := _describe_margin_limits(decision):
        stiffness += f" ({', '.join(limits)})"
    rate = format_number(decision.decay_rate)
    title = f"Stiffness at which every motion decays at a rate of at least {rate} 1/s: "
    return [Padding(Text.assemble((title, "bold"), stiffness), (1, 0, 0, 0))]


def _describe_decision_uncertainty(decision: Decision) -> list[RenderableType]:
    """Show how well the margins are known where the robots have errors."""
    known = decision.uncertainty
    if known is None:
        return []
    stable = known.stable
    probability = format_probability(stable.value, stable.standard_error, stable.draws)
    limits = "".join(f", {limit}" for limit in _describe_margin_limits(decision))
    sentence = Text.assemble(
        ("Given the uncertainty of the robots' parameters, ", "bold"),
        f"the dyad is stable at this constant delay with probability {probability}{limits}.",
    )
    table = _empty_decision_table()
    for name in ("axis", "kₘ, 95 %", "δₘ, 95 %"):
        table.add_column(name, justify="left" if name == "axis" else "right", no_wrap=True)
    for axis in known.axes:
        low, high = axis.critical_stiffness
        first, last = axis.maximum_delay
        delays = f"{format_time(first, rounding='down')} to {format_time(last, rounding='up')}"
        table.add_row(
            axis.axis,
            f"{format_number(low, rounding='down')} to {format_number(high, rounding='up')} N/m",
            "no limit" if math.isinf(first) else delays,
        )
    return [Padding(sentence, (1, 0, 0, 0)), table]


def _describe_decision_in_arms(decision: Decision) -> list[Padding]:
    """Show how the arms and agents that the study file names change the answer."""
    arms = decision.arms
    if arms is None:
        return []
    held = "In the rehearsal, arms and agents hold the handles"
    if arms.operators is None:
        return [Padding(Text(f"{held}. Stability with them is {describe_arm_stability(arms)}"), (1, 0, 0, 0))]
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


def _suggested_change_lines(decision: Decision) -> Padding:
    if decision.stable:
        title = "To guarantee stability beyond this constant delay: "
        lines = _suggest_stronger_guarantees(decision)
    else:
        title, lines = "To be stable at a constant delay, one of: ", _suggest_stabilising_changes(decision)
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))


def _suggest_stabilising_changes(decision: Decision) -> list[str]:
    softer = (
        f"stiffness below {format_stiffness(decision.stiffness_limit)}"
        if decision.stiffness_limit > 0.0
        else "no stiffness is low enough"
    )
    if decision.continuous_stable:
        return [softer, "a shorter sample period: continuous controllers are stable"]
    way = "each way" if decision.delay[0] == decision.delay[1] else "on average of both ways"
    counted = ", jitter and gaps included" if decision.buffered else ""
    nearer = (
        f"delay below {format_time(decision.delay_limit, rounding='down')} {way}{counted}"
        if decision.delay_limit > 0.0
        else "no delay is short enough"
    )
    if math.isinf(decision.added_damping):
        damped = "no damping is enough"
    else:
        added = format_number(decision.added_damping, rounding="up")
        damped = f"more than {added} N·s/m of damping added to each robot"
    if decision.sampled_stable is not None:
        nearer, damped = (f"{line} (continuous controllers)" for line in (nearer, damped))
    return [softer, nearer, damped]


def _suggest_stronger_guarantees(decision: Decision) -> list[str]:
    strongest = decision.verdicts.tier("any network")
    if strongest.stiffness_bound is not None and strongest.satisfied:
        return ["nothing to change"]
    lines = []
    promises = {
        "any constant delay": "under any constant delay",
        "bounded varying delay": "while the delay varies within its budget",
        "any network": "on any network",
    }
    for verdict in reversed(decision.verdicts.tiers):
        promise, bound = promises.get(verdict.tier), verdict.stiffness_bound
        if promise is None or bound is None or (verdict.satisfied and verdict.assumption_met):
            continue
        buffer = "" if verdict.assumption_met else " behind a playout buffer"
        if verdict.satisfied:
            lines.append(f"a playout buffer, to be stable {promise}")
        elif bound > 0.0:
            lines.append(f"stiffness {_allowed_stiffness(bound, verdict.attained)} N/m {promise}{buffer}")
        else:
            lines.append(f"no stiffness is low enough {promise}{buffer}")
    return lines or ["nothing to change"]
