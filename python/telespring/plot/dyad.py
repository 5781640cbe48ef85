"""Figures of one condition of a dyad: how it moves, its loop and its response."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from telespring.model import Dyad
from telespring.plot.settings import check_settings, given_or_new_axes
from telespring.show.figures.nyquist import NyquistPanel, draw_nyquist_locus
from telespring.show.figures.responses import draw_motion, motion_legend
from telespring.show.figures.style import DASHES, ROBOT_COLOURS, figure_style
from telespring.theory.response import frequency_response as compute_frequency_response
from telespring.theory.response import nyquist as compute_nyquist

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

__all__ = ["frequency_response", "nyquist", "response"]


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
        ax = given_or_new_axes(ax, (5.2, 3.0))
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
        Whether stiffnesses and delays that no laboratory has are meant: by default they are refused, because
        their unit is probably wrong.
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
    check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    locus = compute_nyquist(dyad, stiffness, delay, axis=axis)
    stable = dyad[axis].is_stable(stiffness, delay)
    note = "stable" if stable else f"unstable, {locus.encirclements} encirclements of −1"
    values = np.asarray(locus.locus)
    with figure_style():
        ax = given_or_new_axes(ax, (3.8, 3.8))
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
    check_settings({"stiffness": stiffness}, {"delay": delay}, allow_unusual)
    computed = compute_frequency_response(dyad, stiffness, delay, frequency, axis=axis)
    with figure_style():
        ax = given_or_new_axes(ax, (5.2, 3.0))
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
