"""What to change to be stable with the reserve, or on more networks."""

from __future__ import annotations

from rich.padding import Padding
from rich.text import Text

from telespring._core import LEAST_PROBABILITY
from telespring.decision.changes import WIDER_TIERS, Changes
from telespring.decision.decide import Decision
from telespring.show.quantities import format_number, format_stiffness, format_time
from telespring.show.screens.questions import delay_clause, given_delay

__all__ = ["suggested_changes"]


def suggested_changes(decision: Decision) -> Padding:
    """List the changes that make an answer STABLE, or what is stable on more networks."""
    if decision.question.unjudged:
        title = "What to change is not known: not all of the study is judged."
        return Padding(Text(title, style="bold"), (1, 0, 0, 0))
    if decision.changes is not None:
        title, lines = _changes(decision, decision.changes)
    elif decision.axes_independent is False:
        title, lines = "What to change is not known: the verdicts hold for independent axes only.", []
    else:
        network = "network" if _is_varying(decision) else "constant delay"
        title, lines = (
            f"To guarantee stability beyond this {network}, with the reserve: ",
            _guarantees(decision),
        )
    if decision.arms is not None:
        lines.append("(the study's arms and agents are not counted)")
    return Padding(Text.assemble((title, "bold"), *(f"\n  {line}" for line in lines)), (1, 0, 0, 0))


def _is_varying(decision: Decision) -> bool:
    return decision.varying is not None and not decision.has_playout_buffer


def _changes(decision: Decision, changes: Changes) -> tuple[str, list[str]]:
    lines = []
    if changes.varying_stiffness is not None:
        lines.append(f"a stiffness of up to {format_stiffness(changes.varying_stiffness)}")
    single = _at_a_constant_delay(decision, changes)
    if _is_varying(decision):
        buffer = f"a playout buffer of {delay_clause(decision.constant_delay)} (then say --playout-buffer)"
        single = [buffer] if changes.is_buffer_enough else [f"a playout buffer and {line}" for line in single]
    lines += single
    if _is_improbable(decision):
        lines.append("robots identified from more logs, if their errors become smaller")
    missing = _missing(decision, changes)
    whose = "" if decision.free is None else ", free and held"
    if not lines:
        title = f"No single change was found that makes it stable with the reserve{whose}:"
        return title, missing
    title = f"To be stable with the reserve{whose}, one of: "
    return title, lines + ([f"({', '.join(missing)})"] if missing else [])


def _at_a_constant_delay(decision: Decision, changes: Changes) -> list[str]:
    lines = []
    if changes.stiffness is not None:
        lines.append(f"a stiffness of up to {format_stiffness(changes.stiffness)}")
    if changes.delay is not None:
        more = ", jitter and gaps on top of it" if decision.buffered else ""
        lines.append(f"a delay of up to {given_delay(changes.delay)}{more}")
    if changes.added_damping is not None:
        added = format_number(changes.added_damping, rounding="up")
        lines.append(f"at least {added} N·s/m of damping added to each robot")
    if changes.sample_period is not None:
        lines.append(f"a sample period of {format_time(changes.sample_period)}")
    return lines


def _missing(decision: Decision, changes: Changes) -> list[str]:
    """Say which kinds of change do not help."""
    if changes.is_buffer_enough:
        return []
    if _is_varying(decision) and not decision.is_as_stated:
        # Only the stiffness was tried.
        return [] if changes.varying_stiffness is not None else ["no stiffness is low enough"]
    missing = []
    if changes.stiffness is None and changes.varying_stiffness is None:
        missing.append("no stiffness is low enough")
    if changes.delay is None and sum(decision.delay) > 0.0:
        missing.append("no delay is short enough")
    if changes.added_damping is None:
        missing.append("no damping is known to be enough")
    return missing


def _is_improbable(decision: Decision) -> bool:
    known = [each.uncertainty for each in (decision, decision.free) if each is not None]
    return any(each is not None and each.stable.value < LEAST_PROBABILITY for each in known) and all(
        each.keeps_stiffness_reserve and each.keeps_delay_reserve
        for each in (decision, decision.free)
        if each is not None
    )


def _ages_clause(decision: Decision) -> str:
    ages = decision.verdicts.tier("age in a range").ages
    if ages is None:
        return "as stated"
    low, high = min(least for least, _ in ages), max(most for _, most in ages)
    return f"between {format_time(low, 6)} and {format_time(high, 6)}"


def _guarantees(decision: Decision) -> list[str]:
    answers = [each.verdicts for each in (decision, decision.free) if each is not None]
    if all(each.tier("any network").satisfied for each in answers):
        return ["nothing to change"]
    oldest = max(budget.total for budget in decision.verdicts.delay_budget)
    promises = {
        "any constant delay": "under any constant delay",
        "age in a range": f"while every sample's age stays {_ages_clause(decision)} and none is overtaken",
        "bounded varying delay": f"while no sample is older than {format_time(oldest, 6)}",
        "any network": "on any network",
    }
    if decision.verdicts.network.is_constant:
        # Only the hold of a sample varies its age: the network is the same.
        del promises["age in a range"]
    if decision.sampled_stable is not None:
        # No rule says it of controllers that sample.
        del promises["any constant delay"]
    given = {found.tier: found for found in decision.guarantees}
    lines = []
    for verdicts in zip(*(reversed(each.tiers) for each in answers), strict=True):
        promise, found = promises.get(verdicts[0].tier), given.get(verdicts[0].tier)
        if promise is None or all(each.satisfied and each.assumption_met for each in verdicts):
            continue
        if any(each.unavailable == "not proven over the range" for each in verdicts):
            lines.append(f"no stiffness is proven {promise} for the whole range")
        elif found is not None and found.is_proven_now:
            lines.append(f"a playout buffer, to be stable {promise}")
        elif found is not None:
            buffer = " behind a playout buffer" if found.needs_buffer else ""
            lines.append(f"a stiffness of up to {format_stiffness(found.stiffness)} {promise}{buffer}")
        elif all(each.stiffness_bound is not None for each in verdicts) and not any(
            tier in given for tier in WIDER_TIERS.get(verdicts[0].tier, ())
        ):
            lines.append(f"no stiffness is low enough {promise}")
    return lines or ["nothing to change"]
