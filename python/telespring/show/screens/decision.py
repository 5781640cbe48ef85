"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from telespring.decision.decide import Decision

__all__ = ["decision_screen", "digits_down"]


def decision_screen(decision: Decision, title: str) -> RenderableType:
    """Lay a decision out for the terminal.

    Parameters
    ----------
    decision
        The answer.
    title
        What was judged, such as the study's name.

    Returns
    -------
    rich.console.RenderableType
        Headline, verdicts, margins, delay budget and what to change.
    """
    return Group(
        _headline(decision, title),
        *_beware(decision.warnings),
        _verdict_table(decision),
        *_notes(decision),
        _axis_table(decision),
        _budget(decision),
        *_decay(decision),
        *_uncertainty(decision),
        *_in_arms(decision),
        _changes(decision),
    )


def _beware(warnings: tuple[str, ...]) -> list[RenderableType]:
    """Tell what to know about the robots, right below the answer."""
    lines = [Text.assemble(("Beware: ", "bold yellow"), warning) for warning in warnings]
    return [Padding(Group(*lines), (0, 0, 1, 0))] if lines else []


#: Whether the network is of the kind that a verdict assumes, for a narrow column.
_FITS = {
    "met": Text("fits"),
    "met behind playout buffer": Text("if buffered", style="yellow"),
    "not met": Text("does not fit", style="red"),
}


#: So many intervals are told on one screen.
_INTERVALS = 6


def digits_down(value: float, shift: int = 0) -> str:
    """Write a limit that must stay above what is safe to use: four digits, never more than the value.

    Parameters
    ----------
    value
        The limit, 0 or more.
    shift
        Show it times ten to this power: 3 for a length or a time in thousandths.

    Returns
    -------
    str
        The digits.

    Examples
    --------
    >>> digits_down(0.16719, 3), digits_down(0.3, 3)
    ('167.1', '300')
    """
    return _digits(value, shift, ROUND_FLOOR)


def _digits(value: float, shift: int, rounding: str) -> str:
    # The shortest decimal that reads back to the same number: 0.3 is then no less than 0.3.
    shown = Context(prec=4, rounding=rounding).plus(Decimal(repr(float(value))).scaleb(shift))
    return f"{float(shown):.4g}"


def _stiffness(value: float) -> str:
    """Write a stiffness that must not be exceeded."""
    return "no limit" if math.isinf(value) else f"{digits_down(value)} N/m"


def _delay(value: float, rounding: str = ROUND_FLOOR) -> str:
    """Write a delay that must not be exceeded, or, rounded up, one that must."""
    if math.isinf(value):
        return "no limit"
    return f"{_digits(value, 3, rounding)} ms" if value < 1 else f"{_digits(value, 0, rounding)} s"


def _asked_delay(value: float) -> str:
    """Write a delay that was asked about, with as many digits as one gives."""
    return f"{value * 1e3:.6g} ms" if value < 1 else f"{value:.6g} s"


def _each_way(delay: tuple[float, float]) -> str:
    forward, backward = delay
    if forward == backward:
        return f"{_asked_delay(forward)} each way"
    return f"{_asked_delay(forward)} there and {_asked_delay(backward)} back"


def _constant_delay(decision: Decision) -> str:
    if not decision.buffered:
        return "at this constant delay"
    forward, backward = decision.constant_delay
    delay = _asked_delay(forward) if forward == backward else _each_way(decision.constant_delay)
    return f"at a constant delay of {delay} (behind a playout buffer)"


def _headline(decision: Decision, title: str) -> Text:
    asked = f"{title}: {decision.stiffness:.6g} N/m over {_each_way(decision.delay)}\n"
    where = _constant_delay(decision)
    if decision.stable:
        # What holds axis by axis is no answer for axes that are not independent.
        word = "STABLE AXIS BY AXIS ONLY" if decision.axes_independent is False else "STABLE"
        style = "bold green" if word == "STABLE" else "bold yellow"
        return Text.assemble((asked, "bold"), (word, style), f" {where}. {_margin(decision)}\n")
    names = [axis.axis for axis in decision.axes if not axis.stable]
    unstable = f"{'axis' if len(names) == 1 else 'axes'} {', '.join(names)}"
    return Text.assemble(
        (asked, "bold"), ("UNSTABLE", "bold red"), f" on {unstable} {where}{_pace(decision)}.\n"
    )


