"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math

from rich.console import Console, Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from telespring.decision import AxisDecision, Decision

__all__ = ["decision_screen", "refusal_screen"]


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
        _verdict_table(decision),
        *_notes(decision),
        _axis_table(decision),
        _budget(decision),
        _changes(decision),
    )


def refusal_screen(console: Console, field: str, value: str, allowed: str, remedy: str) -> None:
    """Print why an input was refused: field, value, what is allowed, and how to mend it."""
    console.print(Text.assemble(("Refused: ", "bold red"), (field, "bold"), f" = {value}"))
    console.print(Text(f"  Allowed: {allowed}."))
    console.print(Text(f"  {remedy}"))


#: Whether the network is of the kind that a verdict assumes, for a narrow column.
_FITS = {
    "met": Text("fits"),
    "met behind playout buffer": Text("if buffered", style="yellow"),
    "not met": Text("does not fit", style="red"),
}


def _stiffness(value: float) -> str:
    return "no limit" if math.isinf(value) else f"{value:.4g} N/m"


def _delay(value: float) -> str:
    if math.isinf(value):
        return "no limit"
    return f"{value * 1e3:.4g} ms" if value < 1 else f"{value:.4g} s"


def _link(decision: Decision) -> str:
    forward, backward = decision.delay
    if forward == backward:
        return f"{_delay(forward)} each way"
    return f"{_delay(forward)} there and {_delay(backward)} back"


def _headline(decision: Decision, title: str) -> Text:
    worst = decision.worst_axis
    asked = f"{title}: {_stiffness(decision.stiffness)} over {_link(decision)}\n"
    if decision.stable:
        return Text.assemble(
            (asked, "bold"), ("STABLE", "bold green"), f" at this constant delay. {_margin(decision)}\n"
        )
    growth = worst.spectral_abscissa
    pace = (
        f": it grows by the factor e every {_delay(1 / growth)}"
        if growth > 0
        else ": it swings on without end"
    )
    unstable = [axis.axis for axis in decision.axes if not axis.stable]
    return Text.assemble(
        (asked, "bold"),
        ("UNSTABLE", "bold red"),
        f" on axis {', '.join(unstable)}{pace} (axis {worst.axis}).\n",
    )


def _margin(decision: Decision) -> str:
    end, nearest = min((_end_of_interval(axis, decision.mean_delay), axis.axis) for axis in decision.axes)
    if math.isinf(end) or end >= decision.horizon:
        if all(math.isinf(axis.maximum_delay) for axis in decision.axes):
            return "No constant delay of any length can change that."
        return f"It stays stable up to {_delay(decision.horizon)} at least."
    softest = min(axis.maximum_stiffness for axis in decision.axes)
    text = f"The delay may grow by {_delay(end - decision.mean_delay)}, to {_delay(end)} (axis {nearest})"
    if decision.stiffness < softest < math.inf:
        text += f"; the stiffness by {100 * (softest / decision.stiffness - 1):.3g} %"
    return text + "."


def _end_of_interval(axis: AxisDecision, delay: float) -> float:
    if math.isinf(axis.maximum_delay):
        return math.inf
    return next((end for start, end in axis.stable_delays if start <= delay < end), -math.inf)


def _verdict_table(decision: Decision) -> Table:
    table = Table(
        title="What the network may do", title_justify="left", title_style="bold", box=None, pad_edge=False
    )
    table.add_column("verdict", no_wrap=True)
    table.add_column("rule", ratio=1)
    table.add_column("allows up to", justify="right", no_wrap=True)
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
            _stiffness(verdict.stiffness_allowed),
            verdict.axis or "–",
            _yes_or_no(verdict.satisfied),
            _FITS[verdict.assumption],
        )
    return table


def _notes(decision: Decision) -> list[Text]:
    notes = []
    if decision.stiffness_allowed is not None:
        allowed = _stiffness(decision.stiffness_allowed)
        notes.append(Text(f"This network as it is allows up to {allowed} ({decision.allowing_verdict})."))
    if not decision.paper_agrees:
        notes.append(Text("The paper's formulas are wrong here.", style="yellow"))
    if decision.sampled_stable is not None:
        state = "stable" if decision.sampled_stable else "UNSTABLE"
        notes.append(Text(f"With controllers that sample, at this constant delay: {state}."))
    if decision.over_operator_ranges:
        notes.append(Text("Verdicts: the worst over the ranges of operators. Margins: their middle."))
    return notes


def _yes_or_no(is_so: bool) -> Text:
    return Text("yes", style="green") if is_so else Text("no", style="red")


def _axis_table(decision: Decision) -> Padding:
    table = Table(title="Margins by axis", title_justify="left", title_style="bold", box=None, pad_edge=False)
    table.add_column("axis")
    for name in ("kₘ exact", "kₘ paper", "δₘ exact", "δₘ paper", "slowest root"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column(f"stable delays up to {_delay(decision.horizon)}")
    for axis in decision.axes:
        stable = ", ".join(f"{_delay(start)} to {_delay(end)}" for start, end in axis.stable_delays)
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
    used = " + ".join(f"{_delay(seconds)} {part}" for part, seconds in parts.items() if seconds > 0.0)
    return f"{direction}: {used or 'nothing'} = {_delay(sum(parts.values()))}"


def _changes(decision: Decision) -> Padding:
    remedies = decision.remedies
    lines = []
    if not decision.stable:
        lines.append(f"stiffness below {_stiffness(remedies.stiffness)}, or")
        lines.append(f"delay below {_delay(remedies.delay)} each way, or")
        lines.append(f"{remedies.added_damping:.4g} N·s/m more damping on both robots")
        title = "To be stable at a constant delay, one of: "
    else:
        title = "To be safe under more than this constant delay: "
        for name, promise in (
            ("any constant delay", "under any constant delay"),
            ("bounded varying delay", "while the delay varies within its budget"),
            ("any network", "on any network"),
        ):
            verdict = decision.verdict(name)
            if verdict.available and not (verdict.satisfied and verdict.assumption_met):
                lines.append(f"stiffness below {_stiffness(verdict.stiffness_allowed)} {promise}")
        if not lines:
            lines.append("nothing to change")
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))
