"""Stability boundary of a dyad whose handles are held by two agents' arms.

The paper's criterion assumes free handles, but in its experiment an agent holds each of them with an arm
whose force is k_c (p* - p), Eqs. 13 and 14. To the dyad this is a spring to the ground, and the criterion
with grounded operators applies. By default the arms are massless and undamped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from telespring._json import finite_or_none
from telespring.model import Dyad, DyadAxis, Operator
from telespring.paper.published import AGENT_STIFFNESS
from telespring.paper.reference import classify
from telespring.show.quantities import format_pair

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from telespring.show.figures import StudyMark

__all__ = ["ArmsBoundary", "BoundaryOfAxis", "boundary_in_arms", "draw_arms_boundary"]

Intervals = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class BoundaryOfAxis:
    """Stable delays of one axis with free handles and in arms.

    Attributes
    ----------
    free, held
        The axis without and with the agents' stiffness.
    stable_free, stable_held
        For each stiffness all stable one-way delays up to the horizon, half-open intervals, s.
    unstable_held
        For each stiffness the intervals between them, in arms, s, cut at the horizon.
    """

    free: DyadAxis
    held: DyadAxis
    stable_free: tuple[Intervals, ...]
    stable_held: tuple[Intervals, ...]
    unstable_held: tuple[Intervals, ...]


@dataclass(frozen=True)
class AxisVerdicts:
    """The axes on which a condition is unstable, and those on which it is marginal, by name."""

    unstable: list[str]
    marginal: list[str]

    @classmethod
    def on(cls, axes: Sequence[DyadAxis], stiffness: float, delay: float) -> AxisVerdicts:
        """Judge one condition, N/m and s, on every axis."""
        verdicts = {axis.name: classify(axis, stiffness, delay) for axis in axes}
        return cls(
            [name for name, verdict in verdicts.items() if verdict == "unstable"],
            [name for name, verdict in verdicts.items() if verdict == "marginal"],
        )

    @property
    def word(self) -> Literal["stable", "marginal", "unstable"]:
        """The worst verdict of any axis."""
        return "unstable" if self.unstable else "marginal" if self.marginal else "stable"

    def __str__(self) -> str:
        axes = self.unstable or self.marginal
        return f"{self.word} on {' and '.join(axes)}" if axes else self.word


@dataclass(frozen=True)
class ArmsBoundary:
    """Stability boundaries of a dyad with free handles and in arms.

    Attributes
    ----------
    agent_stiffness
        Of agent 1 and 2, N/m.
    stiffnesses
        Of the virtual spring, N/m.
    horizon
        Longest one-way delay considered, s.
    axes
        One entry per axis of the dyad.
    conditions
        Stiffness (N/m) and one-way delay (s) of an experiment.
    """

    agent_stiffness: tuple[float, float]
    stiffnesses: tuple[float, ...]
    horizon: float
    axes: tuple[BoundaryOfAxis, ...]
    conditions: tuple[tuple[float, float], ...]

    def numbers(self) -> dict[str, Any]:
        """Boundary in arms for JSON, in SI units; None if there is no bound."""
        return {
            "agent_stiffness": list(self.agent_stiffness),
            "horizon": self.horizon,
            "axes": [
                {
                    "axis": axis.free.name,
                    "critical_stiffness_free": finite_or_none(axis.free.critical_stiffness()),
                    "critical_stiffness_in_arms": finite_or_none(axis.held.critical_stiffness()),
                    "stiffnesses": [
                        {
                            "stiffness": stiffness,
                            "stable_delays_free": [list(interval) for interval in axis.stable_free[i]],
                            "stable_delays_in_arms": [list(interval) for interval in axis.stable_held[i]],
                            "unstable_delays_in_arms": [list(interval) for interval in axis.unstable_held[i]],
                        }
                        for i, stiffness in enumerate(self.stiffnesses)
                    ],
                }
                for axis in self.axes
            ],
            "conditions": [
                {
                    "stiffness": stiffness,
                    "delay": delay,
                    "free": free.word,
                    "in_arms": held.word,
                    "unstable_axes_free": free.unstable,
                    "unstable_axes_in_arms": held.unstable,
                    "marginal_axes_free": free.marginal,
                    "marginal_axes_in_arms": held.marginal,
                }
                for (stiffness, delay), free, held in self._verdicts()
            ],
            "statements": self.statements(),
        }

    def statements(self) -> list[str]:
        """Write sentences on the effect of the arms on the boundary and on the conditions."""
        sentences = []
        for axis in self.axes:
            free, held = axis.free, axis.held
            same = (held.masses, held.dampings) == (free.masses, free.dampings)
            arms = "" if same else " and the arms' mass and damping"
            sentences.append(
                f"Axis {free.name}: held by {format_pair(self.agent_stiffness, 'N/m')}{arms}, the dyad is "
                f"stable at every constant delay up to {held.critical_stiffness():.1f} N/m; with free "
                f"handles, up to {free.critical_stiffness():.1f} N/m."
            )
            for stiffness, windows in zip(self.stiffnesses, axis.unstable_held, strict=True):
                if windows:
                    stability = "unstable at one-way delays in " + " and ".join(
                        _format_unstable_window(window, self.horizon) for window in windows
                    )
                elif stiffness < held.critical_stiffness():
                    stability = "stable at every constant delay"
                else:
                    stability = f"stable at every constant delay up to {1e3 * self.horizon:.0f} ms"
                sentences.append(f"Axis {free.name} with arms at {stiffness:.4g} N/m: {stability}.")
        sentences += [
            f"Condition {stiffness:.0f} N/m, {1e3 * delay:.0f} ms: "
            f"{free} with free handles, {held} with arms."
            for (stiffness, delay), free, held in self._verdicts()
            if (free.word, held.word) != ("stable", "stable")
        ]
        return sentences

    def _verdicts(self) -> list[tuple[tuple[float, float], AxisVerdicts, AxisVerdicts]]:
        return [
            (
                condition,
                AxisVerdicts.on([axis.free for axis in self.axes], *condition),
                AxisVerdicts.on([axis.held for axis in self.axes], *condition),
            )
            for condition in self.conditions
        ]


def boundary_in_arms(
    dyad: Dyad,
    stiffnesses: Sequence[float],
    *,
    agent_stiffness: tuple[float, float] = (AGENT_STIFFNESS, AGENT_STIFFNESS),
    arms: tuple[Operator, Operator] | None = None,
    conditions: Sequence[tuple[float, float]] = (),
    horizon: float = 1.0,
) -> ArmsBoundary:
    """Compute the stable delays of a dyad with free handles and held by two agents' arms.

    Parameters
    ----------
    dyad
        The robots; the agents' stiffness is added to their operators, if any.
    stiffnesses
        Of the virtual spring, N/m.
    agent_stiffness
        k_c of agent 1 and 2, N/m; by default that of Table III, 120 N/m.
    arms
        Mass and damping of both arms and of the agents' dampers, and any stiffness besides
        `agent_stiffness`; by default massless and undamped.
    conditions
        Stiffness (N/m) and one-way delay (s) of an experiment, to be assessed.
    horizon
        Longest one-way delay to consider, s.

    Returns
    -------
    ArmsBoundary
        Both boundaries, unrounded.

    Raises
    ------
    telespring.InvalidInput
        If a value is out of its range.

    Examples
    --------
    >>> import telespring as ts
    >>> boundary = boundary_in_arms(ts.hman(), [71.23, 142.46])
    >>> [[(round(a, 3), round(b, 3)) for a, b in axis.unstable_held[1][:1]] for axis in boundary.axes]
    [[(0.078, 0.153)], [(0.118, 0.167)]]
    >>> [axis.unstable_held[0] for axis in boundary.axes]
    [(), ()]
    """
    axes = []
    dyad_in_arms = _with_arms(dyad, agent_stiffness, arms)
    for name in dyad.axes:
        free, held = dyad[name], dyad_in_arms[name]
        stable_held = tuple(tuple(held.stable_delays(k, horizon)) for k in stiffnesses)
        axes.append(
            BoundaryOfAxis(
                free=free,
                held=held,
                stable_free=tuple(tuple(free.stable_delays(k, horizon)) for k in stiffnesses),
                stable_held=stable_held,
                unstable_held=tuple(_unstable_delays(stable, horizon) for stable in stable_held),
            )
        )
    return ArmsBoundary(
        agent_stiffness, tuple(map(float, stiffnesses)), float(horizon), tuple(axes), tuple(conditions)
    )


def draw_arms_boundary(boundary: ArmsBoundary, *, mark: StudyMark | None = None, points: int = 331) -> Figure:
    """Draw both boundaries over stiffness and delay with the conditions, one panel per axis.

    Up to 165 N/m and 0.6 s, or as much as the conditions and the study need; `points` is the number of
    stiffnesses, `mark` the study itself.
    """
    from telespring.show import figures

    shown = [*boundary.conditions, *([] if mark is None else [(mark.stiffness, mark.longest_delay)])]
    widest = max(165.0, *(1.1 * k for k, _ in shown), 0.0)
    longest = max(0.6, *(1.1 * delay for _, delay in shown), 0.0)
    stiffness = np.linspace(0.0, widest, points + 1)[1:]
    panels = [
        figures.ArmsPanel(
            axis.held.name,
            [
                figures.MapColumn(float(k), axis.held.stable_delays(float(k), figures.HORIZON * longest))
                for k in stiffness
            ],
            axis.free.maximum_delay(stiffness),
            [(k, delay, axis.held.is_stable(k, delay)) for k, delay in boundary.conditions],
        )
        for axis in boundary.axes
    ]
    return figures.arms_figure(panels, longest=longest, mark=mark)


def _with_arms(
    dyad: Dyad, agent_stiffness: tuple[float, float], arms: tuple[Operator, Operator] | None
) -> Dyad:
    """Add springs and arms to the dyad's own operators."""
    axes = np.ones(len(dyad.axes))
    first, second = (
        Operator(
            (own.mass + arm.mass) * axes,
            (own.damping + arm.damping) * axes,
            (own.stiffness + arm.stiffness + spring) * axes,
        )
        for own, arm, spring in zip(
            dyad.operators, arms or (Operator(), Operator()), agent_stiffness, strict=True
        )
    )
    return Dyad(*dyad.robots, (first, second), dyad.coupling_damping)


def _unstable_delays(stable: Intervals, horizon: float) -> Intervals:
    starts = (0.0, *(end for _, end in stable))
    ends = (*(start for start, _ in stable), horizon)
    return tuple((start, end) for start, end in zip(starts, ends, strict=True) if end > start)


def _format_unstable_window(window: tuple[float, float], horizon: float) -> str:
    start, end = (1e3 * delay for delay in window)
    return f"({start:.0f}, {end:.0f}) ms" if window[1] < horizon else f"({start:.0f} ms, beyond the horizon)"
