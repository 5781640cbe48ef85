"""What a probe has found, as one screen of text."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.text import Text

from telespring.show.quantities import format_count, format_time
from telespring.show.screens.layout import fitting_table
from telespring.show.screens.questions import describe_robots
from telespring.show.screens.trace import judgement

if TYPE_CHECKING:
    from telespring.traces import TraceAssessment

__all__ = ["probe_screen"]

_WAYS = (("towards_partner", "to the partner"), ("towards_here", "from the partner"))


def probe_screen(
    found: Mapping[str, Any],
    assessment: TraceAssessment | str,
    trace: Path | None,
    out_study: Path | None,
) -> RenderableType:
    """Lay out what was measured of both ways, and what the path allows or why nothing can be said."""
    parts: list[RenderableType] = [_ways_table(found), *_sentences(found)]
    if isinstance(assessment, str):
        parts.append(Text(assessment, style="yellow"))
    else:
        question = assessment.question
        parts += judgement(assessment, describe_robots(question.dyad, (None, None), question.robot_springs))
    if trace is not None and not isinstance(assessment, str):
        parts.append(Text(f"Saved: {trace}. More of it: telespring trace {trace}"))
    if out_study is not None and not isinstance(assessment, str):
        parts.append(Text(f"Written: {out_study}. Next: telespring decide {out_study}"))
    return Group(*parts)


def _ways_table(found: Mapping[str, Any]) -> RenderableType:
    rows = []
    for key, name in _WAYS:
        way = found.get(key)
        if way is None:
            rows.append((name, *("not known" for _ in range(7))))
            continue
        age = way["age"]
        ages = [_time(age[of]) for of in ("median", "quantile_99", "largest")] if age else ["–"] * 3
        silences = str(way["silences"])
        lost, longest = f"{100 * way['lost_share']:.3g} %", str(way["bursts"]["longest"])
        rows.append((name, *ages, _time(way["jitter"]), lost, longest, silences))
    headings = (
        "Way",
        "median",
        "99 %",
        "longest",
        "jitter",
        "lost",
        "longest\nin a row",
        "silences of\n150 ms",
    )
    packets = format_count(round(found["rate"] * found["seconds"]), "packet")
    title = f"{packets} each way in {format_time(found['seconds'], 3)}"
    return fitting_table(title, headings, rows, right=range(1, len(headings)))


def _sentences(found: Mapping[str, Any]) -> list[Text]:
    lines = []
    trip = found.get("round_trip")
    if trip is not None:
        lines.append(
            f"Round trip: median {_time(trip['median'])}, 99 % {_time(trip['quantile_99'])}, "
            f"longest {_time(trip['largest'])}."
        )
    error = found.get("clock_error")
    if error is not None:
        lines.append(
            f"The two ways can be told apart to {_time(error)} only: no clock is common to both sites."
        )
    lines += [f"After {_time(max(change['time'], 0.0))}: {change['event']}." for change in found["paths"]]
    if found.get("end") != "complete":
        lines.append(f"The probe did not run to its end: {found.get('end')}.")
    return [Text(line) for line in lines]


def _time(seconds: float | None) -> str:
    return "–" if seconds is None else format_time(seconds, 3)
