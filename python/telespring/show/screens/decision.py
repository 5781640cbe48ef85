"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring.decision.decide import Decision
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.show.screens.decision_answer import answer_lines
from telespring.show.screens.decision_changes import suggested_changes
from telespring.show.screens.decision_details import arms_note, decision_details
from telespring.show.screens.layout import Fitting, fitting_table
from telespring.show.screens.questions import (
    CONTINUOUS_TIERS,
    MAYBE_TOO_SMALL,
    TABLE_TITLE,
    free_clause,
    hand_effect,
    hand_rows,
    network_clause,
    network_fits,
    range_notes,
    sampling_clause,
    sampling_note,
    tier_bounds,
)
from telespring.show.screens.robots import warning_lines
from telespring.show.tiers import TIERS

__all__ = ["decision_screen"]


def decision_screen(
    decision: Decision, heading: Sequence[str], held: str = "", notes: Sequence[str] = ()
) -> RenderableType:
    """Lay a decision out for the terminal: what it rests on, the answer, verdicts, what to change, details.

    `heading` names the study and its robots, `held` says what holds the handles (empty if they are free), and
    `notes` say how the question was understood.
    """
    return Group(
        _question(decision, heading, held, notes),
        *_warnings(decision),
        Padding(Group(*answer_lines(decision, held)), (0, 0, 1, 0)),
        _verdict_table(decision),
        *_verdict_notes(decision),
        suggested_changes(decision),
        *decision_details(decision),
    )


def _question(decision: Decision, heading: Sequence[str], held: str, notes: Sequence[str]) -> Text:
    network = decision.question.network_as_stated
    asked = f"{format_number(decision.stiffness, 6)} N/m over {network_clause(network)}, "
    asked += f"{sampling_clause(network.sample_period)}{free_clause(held)}"
    text = Text("\n".join([*heading, asked]), style="bold")
    for note in notes:
        text.append(f"\n{note}", style="not bold")
    return text


def _warnings(decision: Decision) -> list[RenderableType]:
    """Say what the answer rests on before it is given: holders that are not in it, and the robots' notes."""
    arms = arms_note(decision)
    notes = [Text.assemble(("Note: ", "bold yellow"), arms)] if arms else []
    return [*notes, *warning_lines(decision)]


def _verdict_table(decision: Decision) -> Fitting:
    if decision.free is not None:
        beside = hand_rows(decision.free.verdicts, decision.verdicts)
        delays = decision.free.delay_limit, decision.delay_limit
        free_delay, held_delay = (format_time(end, rounding="down") for end in delays)
        beside.append(("longest delay", free_delay, held_delay, hand_effect(*delays)))
        columns = ("network", "free, N/m", "held, N/m", "a hand")
        return fitting_table(TABLE_TITLE, columns, beside, right=(1, 2))
    rows: list[tuple[str | Text, ...]] = []
    for own in tier_bounds(decision.verdicts):
        formula = TIERS[own.verdict.tier].formula
        if own.bound is None:
            rows.append((own.verdict.tier, formula, own.allowed, "–", "–", "–"))
            continue
        applies = network_fits(own.verdict, decision.question)
        rows.append((own.verdict.tier, formula, own.allowed, own.axis, _yes_or_no(own.is_satisfied), applies))
    headings = ("network", "rule", "k, N/m", "axis", "stable", "yours")
    return fitting_table(TABLE_TITLE, headings, rows, right=(2,), optional=(1,))


def _yes_or_no(is_so: bool) -> Text:
    return Text("yes", style="green") if is_so else Text("no", style="red")


def _verdict_notes(decision: Decision) -> list[Text]:
    notes = [Text("Stable: within that limit. Yours: whether your network is of that kind.")]
    if decision.free is not None:
        notes = []
    if decision.sampled_stable is not None:
        notes.append(Text(CONTINUOUS_TIERS))
        if decision.varying is None or decision.has_playout_buffer:
            notes.append(Text(sampling_note(decision.verdicts)))
    if any(axis.verdict.sampled_proven is False for axis in decision.axes):
        notes.append(Text(MAYBE_TOO_SMALL))
    if not decision.delay_limit_proven:
        notes.append(Text("The longest delay may be too small, since the search was cut off."))
    if decision.over_operator_ranges:
        notes += map(Text, range_notes(tier_bounds(decision.verdicts)))
    notes.append(_paper_note(decision))
    return notes


def _paper_note(decision: Decision) -> Text:
    paper = decision.verdicts.paper
    word = "stable" if paper.stable else "unstable"
    within = "at most" if decision.stiffness <= paper.critical_stiffness else "above"
    text = f"The paper says {word}: {within} its {format_stiffness(paper.critical_stiffness)} (Eq. 5)"
    if math.isfinite(paper.maximum_delay):
        side = "below" if decision.mean_delay < paper.maximum_delay else "not below"
        text += f", {side} its {format_time(paper.maximum_delay, rounding='down')} (Eq. 6)"
    if paper.agrees:
        return Text(f"{text}.")
    return Text.assemble(f"{text}. ", ("The paper's formulas are wrong here.", "yellow"))
