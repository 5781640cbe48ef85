"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring.decision.decide import Decision
from telespring.decision.reserve import RESERVE, Status
from telespring.decision.varying_delay import VaryingDelay
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.show.screens.decision_answer import answer_lines
from telespring.show.screens.decision_details import arms_note, decision_details
from telespring.show.screens.layout import Fitting, fitting_table
from telespring.show.screens.questions import (
    CONTINUOUS_TIERS,
    MAYBE_TOO_SMALL,
    TABLE_TITLE,
    allowed_stiffness,
    delay_clause,
    hand_effect,
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


#: The answers from good to bad.
_RANKS: dict[Status, int] = {"stable": 0, "marginal": 1, "not proven": 2, "unstable": 3}


def decision_screen(
    decision: Decision, heading: Sequence[str], held: str = "", notes: Sequence[str] = ()
) -> RenderableType:
    """Lay a decision out for the terminal: what it rests on, the answer, verdicts, what to change, details.

    `heading` names the study and its robots, `held` says what holds the handles (empty if they are free), and
    `notes` say how the question was understood.
    """
    return Group(
        _question(decision, heading, notes),
        *_warnings(decision),
        Padding(Group(*answer_lines(decision, held)), (0, 0, 1, 0)),
        _verdict_table(decision),
        *_verdict_notes(decision),
        _suggested_changes(decision),
        *decision_details(decision),
    )


def _question(decision: Decision, heading: Sequence[str], notes: Sequence[str]) -> Text:
    network = decision.verdicts.network
    asked = f"{format_number(decision.stiffness, 6)} N/m over {network_clause(network)}, "
    text = Text("\n".join([*heading, asked + sampling_clause(network.sample_period)]), style="bold")
    for note in notes:
        text.append(f"\n{note}", style="not bold")
    return text


def _warnings(decision: Decision) -> list[RenderableType]:
    """Say what the answer rests on before it is given: holders that are not in it, and the robots' notes."""
    arms = arms_note(decision)
    notes = [Text.assemble(("Note: ", "bold yellow"), arms)] if arms else []
    return [*notes, *warning_lines(decision)]


def _verdict_table(decision: Decision) -> Fitting:
    bounds = tier_bounds(decision.verdicts)
    if decision.free is not None:
        beside: list[tuple[str, ...]] = [
            (
                own.verdict.tier,
                free.allowed,
                own.allowed,
                hand_effect(free.bound, own.bound),
            )
            for own, free in zip(bounds, tier_bounds(decision.free.verdicts), strict=True)
        ]
        delays = decision.free.delay_limit, decision.delay_limit
        free_delay, held_delay = (format_time(end, rounding="down") for end in delays)
        beside.append(("longest delay", free_delay, held_delay, hand_effect(*delays)))
        columns = ("network", "free, N/m", "held, N/m", "a hand")
        return fitting_table(TABLE_TITLE, columns, beside, right=(1, 2))
    rows: list[tuple[str | Text, ...]] = []
    for own in bounds:
        formula = TIERS[own.verdict.tier].formula
        if own.bound is None:
            rows.append((own.verdict.tier, formula, own.allowed, "–", "–", "–"))
            continue
        applies = network_fits(own.verdict.assumption)
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


def _suggested_changes(decision: Decision) -> Padding:
    title, lines = _changes_for(decision)
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))


def _changes_for(decision: Decision) -> tuple[str, list[str]]:
    free = decision.free
    if free is not None and _RANKS[free.status] > _RANKS[decision.status]:
        title, lines = _changes_for(free)
        return f"With free handles: t{title[1:]}", lines
    if decision.varying is not None and not decision.has_playout_buffer:
        return _changes_while_varying(decision, decision.varying)
    if decision.status == "marginal":
        return "To have the reserve: ", [_reserve_change(decision)]
    if not decision.stable:
        return "To be stable at a constant delay, one of: ", _stabilising_changes(decision)
    return "To guarantee stability beyond this constant delay: ", _stronger_guarantees(decision)