def _pace(decision: Decision) -> str:
    """Tell how an unstable dyad leaves its rest, where the growth of the worst operators is known."""
    worst = decision.worst_axis
    if decision.continuous_stable:
        why = " with controllers that sample"
        growth = worst.sampled_abscissa or 0.0
    elif decision.over_operator_ranges:
        return " for some operators in their ranges"
    else:
        why = ""
        growth = worst.spectral_abscissa if worst.sampled_abscissa is None else worst.sampled_abscissa
    if growth > 0.0:
        return f"{why}: it grows by the factor e every {_time(1 / growth)} (axis {worst.axis})"
    return f"{why}: it swings on without end (axis {worst.axis})"


def _time(value: float) -> str:
    return f"{value * 1e3:.4g} ms" if value < 1 else f"{value:.4g} s"


def _margin(decision: Decision) -> str:
    """Tell how far delay and stiffness may go from a stable point."""
    sentences = [_delay_margin(decision)]
    if decision.sampled_stable is not None:
        sentences = [
            f"With continuous controllers: {_within(sentence)}" for sentence in sentences if sentence
        ]
    more = decision.remedies.stiffness / decision.stiffness - 1.0
    if 0.0 < more < math.inf:
        # In front, where it counts sampling and what follows does not.
        place = 0 if decision.sampled_stable is not None else 1
        sentences.insert(place, f"The stiffness may grow by {digits_down(more, 2)} %.")
    return " ".join(sentence for sentence in sentences if sentence)


def _within(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:]


def _delay_margin(decision: Decision) -> str:
    delay = decision.mean_delay
    first = min((axis.maximum_delay, axis.axis) for axis in decision.axes)
    if math.isinf(first[0]):
        return "No constant delay of any length can change that."
    end, ending = first
    start, starting = 0.0, ""
    middle = ""
    cut_off = math.inf
    if delay >= first[0]:
        # Some axis is in a later interval, and these are known for one operator only.
        around = [(axis.stable_around, axis.axis) for axis in decision.axes]
        known = [(interval, name) for interval, name in around if interval is not None]
        if len(known) < len(around):
            return ""
        start, starting = max((interval[0], name) for interval, name in known)
        end, ending = min((interval[1], name) for interval, name in known)
        if decision.over_operator_ranges:
            middle = "For the operators in the middle of their ranges, "
        cut_off = max(decision.horizon, 2.0 * delay)
    if end >= cut_off:
        sentence = f"The delay may grow to {_delay(end)} at least"
    else:
        sentence = f"The delay may grow by {_delay(end - delay)}, to {_delay(end)} (axis {ending})"
    if start > 0.0:
        sentence += (
            f", and shrink by {_delay(delay - start)}, to {_delay(start, ROUND_CEILING)} (axis {starting})"
        )
    return (middle + _within(sentence) if middle else sentence) + "."


def _verdict_table(decision: Decision) -> Table:
    table = Table(
        title="What the network may do", title_justify="left", title_style="bold", box=None, pad_edge=False
    )
    table.add_column("verdict", no_wrap=True)
    table.add_column("rule", ratio=1)
    table.add_column("allows stiffness", justify="right", no_wrap=True)
    table.add_column("axis", no_wrap=True)
    table.add_column("holds", no_wrap=True)
    table.add_column("network", no_wrap=True)
    for verdict in decision.verdicts:
        rule = verdict.description.formula
        if not verdict.available:
            table.add_row(verdict.name, rule, "not available", "–", "–", "–")
            continue
        table.add_row(
            verdict.name,
            rule,
            _allowed(verdict.stiffness_allowed, verdict.attained),
            verdict.axis or "–",
            _yes_or_no(verdict.satisfied),
            _FITS[verdict.assumption],
        )
    return table


def _allowed(bound: float, attained: bool = False) -> str:
    """Write the stiffnesses that a bound allows."""
    if math.isinf(bound):
        return "no limit"
    if bound == 0.0:
        return "none"
    # A bound that is rounded down is itself allowed, but then so is everything below it.
    return f"{'up to' if attained else 'below'} {_stiffness(bound)}"


