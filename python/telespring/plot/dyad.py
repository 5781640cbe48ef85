"""Figures of one dyad: where it is stable, how it moves, and its loop."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Patch

from telespring._core import check_usual
from telespring._errors import InvalidInput
from telespring.model import Dyad, DyadAxis, OperatorRange
from telespring.show.figures.maps import (
    HORIZON,
    STABLE,
    MapColumn,
    StudyMark,
    draw_axis_boundaries,
    draw_study_mark,
    stable_depth,
)
from telespring.show.figures.nyquist import NyquistPanel, draw_nyquist_locus
from telespring.show.figures.responses import draw_motion, motion_legend
from telespring.show.figures.style import COLOURS, DASHES, ROBOT_COLOURS, figure_style, legend_line
from telespring.theory.response import frequency_response as compute_frequency_response
from telespring.theory.response import nyquist as compute_nyquist
from telespring.theory.verdicts import verdicts

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from telespring._types import FloatArray

__all__ = ["frequency_response", "nyquist", "response", "stability_map"]

_POINTS = 400
#: Over ranges of operators a delay takes milliseconds: fewer are judged.
_RANGE_POINTS = 50


def stability_map(
    dyad: Dyad,
    *,
    mark: tuple[float, float] | tuple[float, float, float] | None = None,
    stiffness: float | None = None,
    delay: float | None = None,
    operator_range: tuple[OperatorRange, OperatorRange] | None = None,
    allow_unusual: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw where a dyad is stable at a constant delay, over stiffness and one-way delay.

    Parameters
    ----------
    dyad
        Robots and operators. Every stable region of continuous controllers is drawn, also those at delays
        beyond the first. The boundaries pass through the exact limits at 400 stiffnesses.
    mark
        A stiffness (N/m) and a one-way delay (s) to mark by a star; a third value is the longest delay, to
        which a bar is drawn.
    stiffness, delay
        Largest stiffness (N/m) and delay (s) of the map. By default 4.6 times the critical stiffness, 2.4
        times the maximum delay at twice that, and room for the mark.
    operator_range
        Ranges of both operators instead of the dyad's own: drawn is where every smaller stiffness is stable
        for every operator, as `telespring.verdicts` proves it. Between two of
        the 51 delays that are judged, the lower limit of both is drawn.
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
    >>> ax = ts.plot.stability_map(ts.hman(), mark=(71.2, 0.1))
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('Stiffness k, N/m', 'One-way delay δ, ms')
    """
    _check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    star = None if mark is None else _star_of(mark, allow_unusual)
    lightest = None if operator_range is None else (operator_range[0].low, operator_range[1].low)
    shown = dyad if lightest is None else Dyad(*dyad.robots, lightest, dyad.coupling_damping)
    widest, longest = _map_extent(shown, star)
    widest = widest if stiffness is None else float(stiffness)
    longest = longest if delay is None else float(delay)
    k = np.linspace(0.0, widest, _POINTS + 1)[1:]
    delays = np.linspace(0.0, longest, _POINTS + 1)
    if operator_range is None:
        boundaries = [(axis.name, _depth_of_axis(axis, k, delays)) for axis in dyad]
        critical = min(axis.critical_stiffness() for axis in dyad)
    else:
        boundaries, critical = _bounds_over_range(dyad, operator_range, k, delays)
    with figure_style():
        ax = _given_or_new_axes(ax, (5.2, 3.8))
        handles = draw_axis_boundaries(ax, boundaries, k, delays)
        if critical < widest:
            ax.axvline(critical, color=COLOURS["black"], linestyle=DASHES[1], linewidth=1.0)
            handles.append(
                legend_line("any constant delay: left of this", COLOURS["black"], DASHES[1], linewidth=1.0)
            )
        if star is not None:
            handles += draw_study_mark(ax, star, "this condition")
        shaded = "stable, continuous controllers" + (", every operator" if operator_range else "")
        ax.legend(
            handles=[Patch(color=STABLE, label=shaded), *handles],
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=2,
        )
    return ax


