"""The sentences that `analysis.json` holds for trials that look wrong."""

from __future__ import annotations

from telespring.analysis.plausibility import (
    FrozenHandle,
    Implausible,
    ShortTrial,
    Spikes,
    StillHandle,
    SuspectCoordinates,
)

__all__ = ["implausible_trial_warning"]


def implausible_trial_warning(implausible: Implausible) -> str:
    """Write the sentence for trials that look cut off, stuck, or recorded in other coordinates."""
    if isinstance(implausible, SuspectCoordinates):
        return _coordinate_warning(implausible)
    trial = f"Trial {implausible.trial} of {implausible.condition}"
    if isinstance(implausible, ShortTrial):
        return (
            f"{trial} counts as completed after {implausible.duration:.4g} s, although "
            f"{implausible.usual_duration:.4g} s is usual: if it was cut off, set its status to stopped."
        )
    handle = f"the handle of robot {implausible.robot}"
    if isinstance(implausible, StillHandle):
        period = "throughout" if implausible.since is None else f"from {implausible.since:.4g} s to its end"
        return (
            f"{trial}: {handle} does not move {period}, but is analysed as if it had followed the target. "
            "Was its sensor stuck? Then set the trial's status to stopped, so that it is left out."
        )
    if isinstance(implausible, FrozenHandle):
        return (
            f"{trial}: {handle} stays exactly where it is for {1e3 * implausible.duration:.4g} ms from "
            f"{implausible.since:.4g} s, then jumps by {1e3 * implausible.jump:.3g} mm. "
            "Was the sensor stuck? Then set the trial's status to stopped, so that it is left out."
        )
    assert isinstance(implausible, Spikes)
    return (
        f"{trial}: {handle} leaves its path for single samples ({implausible.count}), the furthest by "
        f"{1e3 * implausible.size:.3g} mm at {implausible.time:.4g} s. They enter the tracking error."
    )


def _coordinate_warning(suspect: SuspectCoordinates) -> str:
    shown = f"Robot {suspect.robot}, in {suspect.trials} of {suspect.of} completed trials: "
    if suspect.kind == "offset":
        return (
            f"{shown}the path is centred {1e3 * float(suspect.value):.3g} mm beside the target. Are its "
            "positions in the coordinates of the target?"
        )
    if suspect.kind == "axes":
        return f"{shown}the path fits the target only if {suspect.value}. Check its columns and their signs."
    ratio = float(suspect.value)
    longer, factor = ("further", ratio) if ratio > 1.0 else ("less far", 1.0 / ratio)
    unit = "in cm" if 30.0 < factor < 300.0 else "in mm" if factor >= 300.0 else "in another unit"
    which = "its positions" if ratio > 1.0 else "the target's positions"
    return (
        f"{shown}the handle moves {factor:.3g} times {longer} than the target. Are {which} {unit}, "
        "instead of m?"
    )
