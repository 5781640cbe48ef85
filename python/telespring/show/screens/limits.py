"""What a dyad may use, as one screen of text."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring._core import LEAST_PROBABILITY, RESERVE
from telespring.decision.limits import DelayLimits, Limits, StiffnessLimits
from telespring.decision.usable import LONGEST_USUAL_DELAY, STIFFEST_USUAL, recommended_stiffness
from telespring.decision.varying_delay import VaryingDelay
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.show.screens.layout import Fitting, fitting_table
from telespring.show.screens.questions import (
    CONTINUOUS_TIERS,
    IN_ORDER,
    MAYBE_TOO_SMALL,
    TABLE_TITLE,
    allowed_stiffness,
    answers_by_buffer,
    delay_clause,
    free_clause,
    hand_effect,
    hand_rows,
    hands_name,
    network_clause,
    network_fits,
    one_hand_lines,
    range_notes,
    sampling_clause,
    sampling_note,
    tier_bounds,
    variation_clause,
)
from telespring.show.screens.robots import warning_lines
from telespring.show.tiers import TIERS

__all__ = ["limits_screen"]

_RESERVE = f"{100 * RESERVE:.0f} % of stiffness and of delay in reserve"
_ANY_STIFFNESS = f"You may use any stiffness that laboratories use (up to {format_stiffness(STIFFEST_USUAL)})"
_NOT_JUDGED = Text.assemble(
    ("NOT PROVEN", "bold yellow"), ": something about it is not judged, as said above."
)
_PROBABLY = f", and with a probability of at least {100 * LEAST_PROBABILITY:.0f} %"


def limits_screen(
    found: Limits, heading: Sequence[str], held: str = "", notes: Sequence[str] = ()
) -> RenderableType:
    """Lay limits out for the terminal: what may be used, then what each kind of network allows.

    `heading` names the study and its robots, `held` says what holds the handles (empty if they are free), and
    `notes` say how the question was understood.
    """
    network = found.delays[0].question.network_as_stated
    sampling = sampling_clause(network.sample_period) + free_clause(held)
    if found.is_delay_given:
        asked = f"{network_clause(network)}, {sampling}"
    else:
        varies = variation_clause(network)
        asked = f"Any delay{f', {varies}' if varies else ''}, {sampling}"
    text = Text("\n".join([*heading, asked]), style="bold")
    for note in notes:
        text.append(f"\n{note}", style="not bold")
    parts: list[RenderableType] = [text, *warning_lines(found)]
    parts.append(Padding(Group(*_usable(found, held)), (0, 0, 1, 0)))
    if found.is_delay_given:
        parts.append(_tier_table(found))
        parts.append(Text("Give a stiffness too to see its margins, and what to change."))
    else:
        parts += _delay_tables(found)
        parts.append(Text("Give the delay or the ping of your own network for more."))
    if network.sample_period > 0.0:
        parts.append(Text(CONTINUOUS_TIERS))
        if found.is_delay_given:
            parts.append(Text(sampling_note(found.delays[0].verdicts)))
    if not all(row.is_sampled_proven for row in found.delays):
        parts.append(Text(MAYBE_TOO_SMALL))
    if found.over_operator_ranges:
        judged = [row.verdicts for row in (found.delays[:1] if found.is_delay_given else found.delays)]
        parts += map(Text, range_notes(bound for each in judged for bound in tier_bounds(each)))
    return Group(*parts)


def _usable(found: Limits, held: str) -> list[Text]:
    cases = [("", found)] if found.free is None else [("Free handles", found.free), (hands_name(held), found)]
    lines = []
    for name, case in cases:
        row, kept = case.delays[0], _kept(case)
        if case.stiffness is not None:
            buffered = _usable_delay(case.stiffness, kept)
            without = _usable_delay_while_varying(case.stiffness, kept)
        elif case.is_delay_given:
            buffered = _usable_stiffness(row, kept)
            without = None if row.varying is None else _usable_while_varying(row.varying, kept)
        else:
            continue
        if row.question.unjudged:
            lines += answers_by_buffer(name, _NOT_JUDGED, None, is_promised=True)
            continue
        if without is not None and not row.question.is_as_stated:
            lines += answers_by_buffer(name, without, None, is_promised=True)
            continue
        lines += answers_by_buffer(
            name,
            buffered,
            without,
            is_promised=found.has_playout_buffer,
            buffer=delay_clause(row.constant_delay) if case.is_delay_given else "",
        )
    lines = lines or [Text(f"What each delay allows, with {_kept(found)}:")]
    return lines if found.free is None else [*lines, *one_hand_lines(found.delays[0].question)]


def _kept(found: Limits) -> str:
    """Say what is kept in reserve; where robots have errors, stability must be probable, too."""
    return _RESERVE + (_PROBABLY if found.robots_have_errors else "")


def _usable_stiffness(row: DelayLimits, kept: str) -> Text:
    where = "at this constant delay"
    if math.isinf(row.usable_stiffness):
        return Text.assemble((_ANY_STIFFNESS, "bold green"), f" {where}.")
    if row.soft_springs_fail_by_sampling:
        why = (
            "even a soft spring is unstable, because a held force feeds more into the motion than the "
            "damping takes. A stiffer spring may be stable; give --stiffness."
        )
        return Text.assemble(("No stiffness is low enough", "bold red"), f" {where}: {why}")
    if row.stiffness_limit == 0.0 and not row.is_sampled_proven:
        return Text.assemble(
            ("No limit is proven", "bold yellow"),
            f" {where}: the search over the ranges was cut off. Give --stiffness to have one judged.",
        )
    if row.stiffness_limit == 0.0:
        return Text.assemble(("No stiffness is stable", "bold red"), f" {where}, however soft the spring.")
    if row.recommended_stiffness == 0.0:
        used = "that laboratories use " if row.usable_stiffness > 0.0 else ""
        return Text.assemble(
            (f"No stiffness {used}is safe", "bold red"),
            f" {where} with {kept}. {_stiffness_itself(row.stiffness_limit)}",
        )
    return Text.assemble(
        (_up_to(row.usable_stiffness), "bold green"),
        f" {where}, with {kept}. {_stiffness_itself(row.stiffness_limit)}",
    )


def _up_to(usable: float) -> str:
    """Write up to where a stiffness may be used, as far as laboratories use one."""
    if usable >= STIFFEST_USUAL:
        return _ANY_STIFFNESS
    return f"You may use up to {format_stiffness(usable)}"


def _delay_up_to(usable: float) -> str:
    """Write up to where a delay may be, as far as networks have one."""
    if usable >= LONGEST_USUAL_DELAY:
        return f"The delay may be any that networks have (up to {format_time(LONGEST_USUAL_DELAY)} each way)"
    return f"The delay may be up to {format_time(usable, rounding='down')} each way"


def _stiffness_itself(limit: float) -> str:
    if math.isinf(limit):
        return "Without this, no stiffness is too high."
    return f"The limit itself is {format_stiffness(limit)}."


def _usable_while_varying(varying: VaryingDelay, kept: str) -> Text:
    usable = varying.usable_stiffness
    if math.isinf(usable):
        return Text.assemble((_ANY_STIFFNESS, "bold green"), " however the delay varies.")
    if varying.recommended_stiffness == 0.0:
        return Text.assemble(
            ("No stiffness is proven", "bold yellow"), " to be stable while the delay varies."
        )
    return Text.assemble(
        (_up_to(usable), "bold green"),
        f" however the delay varies, with {kept}"
        f"{f', {IN_ORDER}' if varying.tier == 'age in a range' else ''}. "
        f"More than {format_stiffness(varying.stiffness_limit)} is not proven.",
    )


def _usable_delay_while_varying(row: StiffnessLimits, kept: str) -> Text | None:
    usable = row.usable_delay_while_varying
    if usable is None:
        return None
    if math.isinf(usable):
        return Text.assemble(("Any delay", "bold green"), " is stable at this stiffness, however it varies.")
    if usable == 0.0:
        return Text.assemble(
            ("No delay", "bold yellow"), " is proven to be stable at this stiffness while it varies."
        )
    return Text.assemble(
        (_delay_up_to(usable), "bold green"),
        f" at {format_stiffness(row.stiffness)}, jitter and gaps on top of it, with {kept}.",
    )


def _usable_delay(row: StiffnessLimits, kept: str) -> Text:
    if math.isinf(row.usable_delay):
        return Text.assemble(
            ("Any constant delay", "bold green"), " is stable at this stiffness, however long."
        )
    if row.usable_delay <= 0.0:
        return Text.assemble(("No delay", "bold red"), f" is stable at this stiffness with {kept}.")
    return Text.assemble(
        (_delay_up_to(row.usable_delay), "bold green"),
        f" at {format_stiffness(row.stiffness)}, with {kept}. "
        + (
            "Without this, no delay is too long."
            if math.isinf(row.delay_limit)
            else f"The limit itself is {format_time(row.delay_limit, rounding='down')}"
            f"{'' if row.delay_limit_proven else ' or more, since the search over the ranges was cut off'}."
        ),
    )


def _tier_table(found: Limits) -> Fitting:
    if found.free is None:
        rows: list[tuple[str | Text, ...]] = [
            (
                own.verdict.tier,
                TIERS[own.verdict.tier].formula,
                own.allowed,
                own.axis,
                network_fits(own.verdict, found.delays[0].question),
            )
            for own in tier_bounds(found.delays[0].verdicts)
        ]
        headings = ("network", "rule", "k, N/m", "axis", "yours")
        return fitting_table(TABLE_TITLE, headings, rows, right=(2,), optional=(1,))
    beside = hand_rows(found.free.delays[0].verdicts, found.delays[0].verdicts)
    columns = ("network", "free, N/m", "held, N/m", "a hand")
    return fitting_table(TABLE_TITLE, columns, beside, right=(1, 2))


def _delay_tables(found: Limits) -> list[RenderableType]:
    """List what each delay allows; free and held handles side by side, without and with a buffer, too."""
    varies = found.delays[0].varying is not None
    if found.free is None:
        return [_delay_table(found)]
    if not varies or found.has_playout_buffer or not found.delays[0].question.is_as_stated:
        return [_hand_table(found.free, found, "", is_buffered=True)]
    return [
        _hand_table(found.free, found, "Without a playout buffer", is_buffered=False),
        _hand_table(found.free, found, "With a playout buffer", is_buffered=True),
    ]


def _usable_of(row: DelayLimits, *, is_buffered: bool) -> float:
    if row.question.unjudged:
        return 0.0
    is_buffered = is_buffered and row.question.is_as_stated
    return row.usable_stiffness if is_buffered or row.varying is None else row.varying.usable_stiffness


def _usable_cell(usable: float) -> str:
    """Write up to where a stiffness may be used, in a table."""
    if usable >= STIFFEST_USUAL:
        return f"any up to {format_number(STIFFEST_USUAL)}"
    return format_number(recommended_stiffness(usable), rounding="down")


def _hand_table(free: Limits, held: Limits, title: str, *, is_buffered: bool) -> Fitting:
    rows: list[tuple[str, ...]] = []
    for one, other in zip(free.delays, held.delays, strict=True):
        usable = [_usable_of(row, is_buffered=is_buffered) for row in (one, other)]
        rows.append(
            (
                delay_clause(other.delay),
                *map(_usable_cell, usable),
                hand_effect(*usable),
            )
        )
    names = ("delay\neach way", "free handles\nN/m", "held\nN/m", "a hand")
    return fitting_table(title, names, rows, right=(0, 1, 2))


def _delay_table(found: Limits) -> Fitting:
    first = found.delays[0]
    varies = first.varying is not None and not found.has_playout_buffer
    has_choice = varies and first.question.is_as_stated
    rows: list[tuple[str, ...]] = []
    for row in found.delays:
        usable = _usable_cell(_usable_of(row, is_buffered=True))
        limit = row.stiffness_limit if row.varying is None or not varies else row.varying.stiffness_limit
        cells = [usable, format_stiffness(limit).removesuffix(" N/m")]
        if has_choice:
            cells = [_usable_cell(_usable_of(row, is_buffered=False)), usable]
        tiers = (row.verdicts.tier("any constant delay"), row.verdicts.tier("any network"))
        for tier in tiers:
            allowed = allowed_stiffness(tier.stiffness_bound, tier.attained, tier.unavailable)
            cells.append(allowed.removeprefix("below ").removeprefix("up to "))
        rows.append((delay_clause(row.delay), *cells))
    own = ("no buffer\nN/m", "with buffer\nN/m") if has_choice else ("you may use\nN/m", "limit\nN/m")
    headings = ("delay\neach way", *own, "any constant\ndelay, N/m", "any network\nN/m")
    return fitting_table("", headings, rows, right=(0, 1, 2, 3, 4), optional=(3,))
