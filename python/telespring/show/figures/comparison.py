"""Tracking error against delay for every strategy, with what ran away."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from telespring.show.figures.comparison_notes import Note, PlacedNote, place_notes
from telespring.show.figures.strategy_looks import StrategyLook
from telespring.show.figures.style import (
    FULL_WIDTH,
    GREY,
    figure_style,
    legend_line,
    legend_mark,
    panel_label,
    sized_figure,
    text_colour,
)

__all__ = ["DelayCurve", "DelayPanel", "delay_figure"]

Floats = NDArray[np.float64]

#: The scale ends at this multiple of the error without delay; what is larger is written above it.
_FAR = 2.6
#: Panels in a row, and height of a panel and of what is around the panels, inch.
_COLUMNS, _HEIGHT, _AROUND = 4, 1.75, 1.0
#: Height of a line of text above the scale, as a share of the scale.
_LINE = 0.085
#: Size of the letters of these lines, pt; and what the panels leave: beside all of them and beside each, pt.
_NOTE_SIZE, _BESIDE_ALL, _BESIDE = 6.0, 45.0, 8.0
_LEVEL, _ALONE = "#303030", (0.0, (1.0, 1.5))


@dataclass(frozen=True)
class DelayCurve:
    """The tracking errors of one strategy at one stiffness.

    Attributes
    ----------
    label
        The strategy, as in the mapping of looks.
    name
        The strategy in words.
    delay
        One way, s, ascending.
    mean, spread
        Mean and standard deviation over the trials that have an error, m, (delay, person); NaN without any.
    ran_away, ended_early
        Number of trials that ran away, and of others that ended early, per delay.
    trials
        Number of trials, per delay.
    """

    label: str
    name: str
    delay: Floats
    mean: Floats
    spread: Floats
    ran_away: NDArray[np.int_]
    ended_early: NDArray[np.int_]
    trials: NDArray[np.int_]


@dataclass(frozen=True)
class DelayPanel:
    """All strategies at one stiffness.

    Attributes
    ----------
    title
        The stiffness, and the network if there are several.
    curves
        One per strategy.
    undelayed
        Error of both people coupled by the spring without delay, m; None if that is not known.
    """

    title: str
    curves: Sequence[DelayCurve]
    undelayed: tuple[float, float] | None = None


@dataclass(frozen=True)
class _Reach:
    """From which delay, s, to which an axis reaches, and about how wide it is, pt."""

    low: float
    high: float
    width: float

    def share(self, delay: float) -> float:
        return (delay - self.low) / (self.high - self.low)

    def at(self, share: float) -> float:
        return self.low + share * (self.high - self.low)


def delay_figure(
    panels: Sequence[DelayPanel],
    looks: Mapping[str, StrategyLook],
    alone: tuple[float, float] | None = None,
    figure: Figure | None = None,
) -> Figure:
    """Draw the tracking error of both people against the delay, a column per stiffness.

    Lines are means, bars standard deviations over the trials. The horizontal line is the level without delay;
    `alone` (m) is that of the people without a coupling. All panels share one scale, which begins at 0. Above
    it are written the errors that do not fit, in mm, and how many trials ran away or ended early.
    """
    columns = min(_COLUMNS, len(panels))
    blocks = math.ceil(len(panels) / columns)
    curves = {curve.label: curve for panel in panels for curve in panel.curves}
    limit = _scale_limit(panels, alone)
    longest = max(float(curve.delay[-1]) for panel in panels for curve in panel.curves) or 0.1
    reach = _Reach(-0.06 * longest, 1.06 * longest, (72.0 * FULL_WIDTH - _BESIDE_ALL) / columns - _BESIDE)
    above = [_notes_above(panel, person, limit, reach) for panel in panels for person in (0, 1)]
    has_far = any(each.note.text[0] == "▲" for notes in above for each in notes)
    lines = 1 + max((note.row for notes in above for note in notes), default=-1)
    top = limit * (1.0 + _LINE * (lines + 0.5)) if lines else limit
    with figure_style():
        rows = 2 * blocks
        key_rows = math.ceil((len(curves) + 4) / 4)
        height = rows * _HEIGHT * math.sqrt(top / limit) + _AROUND + 0.14 * key_rows
        figure = sized_figure(figure, FULL_WIDTH, height)
        figure.set_layout_engine("constrained")
        grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        for axes in grid.flat:
            axes.set_visible(False)
        for i, panel in enumerate(panels):
            block, column = divmod(i, columns)
            for person in (0, 1):
                axes = grid[2 * block + person, column]
                axes.set_visible(True)
                _draw_panel(axes, panel, person, looks, limit, reach, alone)
                if column == 0:
                    axes.set_ylabel(f"Tracking error TE{'₁₂'[person]}, mm")
                if person == 0:
                    panel_label(axes, "", panel.title)
                if person == 1:
                    axes.set_xlabel("One-way delay δ, ms")
                    axes.tick_params(labelbottom=True)
        grid[0, 0].set(xlim=(1e3 * reach.low, 1e3 * reach.high), ylim=(0.0, 1e3 * top))
        grid[0, 0].set_xticks(_delay_ticks(longest))
        grid[0, 0].set_yticks([tick for tick in grid[0, 0].get_yticks() if tick <= 1e3 * limit])
        figure.legend(
            handles=_legend(
                curves,
                looks,
                panels,
                alone,
                has_far=has_far,
            ),
            loc="outside upper center",
            ncols=4 if len(curves) > 2 else 3,
            columnspacing=1.4,
        )
    return figure


def _draw_panel(
    axes: Axes,
    panel: DelayPanel,
    person: int,
    looks: Mapping[str, StrategyLook],
    limit: float,
    reach: _Reach,
    alone: tuple[float, float] | None,
) -> None:
    if alone is not None:
        axes.axhline(1e3 * alone[person], color=GREY, linestyle=_ALONE, linewidth=0.9, zorder=1)
    if panel.undelayed is not None:
        axes.axhline(1e3 * panel.undelayed[person], color=_LEVEL, linewidth=0.6, zorder=1)
    for curve in panel.curves:
        look = looks[curve.label]
        mean, spread = curve.mean[:, person], curve.spread[:, person]
        fits = mean <= limit
        (line,) = axes.plot(
            1e3 * curve.delay,
            1e3 * mean,
            color=look.colour,
            linestyle=look.line,
            linewidth=look.width,
            zorder=3 if look.width > 1.0 else 2,
        )
        # A line leaves the scale where it does; what is beyond is written above.
        line.set_clip_path(Rectangle((-1e6, 0.0), 2e6, 1e3 * limit, transform=axes.transData))
        # Without a point the clip would count as its extent.
        line.set_in_layout(False)
        axes.errorbar(
            1e3 * curve.delay[fits],
            1e3 * mean[fits],
            1e3 * np.stack([spread[fits], np.minimum(spread[fits], limit - mean[fits])]),
            color=look.colour,
            linestyle="none",
            marker=look.marker,
            markersize=4.2 if look.width > 1.0 else 3.4,
            markeredgewidth=0.4,
            markeredgecolor="white",
            elinewidth=0.7,
            zorder=4 if look.width > 1.0 else 3,
        )
    notes = _notes_above(panel, person, limit, reach)
    if notes:
        axes.axhline(1e3 * limit, color=GREY, linewidth=0.4, zorder=1)
    for each in notes:
        axes.annotate(
            each.note.text,
            (1e3 * reach.at(each.middle), _height_of_row(each.row, limit)),
            ha="center",
            va="bottom",
            fontsize=_NOTE_SIZE,
            color=text_colour(looks[each.note.label].colour),
        )


def _height_of_row(row: int, limit: float) -> float:
    """Return the height of the lower edge of a row of notes, mm."""
    return 1e3 * limit * (1.0 + _LINE * (row + 0.25))


def _notes_above(panel: DelayPanel, person: int, limit: float, reach: _Reach) -> list[PlacedNote]:
    """Write what lies above the scale, and how many trials failed; `reach` is that of the axis."""
    notes = []
    for curve in panel.curves:
        for i, mean in enumerate(curve.mean[:, person].tolist()):
            ran_away, failed = int(curve.ran_away[i]), int(curve.ran_away[i] + curve.ended_early[i])
            parts = [f"{1e3 * mean:.0f}"] if math.isfinite(mean) and mean > limit else []
            if failed and (failed < curve.trials[i] or not parts):
                parts.append(f"{failed}/{curve.trials[i]}")
            if parts:
                sign = "✕" if ran_away else "†" if failed else "▲"
                notes.append(
                    Note(reach.share(float(curve.delay[i])), f"{sign} {', '.join(parts)}", curve.label)
                )
    return place_notes(notes, reach.width, _NOTE_SIZE)


def _scale_limit(panels: Sequence[DelayPanel], alone: tuple[float, float] | None) -> float:
    """Choose where the scale ends, m: at the largest error that is not far from that without delay."""
    levels = [level for panel in panels for level in panel.undelayed or ()] + list(alone or ())
    means = np.concatenate([curve.mean.ravel() for panel in panels for curve in panel.curves])
    spreads = np.concatenate([curve.spread.ravel() for panel in panels for curve in panel.curves])
    known = np.isfinite(means)
    if not known.any():
        return 1.15 * max(levels, default=0.1)
    level = max(levels) if levels else float(means[known].min())
    near = known & (means <= _FAR * level)
    if not near.any():
        near = known & (means <= means[known].min())
    reach = means + np.where(np.isfinite(spreads), np.minimum(spreads, 0.25 * means), 0.0)
    return 1.06 * max(float(reach[near].max()), level)


def _delay_ticks(longest: float) -> list[float]:
    """Choose at most five round ticks, ms."""
    span = 1e3 * longest
    step = next(
        step
        for power in range(-3, 7)
        for step in (1.0 * 10**power, 2.0 * 10**power, 5.0 * 10**power)
        if span / step <= 4.0
    )
    return [step * i for i in range(math.floor(span / step) + 1)]


def _legend(
    curves: Mapping[str, DelayCurve],
    looks: Mapping[str, StrategyLook],
    panels: Sequence[DelayPanel],
    alone: tuple[float, float] | None,
    *,
    has_far: bool,
) -> list[Line2D]:
    handles = [
        legend_line(
            curve.name,
            looks[label].colour,
            looks[label].line,
            marker=looks[label].marker,
            markersize=4.2,
            markeredgewidth=0.4,
            markeredgecolor="white",
            linewidth=looks[label].width,
        )
        for label, curve in curves.items()
    ]
    if any(panel.undelayed is not None for panel in panels):
        handles.append(legend_line("bare spring without delay", _LEVEL, linewidth=0.6))
    if alone is not None:
        handles.append(legend_line("without a coupling", GREY, _ALONE, linewidth=0.9))
    if has_far:
        handles.append(legend_mark("above the scale: mm", _LEVEL, "^", markersize=3.5))
    drawn = [curve for panel in panels for curve in panel.curves]
    if any(curve.ran_away.any() for curve in drawn):
        handles.append(legend_mark("ran away: mm, trials", _LEVEL, "x", markersize=4.0))
    if any((curve.ended_early[curve.ran_away == 0] > 0).any() for curve in drawn):
        handles.append(legend_mark("ended early: trials", _LEVEL, "$†$", markersize=4.5))
    return handles
