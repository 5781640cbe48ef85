"""The figure of a live session, from its dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from telespring.show.figures.session import SessionPanels, session_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from telespring.recording import MarkedTrial

__all__ = ["draw_session"]

#: Events that a reader looks for; the others are in the table.
_SHOWN = {
    "running",
    "paused",
    "leaving",
    "ended",
    "holding",
    "ramping-out",
    "ramping-in",
    "disengaged",
    "engaged",
    "emergency-stop",
    "path-changed",
    "path-lost",
    "recording-missed",
}


def draw_session(session: xr.Dataset, trials: Sequence[MarkedTrial] = ()) -> Figure:
    """Draw handles and target, forces, ages and accounts of a session over time, with its events and trials."""
    events = [
        (float(time), f"{name} ({robot})")
        for time, name, robot in zip(
            session["event_time"].values,
            session["event_name"].values,
            session["event_robot"].values,
            strict=True,
        )
        if name in _SHOWN
    ]
    force = np.asarray(session["coupling_force"])
    received = [
        str(robot)
        for robot, source in zip(session["robot"].values, session["source"].values, strict=True)
        if source == "received"
    ]
    return session_figure(
        SessionPanels(
            time=np.asarray(session["time"]),
            position=np.asarray(session["position"]),
            target=np.asarray(session["target"]),
            force=np.hypot(force[..., 0], force[..., 1]),
            age=np.asarray(session["age"]),
            account=np.asarray(session["account"]),
            events=events,
            trials=[(trial.begin, trial.end, trial.label) for trial in trials if trial.is_marked],
            note=f"Robot {received[0]} as its packets told: its site's recording is missing." if received else "",
        )
    )
