"""Tracking errors of both robots in every condition (Fig. 8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullLocator
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from telespring.show.figures.style import (
    FULL_WIDTH,
    GREY,
    ROBOT_COLOURS,
    figure_style,
    legend_line,
    sized_figure,
    text_colour,
)

__all__ = ["ErrorGroup", "error_figure"]

#: Groups whose largest error is above this multiple of the median group's have a scale of their own.
_FAR = 2.2
#: Share of the height that the far groups have; height of the whole figure without and with them, inch.
_FAR_HEIGHT, _HEIGHT, _SPLIT_HEIGHT = 0.36, 3.1, 4.0
#: Lines of the median and of a published one, and the colour of what is published.
_DASHED, _DOTTED = (0.0, (4.0, 2.0)), (0.0, (1.0, 1.5))
_PUBLISHED = "#303030"
#: So many values or fewer have larger markers.
_FEW = 12


@dataclass(frozen=True)
class ErrorGroup:
    """The tracking errors of one condition.

    Attributes
    ----------
    label
        Tick label of the group, such as the delay.
    family
        Name under which neighbouring groups are bracketed, such as a stiffness; different for each bracket.
    errors
        Per robot the tracking error of each trial or dyad, m; NaN if there is none.
    arrows
        Per robot "↑", "↓" or "".
    ended_early
        Number of trials without a tracking error.
    published
        Per robot a published mean and standard deviation, m; None if there are none.
    """

    label: str
    family: str
    errors: tuple[NDArray[np.float64], NDArray[np.float64]]
    arrows: tuple[str, str]
    ended_early: int = 0
    published: tuple[tuple[float, float], tuple[float, float]] | None = None


def error_figure(
    groups: Sequence[ErrorGroup],
    baseline: float | None,
    baseline_name: str = "UM",
    published_baseline: float | None = None,
    figure: Figure | None = None,
    *,
    unit: Literal["trial", "dyad"] = "trial",
) -> Figure:
    """Draw the tracking errors of both robots in every condition as boxes (Fig. 8).

    A box shows median and quartiles, its whiskers reach to the last value within 1.5 box heights, and every
    `unit` is a marker. An arrow above a box marks a significant difference from the baseline, whose median
    TE2 is `baseline`, m, and None where there is no baseline. Conditions with much larger errors than most
    have an upper part of the figure with a logarithmic scale, so that the others stay legible.
    `published_baseline` is a published median TE2 of the baseline, m.
    """
    split = _scale_change(groups, [baseline, published_baseline])
    with figure_style():
        figure = sized_figure(figure, FULL_WIDTH, _SPLIT_HEIGHT if split else _HEIGHT)
        figure.set_layout_engine("constrained")
        parts = _create_axes(figure, split)
        places = _error_box_places(groups)
        for axes in parts:
            for place, group in zip(places, groups, strict=True):
                for robot in range(2):
                    _draw_error_box(axes, place + (robot - 0.5) * 0.44, group, robot)
            if baseline is not None:
                axes.axhline(1e3 * baseline, color="black", linewidth=0.7, linestyle=_DASHED, zorder=1)
            if published_baseline is not None:
                axes.axhline(
                    1e3 * published_baseline, color=_PUBLISHED, linewidth=0.9, linestyle=_DOTTED, zorder=1
                )
            axes.set_xlim(places[0] - 0.7, places[-1] + 0.7)
            axes.grid(axis="y", color="#E4E4E4", linewidth=0.5)
            axes.set_axisbelow(True)
        lower = parts[-1]
        for place, group in zip(places, groups, strict=True):
            if group.ended_early:
                _note_early_ends(lower, place, group.ended_early)
        lower.set_xticks(places, [group.label for group in groups])
        lower.tick_params(axis="x", length=0.0)
        _limit_scales(parts, groups, split)
        _draw_significance_brackets(figure, lower, places, groups)
        _draw_arrows(parts, places, groups)
        error = "Tracking error, mm" if unit == "trial" else "Tracking error, mean of each dyad, mm"
        if split:
            figure.supylabel(error, fontsize=7.5)
        else:
            lower.set_ylabel(error)
        lower.set_xlabel("One-way delay within each stiffness, ms", labelpad=19.0)
        handles = _error_legend(groups, baseline, baseline_name, published_baseline)
        figure.legend(
            handles=handles,
            loc="outside upper center",
            ncols=4 if len(handles) <= 4 else 3,
            handlelength=1.8,
            columnspacing=1.2,
        )
    return figure


def _scale_change(groups: Sequence[ErrorGroup], baselines: Sequence[float | None]) -> float | None:
    """Choose from which error, mm, the scale is logarithmic, in a part of its own; None: nowhere."""
    largest = np.array([_largest(group) for group in groups])
    present = largest[np.isfinite(largest)]
    if len(present) < 2:
        return None
    usual = present[present <= _FAR * np.median(present)]
    if len(usual) == len(present):
        return None
    published = [mean + sd for group in groups for mean, sd in group.published or ()]
    top = float(max([usual.max(), *published, *(each for each in baselines if each is not None)]))
    # Between the usual groups and the others, where there is room, so that no box is cut.
    others = [
        float(np.nanmin(np.concatenate(group.errors)))
        for group, each in zip(groups, largest, strict=True)
        if each > usual.max()
    ]
    return 1e3 * min([1.06 * top, *(0.5 * (top + each) for each in others if each > top)])


def _largest(group: ErrorGroup) -> float:
    values = np.concatenate(group.errors)
    return float(max(values[np.isfinite(values)], default=np.nan))


def _create_axes(figure: Figure, split: float | None) -> list[Axes]:
    """Create the axes from top to bottom: the far groups' part, if there is one, and the usual part."""
    if split is None:
        return [figure.subplots()]
    upper, lower = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [_FAR_HEIGHT, 1.0 - _FAR_HEIGHT], "hspace": 0.0}
    )
    upper.set_yscale("log")
    upper.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    upper.yaxis.set_major_formatter("{x:g}")
    upper.yaxis.set_minor_locator(NullLocator())
    upper.tick_params(axis="x", length=0.0, labelbottom=False)
    upper.spines["bottom"].set_color(GREY)
    lower.spines["top"].set_color(GREY)
    return [upper, lower]