def _bounds_over_range(
    dyad: Dyad, ranges: tuple[OperatorRange, OperatorRange], k: FloatArray, delays: FloatArray
) -> tuple[list[tuple[str, FloatArray]], float]:
    """How far every operator is stable, by axis, and what is allowed at any constant delay, N/m."""
    judged = delays[:: _POINTS // _RANGE_POINTS]
    verdict = [verdicts(dyad, float(k[0]), float(delay), operator_range=ranges) for delay in judged]
    # The limit need not be straight between two delays: the lower one of both holds.
    following = np.minimum(np.searchsorted(judged, delays), judged.size - 1)
    preceding = np.maximum(np.searchsorted(judged, delays, side="right") - 1, 0)
    boundaries = []
    for i, name in enumerate(dyad.axes):
        tiers = [next(t for t in each.axes[i].tiers if t.tier == "constant delay") for each in verdict]
        bounds = [tier.stiffness_bound for tier in tiers]
        limits = [2.0 * k[-1] if bound is None else min(bound, 2.0 * k[-1]) for bound in bounds]
        lower = np.minimum(np.take(limits, preceding), np.take(limits, following))
        boundaries.append((name, lower[:, None] - k))
    critical = verdict[0].tier("any constant delay").stiffness_bound
    return boundaries, math.inf if critical is None else critical


def _depth_of_axis(axis: DyadAxis, k: FloatArray, delays: FloatArray) -> FloatArray:
    """How far the delays lie inside the stable intervals, s, (delay, stiffness)."""
    horizon = HORIZON * float(delays[-1])
    columns = [MapColumn(each, axis.stable_delays(each, horizon)) for each in k.tolist()]
    return stable_depth(columns, delays)


def _star_of(mark: tuple[float, ...], allow_unusual: bool) -> StudyMark:
    """Check a mark: a stiffness, a delay, and a longest delay that is no shorter."""
    values = tuple(float(value) for value in np.ravel(mark))
    if len(values) not in (2, 3):
        raise InvalidInput(
            "mark",
            f"{len(values)} values",
            "a stiffness (N/m) and a delay (s) are required, and optionally the longest delay",
            "Write mark=(71.2, 0.08).",
        )
    if values[-1] < values[1]:
        raise InvalidInput(
            "mark",
            f"{values[-1]:g} s as the longest delay",
            f"a longest delay of at least the delay, {values[1]:g} s, is required",
            "Write the shorter delay first.",
        )
    delays = {f"mark[{i}]": value for i, value in enumerate(values) if i}
    _check_settings({"mark[0]": values[0]}, delays, allow_unusual)
    return StudyMark(values[0], values[1], values[-1])


def _check_settings(
    stiffnesses: Mapping[str, float | None], delays: Mapping[str, float | None], allow_unusual: bool
) -> None:
    """Refuse values below 0 or not finite, and what no laboratory has: its unit is probably wrong."""
    for name, quantity, unit, value in (
        *((name, "stiffness", "N/m", stiffness) for name, stiffness in stiffnesses.items()),
        *((name, "delay", "s", delay) for name, delay in delays.items()),
    ):
        if value is None:
            continue
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(
                name, f"{value:g} {unit}", f"a {quantity} of 0 {unit} or more is required", "Correct it."
            )
        if allow_unusual:
            continue
        try:
            check_usual(quantity, name, float(value))
        except InvalidInput as refused:
            meant, is_possible, _ = refused.remedy.partition("If it is meant")
            remedy = f"{meant}If it is meant, pass allow_unusual=True." if is_possible else refused.remedy
            raise InvalidInput(refused.field, refused.value, refused.allowed, remedy) from None


def response(motion: xarray.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the positions of both robots over time.

    Parameters
    ----------
    motion
        What `telespring.simulate` returns.
    ax
        Axes to draw on.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in s and mm.

    Examples
    --------
    >>> import telespring as ts
    >>> motion = ts.simulate(ts.hman(), 71.2, 0.1, [[1.0, 1.0], [-1.0, -1.0]], 3.0)
    >>> len(ts.plot.response(motion).lines)
    4
    """
    position = motion["position"].transpose("time", "robot", "axis")
    with figure_style():
        ax = _given_or_new_axes(ax, (5.2, 3.0))
        draw_motion(ax, np.asarray(position["time"]), np.asarray(position))
        names = [str(name) for name in position["axis"].values]
        ax.legend(
            handles=motion_legend(names),
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=min(4, 2 * len(names)),
        )
        ax.set(xlabel="Time, s", ylabel="Position, mm")
        ax.margins(x=0.0)
    return ax


def nyquist(
    dyad: Dyad,
    stiffness: float,
    delay: float,
    *,
    axis: str | int = 0,
    allow_unusual: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw the Nyquist locus of one axis, with the encirclements of −1.

    Parameters
    ----------
    dyad
        Robots and operators.
    stiffness, delay
        N/m, and one-way delay, s.
    axis
        Which axis of the dyad, by name or number.
    allow_unusual
        As in `stability_map`.
    ax
        Axes to draw on.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; real and imaginary part of L(jω) have no unit.

    Examples
    --------
    >>> import telespring as ts
    >>> ts.plot.nyquist(ts.hman(), 71.2, 0.18, axis="x").get_title("right")
    'unstable, 2 encirclements of −1'
    """
    _check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    locus = compute_nyquist(dyad, stiffness, delay, axis=axis)
    stable = dyad[axis].is_stable(stiffness, delay)
    note = "stable" if stable else f"unstable, {locus.encirclements} encirclements of −1"
    values = np.asarray(locus.locus)
    with figure_style():
        ax = _given_or_new_axes(ax, (3.8, 3.8))
        panel = NyquistPanel("", values, "stable" if stable else "unstable", note)
        draw_nyquist_locus(ax, panel, 1.12 * max(1.0, float(np.abs(values).max())))
        ax.set(xlabel="Real part of L(jω), 1", ylabel="Imaginary part of L(jω), 1")
    return ax


def frequency_response(
    dyad: Dyad,
    stiffness: float,
    delay: float,
    frequency: ArrayLike | None = None,
    *,
    axis: str | int = 0,
    allow_unusual: bool = False,
    ax: Axes | None = None,
) -> Axes:
    """Draw the motion of both robots per force on robot 1, over the angular frequency.

    Parameters
    ----------
    dyad
        Robots and operators.
    stiffness, delay
        N/m, and one-way delay, s.
    frequency
        Angular frequencies, rad/s. By default a grid that resolves every resonance.
    axis
        Which axis of the dyad, by name or number.
    allow_unusual
        As in `stability_map`.
    ax
        Axes to draw on.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, in rad/s and m/N, both logarithmic.

    Examples
    --------
    >>> import telespring as ts
    >>> ax = ts.plot.frequency_response(ts.hman(), 71.2, 0.1)
    >>> [line.get_label() for line in ax.lines]
    ['robot 1', 'robot 2']
    """
    _check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    computed = compute_frequency_response(dyad, stiffness, delay, frequency, axis=axis)
    with figure_style():
        ax = _given_or_new_axes(ax, (5.2, 3.0))
        for robot, (colour, dashes) in enumerate(zip(ROBOT_COLOURS, ("solid", DASHES[1]), strict=True)):
            ax.loglog(
                computed.frequency,
                computed.magnitude[:, robot, 0],
                color=colour,
                linestyle=dashes,
                label=f"robot {robot + 1}",
            )
        ax.set(xlabel="Angular frequency ω, rad/s", ylabel="Position per force on robot 1, m/N")
        ax.margins(x=0.0)
        ax.legend()
    return ax


def _given_or_new_axes(ax: Axes | None, size: tuple[float, float]) -> Axes:
    if ax is not None:
        return ax
    from matplotlib import pyplot as plt

    return plt.subplots(figsize=size, layout="constrained")[1]


def _map_extent(dyad: Dyad, star: StudyMark | None) -> tuple[float, float]:
    """Choose the largest stiffness (N/m) and delay (s) of a map."""
    critical = min(axis.critical_stiffness() for axis in dyad)
    if not 0.0 < critical < math.inf:
        # Operators can make every stiffness safe, or a robot has no damping: then by Eq. 5.
        critical = min(DyadAxis(*axis.parameters).critical_stiffness("paper") for axis in dyad)
    widest = max(4.6 * critical, 0.0 if star is None else 1.15 * star.stiffness) or 100.0
    delay = min(float(axis.maximum_delay(0.5 * widest)) for axis in dyad)
    longest = 2.4 * delay if 0.0 < delay < math.inf else 0.5
    return widest, max(longest, 0.0 if star is None else 1.15 * star.longest_delay)
