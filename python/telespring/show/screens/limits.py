"""What a dyad may use, as one screen of text."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.text import Text

from telespring.decision.limits import DelayLimits, Limits, StiffnessLimits
from telespring.decision.reserve import LEAST_PROBABILITY, RESERVE
from telespring.show.quantities import format_stiffness, format_time
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
from telespring.show.tiers import TIERS

__all__ = ["limits_screen"]

_RESERVE = f"{100 * RESERVE:.0f} % of stiffness and of delay in reserve"
_PROBABLY = f", and with a probability of at least {100 * LEAST_PROBABILITY:.0f} %"


def limits_screen(found: Limits, title: str, held: str = "held", notes: Sequence[str] = ()) -> RenderableType:
    """Lay limits out for the terminal: what may be used, then what each kind of network allows."""
    period = found.delays[0].verdicts.network.sample_period
    lines = [title]
    if found.is_delay_given:
        lines.append(f"{given_delay(found.delays[0].delay)}, {sampling_clause(period)}")
    else:
        lines.append(f"No delay is given; {sampling_clause(period)}")
    heading = Text("\n".join(lines), style="bold")
    for note in notes:
        heading.append(f"\n{note}", style="not bold")
    parts: list[RenderableType] = [heading]
    parts.append(Padding(Group(*_usable(found, held)), (0, 0, 1, 0)))
    if found.is_delay_given:
        parts.append(_tier_table(found))
        parts.append(Text("Give --stiffness to judge one stiffness, with its margins and what to change."))
    else:
        parts.append(_delay_table(found))
        parts.append(Text("Give --delay or --ping for your own network."))
    if period > 0.0:
        parts.append(Text(CONTINUOUS_TIERS))
        if found.is_delay_given:
            parts.append(Text(sampling_note(found.delays[0].verdicts)))
    if found.over_operator_ranges:
        parts.append(Text("Every limit is the worst over the ranges of operators."))
    return Group(*parts)


def _usable(found: Limits, held: str) -> list[Text]:
    cases = [(f"Handles {held}: ", found)]
    cases = [("", found)] if found.free is None else [("Free handles: ", found.free), *cases]
    lines = []
    for name, case in cases:
        if case.is_delay_given and case.stiffness is None:
            lines.append(Text.assemble((name, "bold"), _usable_stiffness(case.delays[0], _kept(case))))
        if case.stiffness is not None:
            lines.append(Text.assemble((name, "bold"), _usable_delay(case.stiffness, _kept(case))))
    if not lines:
        lines.append(Text(f"What each delay allows, with {_kept(found)}:"))
    return lines


def _kept(found: Limits) -> str:
    """Say what is kept in reserve; where robots have errors, stability must be probable, too."""
    return _RESERVE + (_PROBABLY if found.robots_have_errors else "")


def _usable_stiffness(row: DelayLimits, kept: str) -> Text:
    where = "at this constant delay"
    if row.buffered:
        delay = given_delay(row.constant_delay).removesuffix(" each way")
        where = f"at a constant delay of {delay} (behind a playout buffer)"
    if math.isinf(row.usable_stiffness):
        return Text.assemble(("You may use any stiffness", "bold green"), f" {where}.")
    if row.soft_springs_fail_by_sampling:
        why = (
            "even a soft spring is unstable, because a held force feeds more into the motion than the "
            "damping takes. A stiffer spring may be stable; give --stiffness."
        )
        return Text.assemble(("No stiffness is low enough", "bold red"), f" {where}: {why}")
    if row.stiffness_limit == 0.0:
        return Text.assemble(("No stiffness is stable", "bold red"), f" {where}, however soft the spring.")
    if row.usable_stiffness == 0.0:
        return Text.assemble(
            ("No stiffness is safe", "bold red"),
            f" {where} with {kept}. The limit itself is {format_stiffness(row.stiffness_limit)}.",
        )
    return Text.assemble(
        (f"You may use up to {format_stiffness(row.usable_stiffness)}", "bold green"),
        f" {where}, with {kept}. The limit itself is {format_stiffness(row.stiffness_limit)}.",
    )


def _usable_delay(row: StiffnessLimits, kept: str) -> Text:
    if math.isinf(row.usable_delay):
        return Text.assemble(
            ("Any constant delay", "bold green"), " is stable at this stiffness, however long."
        )
    if row.usable_delay <= 0.0:
        return Text.assemble(("No delay", "bold red"), f" is stable at this stiffness with {kept}.")
    return Text.assemble(
        (f"The delay may be up to {format_time(row.usable_delay, rounding='down')} each way", "bold green"),
        f" at {format_stiffness(row.stiffness)}, with {kept}. The limit itself is "
        f"{format_time(row.delay_limit, rounding='down')}.",
    )


def _tier_table(found: Limits) -> Fitting:
    bounds = tier_bounds(found.delays[0].verdicts)
    if found.free is None:
        rows: list[tuple[str, ...]] = [
            (
                own.verdict.tier,
                TIERS[own.verdict.tier].formula,
                allowed_stiffness(own.bound, own.attained),
                own.axis,
            )
            for own in bounds
        ]
        headings = ("network", "rule", "k, N/m", "axis")
        return fitting_table("How stiff can the spring be?", headings, rows, right=(2,))
    rows = [
        (
            own.verdict.tier,
            allowed_stiffness(free.bound, free.attained),
            allowed_stiffness(own.bound, own.attained),
            hand_effect(free.bound, own.bound),
        )
        for own, free in zip(bounds, tier_bounds(found.free.delays[0].verdicts), strict=True)
    ]
    headings = ("network", "free handles", "held", "a hand")
    return fitting_table("How stiff can the spring be, N/m?", headings, rows, right=(1, 2))


def _delay_table(found: Limits) -> Fitting:
    if found.free is None:
        rows: list[tuple[str, ...]] = [
            (
                given_delay(row.delay).removesuffix(" each way"),
                format_stiffness(row.usable_stiffness).removesuffix(" N/m"),
                format_stiffness(row.stiffness_limit).removesuffix(" N/m"),
                *(
                    allowed_stiffness(tier.stiffness_bound, tier.attained).split(" ")[-1]
                    for tier in (row.verdicts.tier("any constant delay"), row.verdicts.tier("any network"))
                ),
            )
            for row in found.delays
        ]
        headings = (
            "delay\neach way",
            "you may use\nN/m",
            "limit\nN/m",
            "any constant\ndelay, N/m",
            "any network\nN/m",
        )
        return fitting_table("", headings, rows, right=(0, 1, 2, 3, 4))
    pairs = zip(found.free.delays, found.delays, strict=True)
    beside = [
        (
            given_delay(row.delay).removesuffix(" each way"),
            format_stiffness(free.usable_stiffness).removesuffix(" N/m"),
            format_stiffness(row.usable_stiffness).removesuffix(" N/m"),
            hand_effect(free.usable_stiffness, row.usable_stiffness),
        )
        for free, row in pairs
    ]
    names = ("delay\neach way", "free handles\nN/m", "held\nN/m", "a hand")
    return fitting_table("", names, beside, right=(0, 1, 2))