def _limit_scales(parts: Sequence[Axes], groups: Sequence[ErrorGroup], split: float | None) -> None:
    """Set the range of every part, with room for the arrows above the highest box."""
    if split is None:
        low, high = parts[0].get_ylim()
        parts[0].set_ylim(low, high + 0.08 * (high - low))
        return
    upper, lower = parts
    values = 1e3 * np.concatenate([np.concatenate(group.errors) for group in groups])
    published = [1e3 * (mean - sd) for group in groups for mean, sd in group.published or ()]
    smallest = min([float(np.nanmin(values)), *published])
    lower.set_ylim(smallest - 0.06 * (split - smallest), split)
    upper.set_ylim(split, float(np.nanmax(values)) * 1.35)
    upper.text(
        0.006,
        0.95,
        f"above {split:.3g} mm: logarithmic scale",
        transform=upper.transAxes,
        ha="left",
        va="top",
        fontsize=6.0,
        color="#505050",
    )


def _note_early_ends(axes: Axes, place: float, count: int) -> None:
    axes.annotate(
        f"{count} ended\nearly",
        (place, 0.0),
        (0.0, 3.0),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        ha="center",
        fontsize=5.2,
        color="#A03000",
    )


def _error_legend(
    groups: Sequence[ErrorGroup],
    baseline: float | None,
    baseline_name: str,
    published_baseline: float | None,
) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = [
        Patch(
            facecolor=ROBOT_COLOURS[0], alpha=0.35, edgecolor=ROBOT_COLOURS[0], label="TE1, robot 1 (dots)"
        ),
        Patch(
            facecolor=ROBOT_COLOURS[1],
            alpha=0.35,
            edgecolor=ROBOT_COLOURS[1],
            hatch="////",
            label="TE2, robot 2 (triangles)",
        ),
    ]
    if baseline is not None:
        handles += [
            legend_line(
                f"median TE2 in {baseline_name}, {1e3 * baseline:.2f} mm", "black", _DASHED, linewidth=0.7
            )
        ]
    if any(any(group.arrows) for group in groups):
        handles.append(
            Line2D([], [], linestyle="none", label=f"↑ ↓ differs from TE2 in {baseline_name}, p < 0.05")
        )
    if any(group.published for group in groups):
        handles.append(
            Line2D(
                [],
                [],
                color=_PUBLISHED,
                marker="D",
                markersize=3.0,
                markerfacecolor="white",
                linewidth=0.7,
                label="published mean ± standard deviation",
            )
        )
    if published_baseline is not None:
        handles.append(
            legend_line(
                f"published median TE2 in {baseline_name}, {1e3 * published_baseline:.2f} mm",
                _PUBLISHED,
                _DOTTED,
                linewidth=0.9,
            )
        )
    return handles


