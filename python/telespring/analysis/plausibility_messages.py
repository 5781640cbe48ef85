"""The sentences that `analysis.json` holds for trials that look wrong."""

from __future__ import annotations

from telespring._quantities import format_count, format_number, format_time
from telespring.analysis.coordinates import CENTIMETRES, MILLIMETRES
from telespring.analysis.plausibility import (
    Implausible,
    ShortTrial,
    Spikes,
    StillHandle,
    SuspectCoordinates,
)

__all__ = ["implausible_trial_warning"]

#: So many trials are named one by one.
_NAMED = 3


def implausible_trial_warning(implausible: Implausible) -> str:
    """Write the sentence for trials that look cut off, stuck, or recorded in other coordinates."""
    if isinstance(implausible, SuspectCoordinates):
        return _coordinate_warning(implausible)
    trial = _capitalised(implausible.trial)
    if isinstance(implausible, ShortTrial):
        return (
            f"{trial} counts as completed after {format_time(implausible.duration)}, although "
            f"{format_time(implausible.usual_duration)} is usual: if it was cut off, set its status to "
            "stopped."
        )
    robot = f"{trial}: the handle of robot {implausible.robot}"
    if isinstance(implausible, Spikes):
        return (
            f"{robot} leaves its path for {format_count(implausible.count, 'single sample')}, the furthest "
            f"by {_format_length(implausible.size)} at {format_number(implausible.time)} s. They enter the "
            "tracking error: correct them in the file, or set the trial's status to stopped."
        )
    since = "" if implausible.since is None else f"from {format_number(implausible.since)} s"
    if isinstance(implausible, StillHandle):
        found = (
            f"does not move {f'{since} to its end' if since else 'throughout'}, but is analysed as if it had "
            "followed the target"
        )
    else:
        found = (
            f"stays exactly where it is for {format_time(implausible.duration)} {since}, then jumps by "
            f"{_format_length(implausible.jump)}"
        )
    return (
        f"{robot} {found}. Was its sensor stuck? Then set the trial's status to stopped, which leaves it out."
    )


def _coordinate_warning(suspect: SuspectCoordinates) -> str:
    count, of = len(suspect.trials), format_count(suspect.of, "completed trial")
    if suspect.is_systematic:
        shown = f"Robot {suspect.robot}, in {count} of {of}: "
    elif count == 1:
        shown = f"{_capitalised(suspect.trials[0])}, robot {suspect.robot}: "
    else:
        more = "" if count <= _NAMED else f" and {count - _NAMED} more"
        shown = f"Robot {suspect.robot}, in {count} of {of} ({', '.join(suspect.trials[:_NAMED])}{more}): "
    if suspect.kind == "offset":
        return (
            f"{shown}the path is centred {_format_length(float(suspect.value))} beside the target. Are its "
            "positions in the coordinates of the target?"
        )
    if suspect.kind == "axes":
        return f"{shown}the path fits the target only if {suspect.value}. Check its columns and their signs."
    ratio = float(suspect.value)
    longer, factor = ("further", ratio) if ratio > 1.0 else ("less far", 1.0 / ratio)
    unit = "in mm" if factor >= MILLIMETRES else "in cm" if factor > CENTIMETRES else "in another unit"
    which = "its positions" if ratio > 1.0 else "the target's positions"
    return (
        f"{shown}the handle moves {format_number(factor, 3)} times {longer} than the target. Are {which} "
        f"{unit}, instead of m?"
    )


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]


def _format_length(length: float) -> str:
    return f"{format_number(length, 3, shift=3)} mm"
