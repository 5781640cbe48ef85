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

#: Events that a reader looks for; the others are in the table. A state that begins is named by its word.
_STATE = "phase"
_SHOWN = {
    _STATE,
    "emergency-stop",
    "network-pause",
    "softened",
    "restored",
    "delay-too-short",
    "holding",
    "disengaged",
    "partner-restarted",
    "path-changed",
    "path-lost",
    "recording-missed",
    "recording-broken",
}
#: States that the figure names: from the first on the spring acts, or has acted.
_STATES = {"running", "ramping-out", "paused", "stopped", "ended"}


def draw_session(session: xr.Dataset, trials: Sequence[MarkedTrial] = ()) -> Figure:
    """Draw handles and target, forces, ages and accounts of a session over time, with events and trials."""
    events = _named_events(session)
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
            trials=[
                (trial.begin, trial.end, f"trial {trial.label}"[:20]) for trial in trials if trial.is_marked
            ],
            note=f"Robot {received[0]} as its packets told: its site's recording is missing."
            if received
            else "",
        )
    )


def _named_events(session: xr.Dataset) -> list[tuple[float, str]]:
    """Name the events of the figure with their sites; what both sites say within 0.2 s is said once."""
    named: list[tuple[float, str, list[int]]] = []
    for time, event, cause, robot in zip(
        session["event_time"].values,
        session["event_name"].values,
        session["event_cause"].values,
        session["event_robot"].values,
        strict=True,
    ):
        name = cause if event == _STATE else event
        if event not in _SHOWN or (event == _STATE and cause not in _STATES):
            continue
        before = next((one for one in reversed(named) if one[1] == name and time - one[0] < 0.2), None)
        if before is not None and int(robot) not in before[2]:
            before[2].append(int(robot))
        else:
            named.append((float(time), str(name), [int(robot)]))
    return [(time, f"{name} ({', '.join(map(str, sorted(sides)))})") for time, name, sides in named]