def _error_box_places(groups: Sequence[ErrorGroup]) -> list[float]:
    places, place = [], 0.0
    for i, group in enumerate(groups):
        if i:
            place += 1.0 if group.family == groups[i - 1].family else 1.5
        places.append(place)
    return places


def _draw_error_box(axes: Axes, place: float, group: ErrorGroup, robot: int) -> None:
    colour = ROBOT_COLOURS[robot]
    if group.published is not None:
        mean, sd = group.published[robot]
        axes.errorbar(
            place,
            1e3 * mean,
            1e3 * sd,
            fmt="D",
            color=_PUBLISHED,
            markersize=2.6,
            markerfacecolor="white",
            markeredgewidth=0.6,
            elinewidth=0.6,
            capsize=1.2,
            capthick=0.6,
            zorder=3,
        )
    errors = 1e3 * group.errors[robot]
    errors = errors[np.isfinite(errors)]
    if len(errors) == 0:
        return
    drawn = axes.boxplot(
        [errors],
        positions=[place],
        widths=0.36,
        patch_artist=True,
        showfliers=False,
        manage_ticks=False,
        medianprops={"color": "black", "linewidth": 0.9},
        whiskerprops={"color": colour, "linewidth": 0.7},
        capprops={"color": colour, "linewidth": 0.7},
    )
    for box in drawn["boxes"]:
        box.set(edgecolor=colour, linewidth=0.7, hatch="////" if robot else None)
        box.set_facecolor(to_rgba(colour, 0.28))
    # A fixed spread, so that the same trials give the same figure.
    spread = 0.24 * (((np.arange(len(errors)) * 0.618034) % 1.0) - 0.5)
    axes.plot(
        place + spread,
        errors,
        "^" if robot else "o",
        color=colour,
        markersize=1.5 if len(errors) > _FEW else 2.8,
        markeredgewidth=0.0,
        alpha=0.8,
    )


def _draw_arrows(parts: Sequence[Axes], places: Sequence[float], groups: Sequence[ErrorGroup]) -> None:
    """Write the arrow of each box above its largest value, in the part that shows it."""
    for place, group in zip(places, groups, strict=True):
        for robot, arrow in enumerate(group.arrows):
            errors = group.errors[robot]
            if not arrow or not np.isfinite(errors).any():
                continue
            top = 1e3 * float(np.nanmax(errors))
            axes = next(part for part in reversed(parts) if part is parts[0] or top <= part.get_ylim()[1])
            axes.annotate(
                arrow,
                (place + (robot - 0.5) * 0.44, top),
                (0.0, 2.0),
                textcoords="offset points",
                ha="center",
                fontsize=8.0,
                color=text_colour(ROBOT_COLOURS[robot]),
                fontweight="bold",
            )


def _draw_significance_brackets(
    figure: Figure, axes: Axes, places: Sequence[float], groups: Sequence[ErrorGroup]
) -> None:
    # Below the tick labels: in points, as parts of a figure differ in height.
    for family in dict.fromkeys(group.family for group in groups if group.family):
        inside = [place for place, group in zip(places, groups, strict=True) if group.family == family]
        ends = [inside[0] - 0.45, inside[-1] + 0.45]
        transform = axes.get_xaxis_transform() + ScaledTranslation(0.0, -17.0 / 72.0, figure.dpi_scale_trans)
        axes.plot(ends, [0.0] * 2, color=GREY, linewidth=0.7, transform=transform, clip_on=False)
        axes.annotate(
            family,
            (0.5 * (inside[0] + inside[-1]), 0.0),
            (0.0, -20.0),
            xycoords=axes.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=7.0,
        )
