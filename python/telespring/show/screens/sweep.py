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
#: Keys that only verdicts without trials use, and the short name that stands for the protocol's, too.
_OF_THE_VERDICTS = {"coupling.stiffness": "stiffness", "network.delay": "delay"}


def sweep_screen(summary: SweepSummary, seconds: float | None) -> RenderableType:
    """Lay a sweep out for the terminal; `seconds` is how long it took, None if nothing was run."""
    whole = summary.whole
    took = "complete" if seconds is None else f"in {seconds:.1f} s"
    trials = f", {whole.trials} trials" if whole.trials else ""
    parts: list[RenderableType] = [
        Text(summary.name, style="bold"),
        Text(f"{summary.points} points{trials}, {took}"),
    ]
    if whole.stable_share is not None:
        share = _percent(whole.stable_share)
        parts.append(
            Text(f"At a constant delay the bare spring is stable at {share} of the points' conditions.")
        )
    if whole.early_ends:
        ends = ", ".join(f"{count} {status}" for status, count in whole.early_ends.items())
        parts.append(Text(f"Ended early: {ends}."))
    if whole.guard_broken is not None:
        parts.append(_guard_line(whole))
    parts += [_no_effect_line(key, has_trials=whole.trials > 0) for key in summary.without_effect]
    for key, rows in summary.keys.items():
        if len(rows) > 1:
            parts += [Text(""), _table(key, rows)]
            if len(rows) > _MOST_VALUES:
                parts.append(Text(f"{_MOST_VALUES} of {len(rows)} values; the dataset has all."))
    return Group(*parts)


def _guard_line(whole: SweepRow) -> Text:
    if whole.guard_broken:
        return Text(
            f"The guards broke their law in {whole.guard_broken} trials: they gave out more energy than it "
            "allows. guard_spare says how much.",
            style="red",
        )
    if whole.guard_overtaxed:
        return Text(
            "The guards kept their law wherever the robots have the damping that they count on. In "
            f"{whole.guard_overtaxed} trials a drawn robot has less, and they gave out more than its law "
            "allows: guard_spare says how much.",
            style="yellow",
        )
    return Text("The guards kept their law in every trial that can be judged.")


def _no_effect_line(key: str, *, has_trials: bool) -> Text:
    said = f"{key} changes nothing: all its values have the same results."
    if has_trials and key in _OF_THE_VERDICTS:
        said += f" The trials take theirs from the protocol; {_OF_THE_VERDICTS[key]}=… sets both."
    return Text(said, style="yellow")


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
    """Write a share; all and none are said only where they are meant."""
    if share is None:
        return _UNKNOWN
    if 0.9995 <= share < 1.0:
        return "> 99.9 %"
    return f"{100.0 * share:.3g} %"
