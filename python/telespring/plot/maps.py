"""The map of stability: where a dyad is stable, over stiffness and delay."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Patch

from telespring._errors import InvalidInput
from telespring.model import Dyad, Network, OperatorRange
from telespring.plot.regions import MapQuestion, map_extent
from telespring.plot.settings import check_settings, given_or_new_axes
from telespring.show.figures.maps import (
    STABLE,
    StudyMark,
    draw_axis_boundaries,
    draw_condition,
    draw_study_mark,
    draw_varying_boundary,
)
from telespring.show.figures.style import COLOURS, DASHES, GREY, figure_style, legend_line
from telespring.show.quantities import format_time
from telespring.show.screens.questions import describe_robots, sampling_clause

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

__all__ = ["stability_map"]

#: The shade of what is stable with a playout buffer only.
_WITH_BUFFER = {"colors": ["none"], "hatches": ["...."]}


def stability_map(
    dyad: Dyad,
    *,
    mark: tuple[float | None, float | None] | tuple[float, float, float] | None = None,
    stiffness: float | None = None,
    delay: float | None = None,
    operator_range: tuple[OperatorRange, OperatorRange] | None = None,
    network: Network | None = None,
    playout_buffer: bool = False,
    verdict: str | None = None,
    title: str | None = None,
    allow_unusual: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw where a dyad is stable, over stiffness and one-way delay.

    Every point is judged as `telespring.decide` judges it with the timing of `network`; the legend says
    which. Without a network the controllers are continuous and the delay is constant.

    Parameters
    ----------
    dyad
        Robots and operators. Every stable region is drawn, also those at delays beyond the first. The
        boundaries pass through the exact limits at 400 stiffnesses and at that of the mark, and are straight
        between them. Sampled controllers are stable in steps of whole periods; the boundary then keeps below
        the limits of both neighbours, so that what is shaded is not more than what is stable.
    mark
        A stiffness (N/m) and a one-way delay (s) to mark by a star; with None for one of them, the other is
        marked by a line. Without a network a third value is the longest delay, to which a bar is drawn.
    stiffness, delay
        Largest stiffness (N/m) and delay (s) of the map. By default it shows the mark, the limit of the
        stiffness at its delay (up to 20 times its stiffness), and the limit of the delay at its stiffness (up
        to 6 times its delay). Without a mark it shows delays up to 250 ms.
    operator_range
        Ranges of both operators instead of the dyad's own: shaded are, at 100 stiffnesses and that of the
        mark, the delays below the first one that is not proven for every operator
        (`telespring.delay_limit`). Between two of them the boundary keeps below the limits of both, which is
        not proven there: single points are judged by `telespring.decide`.
    network
        Timing of the controllers and of the network, and the proportion of both delays. If the controllers
        sample, the map is theirs. With jitter or gaps the delay of the map is the shortest one, and what is
        shaded is proven for every delay that varies above it; dotted is what a playout buffer would add.
    playout_buffer
        Whether both sides hold every sample until it is as old as the latest one can be: the map is then of
        the constant delay behind it.
    verdict
        The answer at the mark, in a word, which is written beside the star.
    title
        What is written above the map; by default the robots.
    allow_unusual
        Whether stiffnesses and delays that no laboratory has are meant: by default they are refused, because
        their unit is probably wrong.
    ax
        Axes to draw on.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in N/m and ms.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of its range, or unusual.

    Examples
    --------
    >>> import telespring as ts
    >>> ax = ts.plot.stability_map(ts.hman(), mark=(71.2, 0.1), network=ts.Network(0.1, sample_period=0.001))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('Stiffness k, N/m', 'One-way delay δ, ms')
    >>> ax.get_legend().get_texts()[0].get_text()
    'stable at a constant delay, controllers sampled every 1 ms'
    """
    check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    point, longest_delay = _point_of(mark, network, allow_unusual)
    asked = MapQuestion(dyad, network or Network(point[1] or 0.0), operator_range, playout_buffer)
    wide, long = map_extent(asked, point) if stiffness is None or delay is None else (0.0, 0.0)
    if longest_delay is not None:
        long = max(long, 1.15 * longest_delay)
    extent = wide if stiffness is None else float(stiffness), long if delay is None else float(delay)
    k, delays = asked.grid(extent, point)
    with figure_style():
        ax = given_or_new_axes(ax, (5.2, 4.4))
        handles = _draw_regions(ax, asked, k, delays)
        ax.set(xlim=(0.0, extent[0]), ylim=(0.0, 1e3 * extent[1]), ylabel=_delay_label(asked))
        handles += draw_condition(ax, *point, verdict)
        if longest_delay is not None and point[0] is not None and point[1] is not None:
            handles += draw_study_mark(ax, StudyMark(point[0], point[1], longest_delay), "this condition")[1:]
        ax.set_title("\n".join(describe_robots(dyad)) if title is None else title, loc="left")
        ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=1)
    return ax


