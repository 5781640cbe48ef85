"""What a recorded trace of a network allows, as one screen of text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.text import Text

from telespring._core import RESERVE
from telespring.show.quantities import format_count, format_number, format_stiffness, format_time
from telespring.show.screens.layout import fitting_table
from telespring.traces.playouts import MOSTLY

if TYPE_CHECKING:
    from telespring._types import Tier
    from telespring.traces import MissingRows, PlayoutChoice, RecordedWay, TraceAssessment, TraceEvidence
    from telespring.traces.reading import TraceRecording
    from telespring.traces.silences import Silences

__all__ = ["judgement", "study_lines", "taken_delays", "trace_screen", "written_lines"]

#: The columns of the tiers, the weakest first, and their headings.
_TIERS: tuple[tuple[Tier, str], ...] = (
    ("any network", "any\nnetwork"),
    ("bounded varying delay", "bounded\ndelay"),
    ("age in a range", "age in\na range"),
    ("constant delay", "constant\ndelay"),
)
#: Above it successive delays are not independent, as the emulator's are.
_CORRELATED = 0.1
_TWO_AXES = "# to rehearse it, give robots with two axes, such as --robot 1.2,6/1.4,7"
_SHARES = (0.9, 0.99, 0.999)
_WAYS = ("forward", "backward")
_KINDS = {"uniform": "uniform", "normal": "normal", "gamma": "gamma", "lognormal": "log-normal"}
_REASONS = {
    "constant delay": "All of the time is in time: the delay is constant.",
    "age in a range": "What comes late or not at all leaves the ages in a range.",
    "bounded varying delay": "What comes late or not at all leaves a bound on the ages.",
    "any network": "This stiffness is stable on any network.",
}


def trace_screen(
    found: TraceAssessment, name: str, taken: str, robots: Sequence[str], lines: Sequence[str]
) -> RenderableType:
    """Lay an assessment out for the terminal: what was recorded, what fits, what it allows.

    `name` is that of the file, `taken` says what its delays are, `robots` describe the robots, and `lines`
    are those for a study.
    """
    parts: list[RenderableType] = [Text(f"{name}: {taken}", style="bold")]
    for way, label in zip(found.ways, _WAYS, strict=False):
        parts += _recorded(way, label if len(found.ways) > 1 else "")
    parts += judgement(found, robots)
    parts.append(Text("\n".join(lines)))
    return Group(*parts)


def judgement(found: TraceAssessment, robots: Sequence[str]) -> list[RenderableType]:
    """Lay out what each play-out proves, and what to use."""
    return [_playout_table(found, robots), *_recommendation(found)]


def _recorded(way: RecordedWay, label: str) -> list[RenderableType]:
    """Say what was recorded of one way, and which models fit."""
    shown = way.statistics
    before = f"{label.capitalize()}: " if label else ""
    quantiles = ", ".join(f"{100 * share:g} % {_ms(way.trace.quantile(share))}" for share in _SHARES)
    in_a_row = f", {format_number(shown.burst_length, 2)} in a row" if shown.loss else ""
    recorded = f"{format_count(shown.sent, 'packet')} in {format_time(way.trace.duration, 3)}"
    lost = f"{_percent(shown.loss)} lost{in_a_row}; {_percent(shown.reordered)} reordered"
    lines = [f"{before}{recorded}, every {_ms(shown.interval)}; {lost}."]
    if way.missing is not None:
        lines.append(_missing(way.missing))
    lines.append(f"Delay: median {_ms(shown.median)}, {quantiles}, longest {_ms(shown.maximum)}.")
    lines += [*_silences(way.silences), *_fits(way)]
    return [*(Text(line) for line in lines), *(Text(line, style="yellow") for line in _doubts(way.evidence))]


def _doubts(evidence: TraceEvidence) -> list[str]:
    """Say what the recording cannot show."""
    rarest = format_number(1.0 / evidence.missed_share, 2, rounding="down")
    every = format_time(evidence.missed_every, 2)
    what = ": record longer" if "short" in evidence.doubts else ""
    lines = [f"It may miss an outage every {every}, or 1 packet in {rarest} (risk 5 %){what}."]
    if "slow" in evidence.doubts:
        lines.append("Slow: what happens between two packets is unknown. Record as often as you will send.")
    if "delays below 1 ms" in evidence.doubts:
        lines.append("All delays are below 1 ms. If the column is in s, name it delay_s.")
    return lines


def _silences(silences: Silences) -> list[str]:
    """Say how often a live session has no force, because nothing comes."""
    if not silences.count:
        return []
    times = "once" if silences.count == 1 else f"{silences.count} times"
    longest = f"{format_time(silences.longest, 3)} at the longest"
    share = f"then a live session has no force, {_percent(silences.share)} of the time"
    return [
        f"Nothing comes for {_ms(silences.limit)} or more {times}, {longest}: {share}.",
        "With a longer safety.silence the guard holds on to the last position instead.",
    ]


def _missing(missing: MissingRows) -> str:
    """Say how missing rows were understood."""
    parts = []
    if missing.lost:
        verb = "is a loss" if missing.lost == 1 else "are losses"
        parts.append(f"{format_count(missing.lost, 'missing row')} {verb}")
    if missing.pauses:
        verb = "" if missing.lost else "is " if missing.pauses == 1 else "are "
        steps = f"{format_count(missing.pauses, 'step')} of up to {format_time(missing.longest_pause, 3)}"
        parts.append(f"{steps} {verb}{'a pause' if missing.pauses == 1 else 'pauses'}")
    return f"{', '.join(parts)} (--longest-loss)."


def _fits(way: RecordedWay) -> list[str]:
    """Describe the fits, and how far successive delays are independent."""
    fit, shown = way.fit, way.statistics
    lines = []
    if fit.jitter:
        best = fit.jitter[0]
        distances = ", ".join(f"{_KINDS[each.kind]} {each.distance:.3f}" for each in fit.jitter)
        moments = (
            "" if best.mean is None or best.sd is None else f", mean {_ms(best.mean)}, sd {_ms(best.sd)}"
        )
        lines.append(f"Fits (distance): {distances}.")
        lines.append(
            f"Likeliest: {_ms(best.delay)} + {_KINDS[best.kind]} jitter up to {_ms(best.jitter)}{moments}."
        )
    else:
        lines.append(f"Fit: a constant delay of {_ms(fit.minimum)}, exactly.")
    if fit.burst is not None:
        lines.append(
            f"Bursts: to_bad = {format_number(fit.burst.to_bad, 3)}, to_good = "
            f"{format_number(fit.burst.to_good, 3)} per packet of {_ms(shown.interval)}; distance "
            f"{fit.burst.distance:.3f}."
        )
    if fit.jitter and shown.autocorrelation > _CORRELATED:
        lines.append(
            f"Successive delays are correlated ({shown.autocorrelation:.2f}): "
            "do not rehearse a fit, play the trace."
        )
    return lines


def _playout_table(found: TraceAssessment, robots: Sequence[str]) -> RenderableType:
    """List the play-outs with the largest stiffness that each tier proves."""
    shown = [
        (tier, heading) for tier, heading in _TIERS if any(tier in choice.bounds for choice in found.playouts)
    ]
    is_mostly_shown = any(choice.mostly_ages != choice.ages for choice in found.playouts)
    rows = [
        (
            Text(_ms(choice.delay), style="bold" if choice is found.recommended else ""),
            f"{100 * choice.share:g} %",
            _percent(choice.in_time, down=True),
            _ages(choice),
            *(_bound(choice, tier) for tier, _ in shown),
            *((_stiffness(choice.mostly_usable_stiffness),) if is_mostly_shown else ()),
        )
        for choice in found.playouts
    ]
    headings = (
        "Play-\nout",
        "packets\nawaited",
        "time\nin time",
        "ages as\nplayed, ms",
        *(heading for _, heading in shown),
        *((f"{100 * MOSTLY:g} % of\nthe time",) if is_mostly_shown else ()),
    )
    title = f"{'; '.join(robots)}: proven up to, N/m"
    return fitting_table(title, headings, rows, right=range(len(headings)))


def _recommendation(found: TraceAssessment) -> list[Text]:
    """Name the play-out and the stiffness to use, and why."""
    best, guarded = found.recommended, found.guarded
    reserve = f"{100 * RESERVE:.0f} % in reserve"
    stiffness = format_stiffness(best.recommended_stiffness)
    if found.needs_guard:
        oldest = max(age for _, age in best.ages)
        bare = f"{stiffness} ({reserve})" if best.recommended_stiffness else "nothing"
        reach = format_stiffness(found.guard_stiffness)
        answer = f"play-out {_ms(best.delay)}, with the guard, at any stiffness up to {reach}."
        if found.has_lag:
            why = "Forces lag (laboratory.actuator_lag): no limit of a bare spring counts that."
        else:
            why = (
                f"Motions up to {_ms(oldest)} old were in use: only what holds on any network is proven for "
                f"a bare spring, {bare}."
            )
        if guarded.mostly_usable_stiffness > best.usable_stiffness and not found.has_lag:
            why += (
                f" {100 * MOSTLY:g} % of the time {format_stiffness(guarded.mostly_usable_stiffness)} is "
                "stable without the guard."
            )
    else:
        answer = f"play-out {_ms(best.delay)}, spring up to {stiffness} ({reserve})."
        why = f"{_REASONS[best.tier or '']} It holds while the network is no worse than recorded."
        if guarded.mostly_usable_stiffness > best.usable_stiffness:
            why += (
                f" With the guard: play-out {_ms(guarded.delay)}, for {100 * MOSTLY:g} % of the time up to "
                f"{format_stiffness(guarded.mostly_usable_stiffness)}."
            )
    parts = [Text.assemble(("Recommended: ", "bold"), answer), Text(why)]
    if found.if_paused is not None:
        other = found.if_paused
        parts.append(
            Text(
                f"If no packet without a row was lost: play-out {_ms(other.delay)}, up to "
                f"{format_stiffness(other.recommended_stiffness)}."
            )
        )
    if found.axes_independent is False:
        parts.append(Text("The axes of a robot are not independent: the limits hold axis by axis only."))
    return parts


def taken_delays(recording: TraceRecording) -> str:
    """Say which delays of a file were taken."""
    if recording.is_halved:
        return "half of each round trip, for both ways"
    if isinstance(recording.traces, tuple):
        return "both ways"
    return "delays as recorded, for both ways (--round-trip halves them)"


def written_lines(study: str, *, can_rehearse: bool) -> list[str]:
    """Say where the whole study is, and which commands take it."""
    commands = ["decide", "rehearse"] if can_rehearse else ["decide"]
    lines = [f"Study: {study}", *(f"  telespring {command} {study}" for command in commands)]
    return lines if can_rehearse else [*lines, _TWO_AXES]


def study_lines(settings: dict[str, Any], *, is_completed: bool, can_rehearse: bool) -> list[str]:
    """Return the lines of a study's sections; a completed trace is not the one in the file."""
    lines = []
    for section, values in settings.items():
        if not isinstance(values, dict):
            lines.append(f"{section} = {_toml(values)}  # at the top of the study")
            continue
        lines.append(f"[{section}]")
        lines += [f"{key} = {_toml(value)}" for key, value in values.items()]
    if not can_rehearse:
        lines.append(_TWO_AXES)
    elif is_completed:
        lines.append("# the ages as played; the lost packets have no rows in the file: --out TRACE.csv")
    lines.append("# a whole study, with robots: --out-study STUDY.toml")
    return lines


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(each)}" for key, each in value.items()) + "}"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _ages(choice: PlayoutChoice) -> str:
    low = min(low for low, _ in choice.ages)
    high = max(high for _, high in choice.ages)
    first, last = (
        format_number(low, 3, rounding="down", shift=3),
        format_number(high, 3, rounding="up", shift=3),
    )
    return first if math.isclose(low, high) else f"{first}–{last}"


def _bound(choice: PlayoutChoice, tier: Tier) -> str:
    if tier not in choice.bounds:
        return "–"
    bound = choice.bounds[tier]
    if bound is None:
        return "no rule"
    return _stiffness(bound)


def _stiffness(value: float) -> str:
    return "no limit" if math.isinf(value) else format_number(value, rounding="down")


def _ms(time: float) -> str:
    return format_time(time, 3)


def _percent(share: float, *, down: bool = False) -> str:
    return f"{format_number(100.0 * share, 3, rounding='down' if down else 'nearest')} %"