def _notes(decision: Decision) -> list[Text]:
    notes = []
    if decision.stiffness_allowed is not None:
        allowed = _allowed(decision.stiffness_allowed, decision.stiffness_allowed_attained)
        words = {"no limit": "any stiffness", "none": "no stiffness"}.get(allowed, f"a stiffness {allowed}")
        notes.append(Text(f"This network as it is allows {words} ({decision.allowing_verdict})."))
    if not decision.paper_agrees:
        notes.append(Text("The paper's formulas are wrong here.", style="yellow"))
    if decision.sampled_stable is not None:
        state = "stable" if decision.sampled_stable else "UNSTABLE"
        notes.append(Text(f"With controllers that sample, {_constant_delay(decision)}: {state}."))
    if decision.over_operator_ranges:
        notes.append(
            Text(
                "Verdicts, kₘ exact and δₘ exact: the worst over the ranges of operators. The other margins: "
                "for the operators in the middle of their ranges."
            )
        )
    return notes


def _yes_or_no(is_so: bool) -> Text:
    return Text("yes", style="green") if is_so else Text("no", style="red")


def _axis_table(decision: Decision) -> Padding:
    table = Table(title="Margins by axis", title_justify="left", title_style="bold", box=None, pad_edge=False)
    table.add_column("axis")
    for name in ("kₘ exact", "kₘ paper", "δₘ exact", "δₘ paper", "slowest root"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column(f"stable delays up to {_asked_delay(decision.horizon)}")
    for axis in decision.axes:
        intervals = [
            f"{_delay(start, ROUND_CEILING)} to {_delay(end)}"
            for start, end in axis.stable_delays[:_INTERVALS]
        ]
        left = len(axis.stable_delays) - len(intervals)
        stable = ", ".join(intervals) + (f", … {left} more" if left else "")
        printed = "–" if math.isnan(axis.maximum_delay_paper) else _delay(axis.maximum_delay_paper)
        table.add_row(
            Text(axis.axis, style="green" if axis.stable else "red"),
            _stiffness(axis.critical_stiffness),
            _stiffness(axis.critical_stiffness_paper),
            _delay(axis.maximum_delay),
            printed,
            f"{axis.spectral_abscissa:.4g} 1/s",
            stable or "none",
        )
    return Padding(table, (1, 0, 0, 0))


def _budget(decision: Decision) -> Padding:
    there, back = decision.delay_budget
    lines = [_budget_line("each way", there)] if there == back else []
    if not lines:
        lines = [_budget_line("there", there), _budget_line("back", back)]
    return Padding(Text.assemble(("Oldest sample in use, ", "bold"), "; ".join(lines)), (1, 0, 0, 0))


def _budget_line(direction: str, parts: dict[str, float]) -> str:
    used = " + ".join(f"{_asked_delay(seconds)} {part}" for part, seconds in parts.items() if seconds > 0.0)
    return f"{direction}: {used or 'nothing'} = {_asked_delay(sum(parts.values()))}"


def _decay(decision: Decision) -> list[Padding]:
    decay = decision.decay
    if decay is None:
        return []
    ranges = [
        f"above {_digits(low, 0, ROUND_CEILING)} N/m"
        if math.isinf(high)
        else f"{_digits(low, 0, ROUND_CEILING)} to {_stiffness(high)}"
        for low, high in decay.stiffness
    ]
    stiffness = " or ".join(ranges) or "none"
    limits = []
    if decision.sampled_stable is not None:
        limits.append("continuous controllers")
    if decision.over_operator_ranges:
        limits.append("operators in the middle of their ranges")
    if limits:
        stiffness += f" ({', '.join(limits)})"
    title = f"Stiffness at which every motion decays at {decay.rate:.4g} 1/s or faster: "
    return [Padding(Text.assemble((title, "bold"), stiffness), (1, 0, 0, 0))]


def _uncertainty(decision: Decision) -> list[RenderableType]:
    """Tell how well the margins are known where the robots are known within their errors only."""
    known = decision.uncertainty
    if known is None:
        return []
    share, error = 100.0 * known.stable.value, 100.0 * known.stable.standard_error
    limits = ["continuous controllers"] if decision.sampled_stable is not None else []
    limits += ["operators in the middle of their ranges"] if decision.over_operator_ranges else []
    draws = known.stable.draws
    if known.stable.value in (0.0, 1.0):
        # What no draw (or every one) shows is known to one draw in so many at best.
        side, bound = ("below", 1.0 / draws) if known.stable.value == 0.0 else ("above", 1.0 - 1.0 / draws)
        digits = math.ceil(math.log10(draws)) - 2
        told = f"{side} {100.0 * bound:.{digits}f} % ({draws} draws)"
    else:
        digits = max(0, 1 - math.floor(math.log10(error)))
        told = f"{share:.{digits}f} % (± {error:.{digits}f} %, {draws} draws)"
    title = Text.assemble(
        ("As well as the robots are known, ", "bold"),
        f"this constant delay is stable with probability {told}{''.join(f', {limit}' for limit in limits)}.",
    )
    table = Table(box=None, pad_edge=False)
    for name in ("axis", "kₘ, 95 %", "δₘ, 95 %"):
        table.add_column(name, justify="left" if name == "axis" else "right", no_wrap=True)
    for axis in known.axes:
        low, high = axis.critical_stiffness
        table.add_row(
            axis.axis,
            f"{_digits(low, 0, ROUND_FLOOR)} to {_digits(high, 0, ROUND_CEILING)} N/m",
            " to ".join(
                _delay(end, rounding)
                for end, rounding in zip(axis.maximum_delay, (ROUND_FLOOR, ROUND_CEILING), strict=True)
            ),
        )
    return [Padding(title, (1, 0, 0, 0)), table]


def _in_arms(decision: Decision) -> list[Padding]:
    """Tell what the arms and agents that a study file names make of the answer."""
    found = decision.in_arms
    if found is None:
        return []
    held = "In the rehearsal arms and agents hold the handles"
    if found.holding is None:
        lines = [Text(f"{held}. In these arms: {found.in_words()}")]
    else:
        (one,) = found.conditions
        verdict = ("stable", "bold green") if one.stable else ("unstable", "bold red")
        where, how = "", one.pace()
        if one.worst_position is not None:
            how = f"{one.verdict().partition(', ')[2]}, {how}"
        if one.unstable_poses and found.poses is not None:
            where = f" in {one.unstable_poses} of {len(found.poses.places)} poses"
        elif one.unstable_axes:
            where = f" on {' and '.join(one.unstable_axes)}"
        controllers = "" if decision.sampled_stable is None else " with continuous controllers"
        arms = f"{held} ({found.holding.in_words()}). In these arms: "
        lines = [Text.assemble(arms, verdict, f"{where}{controllers} ({how}).")]
        if found.poses is not None:
            lines.append(Text(f"{found.poses.in_words()}."))
    return [Padding(Group(*lines), (1, 0, 0, 0))]


def _changes(decision: Decision) -> Padding:
    if decision.stable:
        title, lines = "To be safe under more than this constant delay: ", _towards_more(decision)
    else:
        title, lines = "To be stable at a constant delay, one of: ", _towards_stability(decision)
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))