def _draw_regions(ax: Axes, asked: MapQuestion, stiffness: np.ndarray, delays: np.ndarray) -> list[Artist]:
    """Shade what is stable and draw its limits; return what the legend lists."""
    network, controllers = asked.network, sampling_clause(asked.network.sample_period)
    suffix = f"{controllers}{', every operator' if asked.ranges is not None else ''}"
    more = format_time(asked.extra, 6)
    constant = asked.constant(stiffness, delays)
    handles: list[Artist]
    if asked.is_varying:
        depth = asked.varying(stiffness, delays)
        lines = draw_axis_boundaries(ax, constant, stiffness, delays, **_WITH_BUFFER)
        line = draw_varying_boundary(ax, depth, stiffness, delays, "proven up to here while the delay varies")
        handles = [
            Patch(color=STABLE, label=f"stable while the delay varies by up to {more}, {suffix}"),
            Patch(
                facecolor="none",
                edgecolor=GREY,
                hatch="....",
                label="stable only with a playout buffer, which makes the delay constant",
            ),
            line,
            *lines,
        ]
    else:
        lines = draw_axis_boundaries(ax, constant, stiffness, delays)
        if network.is_constant:
            what = "at a constant delay"
        else:
            what = f"with the playout buffer (a constant delay, {more} longer)"
        handles = [Patch(color=STABLE, label=f"stable {what}, {suffix}"), *lines]
    critical = _critical_stiffness(asked)
    if critical is not None and critical < stiffness[-1]:
        ax.axvline(critical, color=COLOURS["black"], linestyle=DASHES[1], linewidth=1.0)
        handles.append(
            legend_line("any constant delay: left of this", COLOURS["black"], DASHES[1], linewidth=1.0)
        )
    return handles


def _critical_stiffness(asked: MapQuestion) -> float | None:
    """Return what is allowed at any constant delay, N/m; None where no criterion knows it."""
    if asked.is_sampled or asked.is_varying:
        return None
    judged = asked.judge(0.0)
    return judged.tier("any constant delay").stiffness_bound


def _delay_label(asked: MapQuestion) -> str:
    forward, backward = asked.network.delay
    words = [
        *(["mean"] if forward != backward else []),
        *(["shortest"] if not asked.network.is_constant else []),
        "one-way delay δ, ms",
    ]
    return " ".join(words).capitalize()


def _point_of(
    mark: Sequence[float | None] | None, network: Network | None, allow_unusual: bool
) -> tuple[tuple[float | None, float | None], float | None]:
    """Check a mark: a stiffness and a delay, and optionally a longest delay that is no shorter."""
    if mark is None:
        return (None, None), None
    values = [None if value is None else float(value) for value in mark]
    if len(values) not in (2, 3) or (len(values) == 3 and None in values):
        raise InvalidInput(
            "mark",
            f"{len(values)} values",
            "a stiffness (N/m) and a delay (s) are required, and optionally the longest delay",
            "Write mark=(71.2, 0.08).",
        )
    if len(values) == 3 and network is not None:
        raise InvalidInput(
            "mark",
            "with a longest delay beside a network",
            "the network says by how much the delay varies",
            "Leave out the third value.",
        )
    delays = {f"mark[{i}]": value for i, value in enumerate(values) if i}
    check_settings({"mark[0]": values[0]}, delays, allow_unusual)
    longest = values[2] if len(values) == 3 else None
    if longest is not None and values[1] is not None and longest < values[1]:
        raise InvalidInput(
            "mark",
            f"{longest:g} s as the longest delay",
            f"a longest delay of at least the delay, {values[1]:g} s, is required",
            "Write the shorter delay first.",
        )
    return (values[0], values[1]), longest
