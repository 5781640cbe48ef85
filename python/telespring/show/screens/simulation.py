"""The summary that `telespring simulate` prints."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.markup import escape

from telespring.model import Dyad
from telespring.show.quantities import format_number

if TYPE_CHECKING:
    import xarray

__all__ = ["simulation_summary"]

#: A distance between the handles, m, that only an unstable dyad reaches.
_RUNAWAY = 1e3


def simulation_summary(
    motion: xarray.Dataset,
    dyad: Dyad,
    name: str,
    stiffness: float,
    delay: tuple[float, float],
    forces: Sequence[Sequence[float]],
) -> Iterator[str]:
    """Yield a heading and one line per axis, in rich's markup, for a simulation under a step of force."""
    time, position = np.asarray(motion["time"]), np.asarray(motion["position"])
    yield f"[bold]{escape(name)}[/bold]"
    yield (
        f"{format_number(stiffness)} N/m, {len(time)} samples over {format_number(time[-1])} s; "
        "distance between the handles:"
    )
    diverged = motion.attrs.get("diverged_at")
    if diverged is not None and math.isfinite(float(diverged)):
        yield (
            f"[bold red]Diverged at {format_number(diverged)} s[/bold red]: a position exceeded 1e12 m, and "
            "the file ends before it."
        )
    for axis in dyad:
        apart = position[:, 0, axis.index] - position[:, 1, axis.index]
        apart = apart[np.isfinite(apart)]
        largest = float(np.max(np.abs(apart)))
        if largest > _RUNAWAY:
            yield f"  axis {escape(axis.name)}: unstable, the robots drift apart without limit"
            continue
        text = f"  axis {escape(axis.name)}: ends at {_distance_mm(apart[-1])}, peak {_distance_mm(largest)}"
        rest = None
        one, other = forces[0][axis.index], forces[1][axis.index]
        if one != 0.0 and one == -other and axis.ground_stiffness == (0.0, 0.0):
            rest = one / stiffness  # free robots under opposite steps
        if axis.spectral_abscissa(stiffness, delay) >= 0.0:
            text += ", unstable: it does not come to rest"
        elif rest is not None:
            overshoot = max(0.0, 100.0 * (largest / abs(rest) - 1.0))
            text += f"; rests at {_distance_mm(rest)}, overshoot {format_number(overshoot, 3)} %"
        yield text


def _distance_mm(length: float) -> str:
    return f"{format_number(length, shift=3)} mm"