def _towards_stability(decision: Decision) -> list[str]:
    remedies = decision.remedies
    softer = (
        f"stiffness below {_stiffness(remedies.stiffness)}"
        if remedies.stiffness > 0.0
        else "no stiffness is low enough"
    )
    if decision.continuous_stable:
        return [softer, "controllers that sample faster: continuous ones are stable"]
    way = "each way" if decision.delay[0] == decision.delay[1] else "on average of both ways"
    counted = ", jitter and gaps included" if decision.buffered else ""
    nearer = (
        f"delay below {_delay(remedies.delay)} {way}{counted}"
        if remedies.delay > 0.0
        else "no delay is short enough"
    )
    if math.isinf(remedies.added_damping):
        damped = "no damping is enough"
    else:
        added = _digits(remedies.added_damping, 0, ROUND_CEILING)
        damped = f"more than {added} N·s/m added to the damping of both robots"
    if decision.sampled_stable is not None:
        nearer, damped = (f"{line} (with continuous controllers)" for line in (nearer, damped))
    return [softer, nearer, damped]


def _towards_more(decision: Decision) -> list[str]:
    strongest = decision.verdict("any network")
    if strongest.available and strongest.satisfied:
        return ["nothing to change"]
    lines = []
    for name, promise in (
        ("any constant delay", "under any constant delay"),
        ("bounded varying delay", "while the delay varies within its budget"),
        ("any network", "on any network"),
    ):
        verdict = decision.verdict(name)
        if not verdict.available or (verdict.satisfied and verdict.assumption_met):
            continue
        buffer = "" if verdict.assumption_met else " behind a playout buffer"
        if verdict.satisfied:
            lines.append(f"a playout buffer, to be stable {promise}")
        elif verdict.stiffness_allowed > 0.0:
            allowed = _allowed(verdict.stiffness_allowed, verdict.attained)
            lines.append(f"stiffness {allowed} {promise}{buffer}")
        else:
            lines.append(f"no stiffness is low enough {promise}{buffer}")
    return lines or ["nothing to change"]
