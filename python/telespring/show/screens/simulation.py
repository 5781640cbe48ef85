"""The summary that `telespring simulate` prints."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rich.markup import escape

from telespring.model import Dyad
from telespring.theory.axis import axes_of
from telespring.theory.spectrum import spectral_abscissa

if TYPE_CHECKING:
    import xarray

__all__ = ["simulation_summary"]

#: A distance, mm, that no two robots in a dyad ever have: 1 km.
_RUNAWAY = 1e6


def simulation_summary(
    found: xarray.Dataset,
    dyad: Dyad,
    name: str,
    stiffness: float,
    delay: tuple[float, float],
    forces: Sequence[Sequence[float]],
) -> Iterator[str]:
    """Yield the lines, in rich's markup, that sum up a simulation under steps of force."""
    import numpy as np

    time, position = np.asarray(found["time"]), np.asarray(found["position"])
    yield f"[bold]{escape(name)}[/bold]"
    yield f"{stiffness:.4g} N/m, {len(time)} samples over {time[-1]:.4g} s"
    diverged = found.attrs.get("diverged_at")
    if diverged is not None and math.isfinite(float(diverged)):
        yield (
            f"[bold red]Diverged at {float(diverged):.4g} s[/bold red]: a position was over 1e12 m, the "
            "file ends before it."
        )
    for i, axis in enumerate(dyad.axes):
        apart = position[:, 0, i] - position[:, 1, i]
        apart = apart[np.isfinite(apart)]
        abscissa = float(spectral_abscissa(dyad, stiffness, delay, axis=i))
        largest = 1e3 * float(np.max(np.abs(apart)))
        if largest > _RUNAWAY:
            yield f"  axis {escape(axis)}: unstable, the robots run away from each other"
            continue
        text = f"  axis {escape(axis)}: apart {1e3 * apart[-1]:.4g} mm at the end, at most {largest:.4g} mm"
        rest = _rest_distance(dyad, stiffness, forces, i)
        if abscissa >= 0.0:
            text += ", unstable: it does not come to rest"
        elif rest is not None:
            overshoot = 100.0 * (largest / abs(1e3 * rest) - 1.0)
            text += f"; at rest {1e3 * rest:.4g} mm, overshoot {max(0.0, overshoot):.3g} %"
        yield text


def _rest_distance(
    dyad: Dyad, stiffness: float, forces: Sequence[Sequence[float]], axis: int
) -> float | None:
    """Distance (m) of free robots at rest under opposite steps; None in other cases."""
    one, other = forces[0][axis], forces[1][axis]
    if one == 0.0 or one != -other or axes_of(dyad)[axis].ground_stiffnesses != (0.0, 0.0):
        return None
    return one / stiffness
