"""What `telespring sweep` prints: how the points and trials came out, by the values of each key."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.text import Text

from telespring.show.quantities import format_number
from telespring.show.screens.layout import fitting_table
from telespring.sweeps.summary import SweepRow, SweepSummary

__all__ = ["sweep_screen"]

#: No more values of a key are shown; all are in the dataset.
_MOST_VALUES = 12
_UNKNOWN = "–"


def sweep_screen(summary: SweepSummary, seconds: float | None) -> RenderableType:
    """Lay a sweep out for the terminal; `seconds` is how long it took, None if it was complete already."""
    whole = summary.whole
    took = "already complete" if seconds is None else f"in {seconds:.1f} s"
    trials = f", {whole.trials} trials" if whole.trials else ""
    parts: list[RenderableType] = [
        Text(summary.name, style="bold"),
        Text(f"{summary.points} points{trials}, {took}"),
    ]
    if whole.stable_share is not None:
        share = _percent(whole.stable_share)
        parts.append(Text(f"The bare spring is stable at {share} of the points' conditions."))
    if whole.guard_broken is not None:
        parts.append(_guard_line(whole))
    for key, rows in summary.keys.items():
        if len(rows) > 1:
            parts += [Text(""), _table(key, rows)]
    return Group(*parts)


def _guard_line(whole: SweepRow) -> Text:
    if not whole.guard_broken:
        return Text("The guards kept their law in every completed trial.")
    return Text(
        f"The guards gave out more than their law allows in {whole.guard_broken} trials; see guard_spare.",
        style="red",
    )


def _table(key: str, rows: tuple[SweepRow, ...]) -> RenderableType:
    shown = rows
    if len(rows) > _MOST_VALUES:
        # Evenly, both ends included.
        places = {round(i * (len(rows) - 1) / (_MOST_VALUES - 1)) for i in range(_MOST_VALUES)}
        shown = tuple(rows[place] for place in sorted(places))
    if not rows[0].trials:
        cells = [[_value(row), _percent(row.stable_share)] for row in shown]
        return fitting_table("", [key, "bare spring stable"], cells, right=(1,))
    headings = [key, "bare spring stable", "ended early", "tracking error", "limited"]
    cells = [
        [
            _value(row),
            _percent(row.stable_share),
            f"{sum(row.early_ends.values())} of {row.trials}",
            _UNKNOWN if row.tracking_error is None else f"{1e3 * row.tracking_error:.1f} mm",
            _percent(row.limited_share),
        ]
        for row in shown
    ]
    return fitting_table("", headings, cells, right=(1, 2, 3, 4))


def _value(row: SweepRow) -> str:
    return row.value if isinstance(row.value, str) else format_number(row.value or 0.0, 6)


def _percent(share: float | None) -> str:
    return _UNKNOWN if share is None else f"{100.0 * share:.3g} %"
