"""The figure of a recorded trace, from its assessment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from telespring.show.figures.trace import FittedCurve, StiffnessCurve, TracePanels, trace_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from telespring._types import Tier
    from telespring.traces import TraceAssessment

__all__ = ["draw_trace"]

_TIERS: tuple[Tier, ...] = ("constant delay", "age in a range", "bounded varying delay", "any network")
_NAMES = {"lognormal": "log-normal"}
_POINTS = 400


def draw_trace(found: TraceAssessment) -> Figure:
    """Draw the first way's delays and fits, and what each play-out allows."""
    way = found.ways[0]
    delay = np.linspace(way.statistics.minimum, way.statistics.maximum, _POINTS)
    if way.statistics.minimum > 0.0:
        delay = np.geomspace(way.statistics.minimum, way.statistics.maximum, _POINTS)
    fits = [
        FittedCurve(_NAMES.get(fit.kind, fit.kind), delay, 1.0 - fit.cumulative(delay))
        for fit in way.fit.jitter
    ]
    delays = np.array([choice.delay for choice in found.playouts])
    tiers = []
    for tier in _TIERS:
        bounds = [choice.bounds.get(tier) for choice in found.playouts]
        stiffness = np.array([np.nan if bound is None else bound for bound in bounds])
        stiffness[~np.isfinite(stiffness)] = np.nan
        if np.isfinite(stiffness).any():
            tiers.append(StiffnessCurve(tier, delays, stiffness))
    best = found.recommended
    return trace_figure(
        TracePanels(
            name="forward" if len(found.ways) > 1 else "",
            time=way.trace.time,
            delay=way.trace.delay,
            fits=fits,
            tiers=tiers,
            recommended=(best.delay, best.recommended_stiffness),
        )
    )