def _changes_while_varying(decision: Decision, varying: VaryingDelay) -> tuple[str, list[str]]:
    """Write what makes a network with jitter stable: less stiffness, or a buffer and what helps behind it."""
    if decision.status == "stable":
        return "To guarantee stability beyond this network: ", _stronger_guarantees(decision)
    lines = []
    if varying.usable_stiffness > 0.0 and math.isfinite(varying.usable_stiffness):
        lines.append(f"a stiffness of at most {format_stiffness(varying.usable_stiffness)}")
    buffer = f"a playout buffer of {delay_clause(decision.constant_delay)} (then say --playout-buffer)"
    if decision.constant_delay_status in {"stable", "marginal"}:
        lines.append(buffer)
    else:
        lines += [f"{buffer} and {line}" for line in _stabilising_changes(decision)]
    return "To be stable with the reserve, one of: ", lines


def _reserve_change(decision: Decision) -> str:
    if decision.keeps_stiffness_reserve and decision.keeps_delay_reserve:
        return "identify the robots from more logs, or choose a lower stiffness"
    lower = "a lower stiffness"
    if decision.stiffness < decision.stiffness_limit:
        lower += f", below {format_stiffness(decision.stiffness_limit / (1.0 + RESERVE))}"
    return f"{lower}; ask without a stiffness to see how much you may use"


def _stabilising_changes(decision: Decision) -> list[str]:
    softer = (
        f"a stiffness below {format_stiffness(decision.stiffness_limit)}"
        if decision.stiffness_limit > 0.0
        else "no stiffness is low enough"
    )
    way = "each way" if decision.delay[0] == decision.delay[1] else "on average of both ways"
    counted = ", jitter and gaps included" if decision.buffered else ""
    nearer = (
        f"a delay below {format_time(decision.delay_limit, rounding='down')} {way}{counted}"
        if decision.delay_limit > 0.0
        else "no delay is short enough"
    )
    if math.isinf(decision.delay_limit):
        nearer = ""
    if math.isinf(decision.added_damping):
        damped = "no damping is enough"
    else:
        added = format_number(decision.added_damping, rounding="up")
        damped = f"more than {added} N·s/m of damping added to each robot"
    lines = [softer, nearer, damped]
    if decision.continuous_stable:
        lines.append("a shorter sample period: continuous controllers are stable")
    return [line for line in lines if line]


def _ages_clause(decision: Decision) -> str:
    ages = decision.verdicts.tier("age in a range").ages or ()
    low, high = min(least for least, _ in ages), max(most for _, most in ages)
    return f"between {format_time(low, 6)} and {format_time(high, 6)}"


def _stronger_guarantees(decision: Decision) -> list[str]:
    strongest = decision.verdicts.tier("any network")
    if strongest.stiffness_bound is not None and strongest.satisfied:
        return ["nothing to change"]
    lines = []
    oldest = max(budget.total for budget in decision.verdicts.delay_budget)
    promises = {
        "any constant delay": "under any constant delay",
        "age in a range": f"while every sample's age stays {_ages_clause(decision)} and none is overtaken",
        "bounded varying delay": f"while no sample is older than {format_time(oldest, 6)}",
        "any network": "on any network",
    }
    for verdict in reversed(decision.verdicts.tiers):
        promise, bound = promises.get(verdict.tier), verdict.stiffness_bound
        if promise is not None and verdict.unavailable == "not proven over the range":
            lines.append(f"no stiffness is proven {promise} for the whole range")
        if promise is None or bound is None or (verdict.satisfied and verdict.assumption_met):
            continue
        buffer = "" if verdict.assumption_met else " behind a playout buffer"
        if verdict.satisfied:
            lines.append(f"a playout buffer, to be stable {promise}")
        elif bound > 0.0:
            lines.append(f"a stiffness {allowed_stiffness(bound, verdict.attained)} N/m {promise}{buffer}")
        else:
            lines.append(f"no stiffness is low enough {promise}{buffer}")
    return lines or ["nothing to change"]
