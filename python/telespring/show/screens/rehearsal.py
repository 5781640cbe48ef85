"""What `telespring rehearse` prints: warnings, progress, and how the trials ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.text import Text

from telespring._core import Architecture
from telespring.rehearsal.preflight import (
    JitterWarning,
    LateWarning,
    LossWarning,
    PreflightWarning,
    TraceWarning,
)
from telespring.show.quantities import format_time
from telespring.show.screens.arms import describe_arm_stability, describe_arm_verdict
from telespring.show.strategies import describe_strategy, name_strategy

if TYPE_CHECKING:
    from telespring.decision.arm_stability import ArmStability
    from telespring.rehearsal import RehearsalOutcome
    from telespring.rehearsal.summary import ConditionSummary, RehearsalSummary

__all__ = [
    "preflight_screen",
    "preflight_sentence",
    "rehearsal_outcome_screen",
    "rehearsal_progress_bar",
    "rehearsal_resume_sentence",
    "rehearsed_conditions_screen",
]


def preflight_sentence(warning: PreflightWarning) -> str:
    """Put a warning before a rehearsal into words.

    Examples
    --------
    >>> from telespring.rehearsal.preflight import LossWarning
    >>> preflight_sentence(LossWarning())
    'network.loss = 1: no packet ever arrives: each spring pulls to where the partner began.'
    """
    if isinstance(warning, JitterWarning):
        return (
            f"network.jitter = {warning.jitter:g} s is no shorter than a trial of "
            f"{warning.duration:g} s: most packets arrive after its end."
        )
    if isinstance(warning, LossWarning):
        return "network.loss = 1: no packet ever arrives: each spring pulls to where the partner began."
    if isinstance(warning, LateWarning):
        return (
            f"session.playout delay = {warning.playout:g} s is shorter than a delay of {warning.delay:g} s "
            "of the network: over it every motion comes after its time, and the latest one is held."
        )
    if isinstance(warning, TraceWarning):
        delays = ", ".join(format_time(delay, 3) for delay in warning.delays)
        what = (
            "say only when a motion is played"
            if warning.use == "play-out"
            else "change nothing, because session.playout has its own"
        )
        return f"network.trace: the recorded trace has delays of its own; the conditions' ({delays}) {what}."
    is_far = warning.limit == "farthest"
    limit, past = ("full reach", "beyond") if is_far else ("shortest reach", "inside")
    room = 1e3 * warning.room
    course = f"comes within {room:.0f} mm of" if room >= 0.0 else f"goes {-room:.0f} mm {past}"
    x, y = (f"{1e3 * coordinate + 0.0:.0f}" for coordinate in warning.position)
    reach = f"{limit} of {1e3 * warning.reach:.0f} mm"
    return (
        f"arm{warning.arm}: the target {course} its {reach}, at ({x}, {y}) mm. "
        f"If the hand is pushed farther, the trial ends as out of reach."
    )


def preflight_screen(console: Console, warnings: Iterable[PreflightWarning]) -> None:
    """Print the warnings before a rehearsal."""
    for warning in warnings:
        console.print(Text.assemble(("Warning: ", "yellow"), preflight_sentence(warning)))


@contextmanager
def rehearsal_progress_bar(console: Console, things: str = "trials") -> Iterator[Callable[[int, int], None]]:
    """Show a bar of finished things; the block calls what it receives with their number and that of all."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    with Progress(
        TextColumn(things),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    ) as bar:
        task = bar.add_task(things, total=None)
        yield lambda finished, trials: bar.update(task, completed=finished, total=trials)


def rehearsal_resume_sentence(finished: int, trials: int, things: str = "trials") -> str:
    """State what an interrupted rehearsal has kept."""
    if not finished:
        return f"No {things[:-1]} is finished yet."
    return f"{finished} of {trials} {things} are kept; run the same command again to resume."


def rehearsal_outcome_screen(
    console: Console, outcome: RehearsalOutcome, summary: RehearsalSummary, seconds: float
) -> None:
    """Print the size of a rehearsal, how long it took (s), and how many trials ended early."""
    console.print(f"[bold]{escape(summary.name)}[/bold]")
    count = len(summary.conditions)
    size = f"{count} conditions × {outcome.trials // count} trials of {summary.duration:.4g} s"
    if outcome.resumed == outcome.trials:
        console.print(f"{size}, already complete", markup=False)
    else:
        resumed = f", {outcome.resumed} kept from before" if outcome.resumed else ""
        console.print(
            f"{size}; {outcome.trials - outcome.resumed} run in {seconds:.1f} s{resumed}", markup=False
        )
    for status, ended in summary.count_early_ends().items():
        console.print(f"  {ended} of {outcome.trials} ended early: {status}", markup=False)


def rehearsed_conditions_screen(
    console: Console, summary: RehearsalSummary, stability: ArmStability, session: Architecture
) -> None:
    """Print for each condition whether it is stable with the study's arms, and how its trials ended.

    Where the study's session is not the bare spring, the verdict is that of the bare spring all the same; the
    screen says so, and how often the strategy changed the spring's force.
    """
    from rich.table import Table

    is_bare = session == Architecture()
    table = Table(box=None, pad_edge=False)
    table.add_column("condition", no_wrap=True)
    table.add_column("with arms" if is_bare else "bare spring with arms")
    if not is_bare:
        table.add_column("limited", justify="right", no_wrap=True)
    table.add_column("completed", justify="right", no_wrap=True)
    table.add_column("ended early", no_wrap=True)
    verdicts = iter(stability.conditions)
    for condition in summary.conditions:
        statement, style = "–", ""
        if condition.condition.stiffness is not None:
            statement = "unknown"
            if stability.unavailable is None:
                verdict = next(verdicts)
                is_spotless = verdict.stable or not is_bare
                statement, style = describe_arm_verdict(verdict), "" if is_spotless else "red"
        limited = condition.limited_share
        limited_text = "–" if limited is None else f"{100.0 * limited:.2g} %"
        table.add_row(
            condition.label,
            Text(statement, style=style),
            *([] if is_bare else [limited_text]),
            str(condition.completed),
            _format_early_ends(condition) or "–",
        )
    console.print(table)
    console.print(f"With arms: {describe_arm_stability(stability)}", markup=False)
    if not is_bare:
        console.print(
            f"This study runs {name_strategy(session.label)}: {describe_strategy(session)}. "
            "Limited: the share of the time in which it changed the spring's force.",
            markup=False,
        )


def _format_early_ends(condition: ConditionSummary) -> str:
    reasons = []
    for ends in condition.early_ends:
        arm = f" of arm {ends.arm}" if ends.arm else ""
        reasons.append(f"{ends.count} {ends.status}{arm}, the first at {ends.first:.3g} s")
    return "; ".join(reasons)
