"""The answer of `telespring decide` as one screen of text, in ms, mm and N/m."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring.decision.decide import Decision
from telespring.decision.reserve import LEAST_PROBABILITY, RESERVE
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.show.screens.decision_details import decision_details
from telespring.show.screens.layout import Fitting, fitting_table
from telespring.show.screens.questions import (
    CONTINUOUS_TIERS,
    allowed_stiffness,
    given_delay,
    hand_effect,
    sampling_clause,
    sampling_note,
    tier_bounds,
)
from telespring.show.screens.robots import robot_notes
from telespring.show.tiers import TIERS

__all__ = ["decision_screen"]

#: Whether a tier's assumption holds on this network, for a narrow column.
_APPLIES = {
    "met": Text("yes"),
    "met behind playout buffer": Text("if buffered", style="yellow"),
    "not met": Text("no", style="red"),
}


def decision_screen(
    decision: Decision, title: str, held: str = "held", notes: Sequence[str] = ()
) -> RenderableType:
    """Lay a decision out for the terminal: the answer, verdicts, what to change, then the details.

    `held` says how the handles are held, where the answer for free handles stands beside; `notes` say how
    the question was understood.
    """
    return Group(
        _question(decision, title, notes),
        _answers(decision, held),
        *_warnings(decision),
        _verdict_table(decision),
        *_verdict_notes(decision),
        _suggested_changes(decision),
        *decision_details(decision),
    )


def _question(decision: Decision, title: str, notes: Sequence[str]) -> Text:
    network = decision.verdicts.network
    lines = [title, f"{format_number(decision.stiffness, 6)} N/m over {given_delay(decision.delay)}, "]
    lines[-1] += sampling_clause(network.sample_period)
    text = Text("\n".join(lines), style="bold")
    for note in notes:
        text.append(f"\n{note}", style="not bold")
    return text


def _answers(decision: Decision, held: str) -> Padding:
    if decision.free is None:
        lines = [_answer(decision)]
    else:
        lines = [
            Text.assemble(("Free handles: ", "bold"), _answer(decision.free)),
            Text.assemble((f"Handles {held}: ", "bold"), _answer(decision)),
        ]
    return Padding(Group(*lines), (0, 0, 1, 0))


def _warnings(decision: Decision) -> list[RenderableType]:
    lines = [Text.assemble(("Warning: ", "bold yellow"), note) for note in robot_notes(decision)]
    return [Padding(Group(*lines), (0, 0, 1, 0))] if lines else []


def _where(decision: Decision) -> str:
    if not decision.buffered:
        return "at this constant delay"
    delay = given_delay(decision.constant_delay).removesuffix(" each way")
    return f"at a constant delay of {delay} (behind a playout buffer)"


def _answer(decision: Decision) -> Text:
    where = _where(decision)
    match decision.status:
        case "stable":
            word, style, why = "STABLE", "bold green", f" {where}, with {RESERVE:.0%} in reserve"
        case "marginal":
            word, style, why = (
                "MARGINAL",
                "bold yellow",
                f": stable {where}, but {_missing_reserve(decision)}",
            )
        case "not proven":
            coupled = decision.axes_independent is False
            word = "STABLE AXIS BY AXIS ONLY" if coupled else "NOT PROVEN"
            style, why = "bold yellow", f" {where}" if coupled else f": no unstable motion was found {where}"
        case _:
            names = [axis.name for axis in decision.axes if not axis.stable]
            unstable = f"{'axis' if len(names) == 1 else 'axes'} {', '.join(names)}"
            return Text.assemble(("UNSTABLE", "bold red"), f" on {unstable} {where}{_growth(decision)}.")
    return Text.assemble((word, style), f"{why.replace('%', ' %')}. {_margins(decision)}".rstrip())


def _missing_reserve(decision: Decision) -> str:
    short = [
        name
        for name, is_kept in (
            ("stiffness", decision.keeps_stiffness_reserve),
            ("delay", decision.keeps_delay_reserve),
        )
        if not is_kept
    ]
    reasons = [f"with less than {RESERVE:.0%} of {' and of '.join(short)} in reserve"] if short else []
    known = decision.uncertainty
    if known is not None and known.stable.value < LEAST_PROBABILITY:
        reasons.append(f"with a probability below {LEAST_PROBABILITY:.0%}")
    return " and ".join(reasons)


def _growth(decision: Decision) -> str:
    """Describe how an unstable dyad leaves its rest, where the growth of the worst operators is known."""
    worst = decision.worst_axis
    growth = worst.worst_case.spectral_abscissa if worst.sampled_abscissa is None else worst.sampled_abscissa
    why = ""
    if decision.continuous_stable:
        why = " with sampled controllers"
    elif decision.over_operator_ranges:
        return " for some operators in their ranges"
    if growth > 0.0:
        return f"{why}: the motion grows by a factor of e every {format_time(1 / growth)} (axis {worst.name})"
    return f"{why}: the motion oscillates without decay (axis {worst.name})"


def _margins(decision: Decision) -> str:
    """Describe how far stiffness and delay may go from a stable point."""
    sentences = []
    limit = decision.stiffness_limit
    more = limit / decision.stiffness - 1.0
    if 0.0 < more < math.inf:
        share = format_number(more, 3, rounding="down", shift=2)
        sentences.append(f"The stiffness may grow by {share} %, to {format_stiffness(limit)}.")
    sentences.append(_delay_margin(decision))
    return " ".join(sentence for sentence in sentences if sentence)


def _delay_margin(decision: Decision) -> str:
    delay, end = decision.mean_delay, decision.delay_limit
    if math.isinf(end):
        return "No constant delay, however long, destabilises it."
    if delay < end:
        growth = format_time(end - delay, 3, rounding="down")
        return f"The delay may grow by {growth}, to {format_time(end, rounding='down')}."
    if decision.delay_limit_attained and math.isclose(delay, end):
        return "The delay may not grow: it is the last whole number of sample periods."
    # A later interval of stable delays, known for one pair of operators per axis.
    around = [(axis.worst_case.stable_around, axis.name) for axis in decision.axes]
    known = [(interval, name) for interval, name in around if interval is not None]
    if len(known) < len(around):
        return ""
    start, start_axis = max((interval[0], name) for interval, name in known)
    end, end_axis = min((interval[1], name) for interval, name in known)
    given = "with the worst case of each axis the" if decision.over_operator_ranges else "the"
    fall, low = format_time(delay - start, rounding="down"), format_time(start, rounding="up")
    if end >= max(decision.horizon, 2.0 * delay):
        growth = f"to {format_time(end, rounding='down')} at least"
    else:
        by = format_time(end - delay, rounding="down")
        growth = f"by {by}, to {format_time(end, rounding='down')} (axis {end_axis})"
    first = format_time(decision.delay_limit, rounding="down")
    return (
        f"It is stable again beyond a first limit of {first}: {given} delay may grow {growth}, and "
        f"shrink by {fall}, to {low} (axis {start_axis})."
    )


def _verdict_table(decision: Decision) -> Fitting:
    bounds = tier_bounds(decision.verdicts)
    if decision.free is not None:
        beside: list[tuple[str, ...]] = [
            (
                own.verdict.tier,
                allowed_stiffness(free.bound, free.attained),
                allowed_stiffness(own.bound, own.attained),
                hand_effect(free.bound, own.bound),
            )
            for own, free in zip(bounds, tier_bounds(decision.free.verdicts), strict=True)
        ]
        delays = decision.free.delay_limit, decision.delay_limit
        free_delay, held_delay = (format_time(end, rounding="down") for end in delays)
        beside.append(("longest delay", free_delay, held_delay, hand_effect(*delays)))
        columns = ("network", "free handles", "held", "a hand")
        return fitting_table("How stiff can the spring be, N/m?", columns, beside, right=(1, 2))
    rows: list[tuple[str | Text, ...]] = []
    for own in bounds:
        formula = TIERS[own.verdict.tier].formula
        if own.bound is None:
            rows.append((own.verdict.tier, formula, "no rule", "–", "–", "–"))
            continue
        applies = _APPLIES[own.verdict.assumption]
        bound = allowed_stiffness(own.bound, own.attained)
        rows.append((own.verdict.tier, formula, bound, own.axis, _yes_or_no(own.is_satisfied), applies))
    headings = ("network", "rule", "k, N/m", "axis", "holds", "applies")
    return fitting_table("How stiff can the spring be?", headings, rows, right=(2,))


def _yes_or_no(is_so: bool) -> Text:
    return Text("yes", style="green") if is_so else Text("no", style="red")


def _verdict_notes(decision: Decision) -> list[Text]:
    notes = []
    allowed = decision.verdicts.stiffness_allowed
    if allowed is not None:
        stiffness = allowed_stiffness(allowed.stiffness, allowed.attained)
        allowed_text = {"no limit": "any stiffness", "none": "no stiffness"}.get(
            stiffness, f"a stiffness {stiffness} N/m"
        )
        unbuffered = " without a playout buffer" if decision.buffered else ""
        notes.append(Text(f"This network allows {allowed_text}{unbuffered} ({allowed.tier})."))
    if decision.sampled_stable is not None:
        notes.append(Text(CONTINUOUS_TIERS))
        notes.append(Text(sampling_note(decision.verdicts)))
    if decision.over_operator_ranges:
        notes.append(Text("Every limit is the worst over the ranges of operators."))
    notes.append(_paper_note(decision))
    return notes


def _paper_note(decision: Decision) -> Text:
    paper = decision.verdicts.paper
    word = "stable" if paper.stable else "unstable"
    within = "at most" if decision.stiffness <= paper.critical_stiffness else "above"
    text = f"The paper calls it {word}: {within} its {format_stiffness(paper.critical_stiffness)} (Eq. 5)"
    if math.isfinite(paper.maximum_delay):
        side = "below" if decision.mean_delay < paper.maximum_delay else "not below"
        text += f", {side} its {format_time(paper.maximum_delay, rounding='down')} (Eq. 6)"
    if paper.agrees:
        return Text(f"{text}.")
    return Text.assemble(f"{text}. ", ("The paper's formulas are wrong here.", "yellow"))


def _suggested_changes(decision: Decision) -> Padding:
    if not decision.stable:
        title, lines = "To be stable at a constant delay, one of: ", _stabilising_changes(decision)
    else:
        title = "To guarantee stability beyond this constant delay: "
        lines = _stronger_guarantees(decision)
    if decision.status == "marginal":
        title, lines = "To have the reserve: ", [_reserve_change(decision)]
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))


def _reserve_change(decision: Decision) -> str:
    if decision.keeps_stiffness_reserve and decision.keeps_delay_reserve:
        return "identify the robots from more logs, or choose a lower stiffness"
    if decision.stiffness < decision.stiffness_limit:
        most = format_stiffness(decision.stiffness_limit / (1.0 + RESERVE))
        return f"a lower stiffness, below {most}; without --stiffness, decide says how much you may use"
    return "a lower stiffness; without --stiffness, decide says how much you may use"


def _stabilising_changes(decision: Decision) -> list[str]:
    softer = (
        f"stiffness below {format_stiffness(decision.stiffness_limit)}"
        if decision.stiffness_limit > 0.0
        else "no stiffness is low enough"
    )
    way = "each way" if decision.delay[0] == decision.delay[1] else "on average of both ways"
    counted = ", jitter and gaps included" if decision.buffered else ""
    nearer = (
        f"delay below {format_time(decision.delay_limit, rounding='down')} {way}{counted}"
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


def _stronger_guarantees(decision: Decision) -> list[str]:
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
            lines.append(f"stiffness {allowed_stiffness(bound, verdict.attained)} N/m {promise}{buffer}")
        else:
            lines.append(f"no stiffness is low enough {promise}{buffer}")
    return lines or ["nothing to change"]
