"""The headline of a decision: the answer in a word, by what margin, with and without a playout buffer."""

from __future__ import annotations

import math

from rich.text import Text

from telespring._core import LEAST_PROBABILITY, RESERVE
from telespring._types import Status
from telespring.decision.decide import Decision
from telespring.show.quantities import (
    format_doubling_time,
    format_number,
    format_probability,
    format_stiffness,
    format_time,
)
from telespring.show.screens.questions import (
    IN_ORDER,
    allowed_stiffness,
    answers_by_buffer,
    delay_clause,
    hands_name,
    one_hand_lines,
)

__all__ = ["answer_lines"]

_WORDS: dict[Status, tuple[str, str]] = {
    "stable": ("STABLE", "bold green"),
    "marginal": ("MARGINAL", "bold yellow"),
    "unstable": ("UNSTABLE", "bold red"),
    "not proven": ("NOT PROVEN", "bold yellow"),
}


def answer_lines(decision: Decision, held: str) -> list[Text]:
    """Write the answer for free and for held handles, without and with a playout buffer where they differ.

    `held` says what holds the handles; empty if they are free.
    """
    cases = [("", decision)]
    if decision.free is not None:
        cases = [("Free handles", decision.free), (hands_name(held), decision)]
    lines = []
    for name, case in cases:
        if case.varying is not None and not case.is_as_stated:
            lines += answers_by_buffer(name, _varying_delay_answer(case), None, is_promised=True)
            continue
        lines += answers_by_buffer(
            name,
            _constant_delay_answer(case),
            None if case.varying is None else _varying_delay_answer(case),
            is_promised=case.has_playout_buffer,
            buffer=delay_clause(case.constant_delay),
        )
    if decision.free is not None:
        lines += one_hand_lines(decision.question)
    return lines


def _varying_delay_answer(decision: Decision) -> Text:
    """Write what is proven while the delay varies."""
    varying = decision.varying
    assert varying is not None
    status = decision.status
    word, style = _WORDS[status]
    if decision.question.unjudged:
        return Text.assemble((word, style), ": something about it is not judged, as said above.")
    if not decision.is_bounded:
        return Text.assemble((word, style), _unbounded(decision))
    limit = allowed_stiffness(varying.stiffness_limit, varying.is_attained)
    proven = {"no limit": "every stiffness is proven", "none": "no stiffness is proven"}.get(
        limit, f"proven is a stiffness {limit} N/m"
    )
    if varying.tier == "age in a range":
        proven += f", {IN_ORDER}"
    match status:
        case "stable":
            why = f" however the delay varies, with {_percent(RESERVE)} in reserve; {proven}."
        case "marginal":
            why = f": stable however the delay varies, but with too little in reserve; {proven}."
        case "unstable":
            why = f" already at a constant delay that the network may have; {proven}."
        case _ if decision.axes_independent is False:
            why = ": the axes are not independent."
        case _:
            why = f": a delay that varies may destabilise it; {proven}."
    return Text.assemble((word, style), why)


def _unbounded(decision: Decision) -> str:
    """Write why, where only what is stable on any network is proven."""
    varying = decision.varying
    assert varying is not None
    limit = allowed_stiffness(varying.stiffness_limit, varying.is_attained)
    proven = f"on any network, a stiffness {limit} N/m is proven."
    if limit in {"none", "no limit"}:
        proven = f"on any network, {'no' if limit == 'none' else 'every'} stiffness is proven."
    match decision.status:
        case "stable":
            return f" on any network, with {_percent(RESERVE)} in reserve; {proven}"
        case "marginal":
            return f": stable on any network, but with too little in reserve; {proven}"
        case "unstable":
            return f" already at a constant delay that the network may have; {proven}"
        case _:
            return f": its samples may become older than any bound; {proven}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _constant_delay_answer(decision: Decision) -> Text:
    status = decision.constant_delay_status
    word, style = _WORDS[status]
    if decision.question.unjudged:
        word, style = _WORDS["not proven"]
        return Text.assemble((word, style), ": something about it is not judged, as said above.")
    where = "at this constant delay"
    match status:
        case "stable":
            why = f" {where}, with {_percent(RESERVE)} in reserve{_probability(decision)}"
        case "marginal":
            why = f": stable {where}, but {_missing_reserve(decision)}"
        case "not proven" if decision.axes_independent is False:
            word, why = "STABLE AXIS BY AXIS ONLY", f" {where}"
        case "not proven":
            why = f": no unstable motion was found {where}"
        case _:
            names = [axis.name for axis in decision.axes if not axis.stable]
            unstable = f"{'axis' if len(names) == 1 else 'axes'} {' and '.join(names)}"
            return Text.assemble((word, style), f" on {unstable} {where}{_growth(decision)}.")
    return Text.assemble((word, style), f"{why}. {_margins(decision)}".rstrip())


def _probability(decision: Decision) -> str:
    """Write the probability of a stable answer, where the robots have errors."""
    if decision.uncertainty is None:
        return ""
    stable = decision.uncertainty.stable
    told = format_probability(stable.value, stable.standard_error, stable.draws).partition(" (")[0]
    return f" and a probability {'of ' if told[0].isdigit() else ''}{told}"


def _missing_reserve(decision: Decision) -> str:
    short = [
        name
        for name, is_kept in (
            ("stiffness", decision.keeps_stiffness_reserve),
            ("delay", decision.keeps_delay_reserve),
        )
        if not is_kept
    ]
    reasons = [f"with less than {_percent(RESERVE)} of {' and of '.join(short)} in reserve"] if short else []
    known = decision.uncertainty
    if known is not None and known.stable.value < LEAST_PROBABILITY:
        reasons.append(f"with a probability below {_percent(LEAST_PROBABILITY)}")
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
        return f"{why}: the motion doubles every {format_doubling_time(growth)} (axis {worst.name})"
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


def _difference(longer: float, shorter: float, digits: int = 3) -> str:
    """Write how much longer a delay may be; both are known to far less than a picosecond."""
    return format_time(round(longer - shorter, 12), digits, rounding="down")


def _delay_margin(decision: Decision) -> str:
    delay, end = decision.mean_delay, decision.delay_limit
    if math.isinf(end):
        return "No constant delay, however long, destabilises it."
    if delay < end:
        growth = _difference(end, delay)
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
    fall, low = _difference(delay, start, 4), format_time(start, rounding="up")
    if end >= max(decision.horizon, 2.0 * delay):
        growth = f"to {format_time(end, rounding='down')} at least"
    else:
        growth = f"by {_difference(end, delay, 4)}, to {format_time(end, rounding='down')} (axis {end_axis})"
    first = format_time(decision.delay_limit, rounding="down")
    return (
        f"It is stable again beyond a first limit of {first}: {given} delay may grow {growth}, and "
        f"shrink by {fall}, to {low} (axis {start_axis})."
    )
