"""A session in a few numbers, for programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from telespring.connection.session import Line, LiveSession

__all__ = ["outcome", "recording_path"]


def outcome(session: LiveSession, status: int) -> dict[str, Any]:
    """Return what a session was: numbers in SI units, of two sides the worse; None is not known.

    `status` is the exit status of the program. `docs/connect.md` describes the keys.
    """
    sites = session.sites
    recordings = [path for site in sites if (path := recording_path(site)) is not None]
    events = [{"side": site.get("side"), **event} for site in sites for event in site.get("events", [])]
    return {
        "schema": 1,
        "status": status,
        "round_trip": _worst(sites, "round_trip", "latest"),
        "age": _worst(sites, "age", "mean"),
        "loss": _worst(sites, "loss", "share"),
        "lateness": _worst(sites, "lateness", "quantile_99"),
        "te": _worst(sites, "te"),
        "limited_share": _worst(sites, "limited_share"),
        "events": sorted(events, key=lambda event: float(event["time"])),
        "recording": recordings[0] if recordings else None,
        "recordings": recordings,
        "sites": sites,
    }


def recording_path(site: Line) -> str | None:
    """Return the path of a side's recording, if it has one."""
    recording = site.get("recording")
    path = recording.get("path") if isinstance(recording, dict) else recording
    return path if isinstance(path, str) else None


def _worst(sites: Iterable[Line], *keys: str) -> float | None:
    values = []
    for site in sites:
        value: Any = site
        for key in keys:
            value = value.get(key) if isinstance(value, dict) else None
        if isinstance(value, int | float):
            values.append(float(value))
    return max(values, default=None)
