"""What the figures of one dyad share: checked settings, and axes to draw on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from telespring._core import check_usual
from telespring._errors import InvalidInput

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["check_settings", "given_or_new_axes"]


def check_settings(
    stiffnesses: Mapping[str, float | None], delays: Mapping[str, float | None], allow_unusual: bool
) -> None:
    """Refuse values below 0 or not finite, and what no laboratory has: its unit is probably wrong."""
    for name, quantity, unit, value in (
        *((name, "stiffness", "N/m", stiffness) for name, stiffness in stiffnesses.items()),
        *((name, "delay", "s", delay) for name, delay in delays.items()),
    ):
        if value is None:
            continue
        if not (math.isfinite(value) and value >= 0.0):
            raise InvalidInput(
                name, f"{value:g} {unit}", f"a {quantity} of 0 {unit} or more is required", "Correct it."
            )
        if allow_unusual:
            continue
        try:
            check_usual(quantity, name, float(value))
        except InvalidInput as refused:
            meant, is_possible, _ = refused.remedy.partition("If it is meant")
            remedy = f"{meant}If it is meant, pass allow_unusual=True." if is_possible else refused.remedy
            raise InvalidInput(refused.field, refused.value, refused.allowed, remedy) from None


def given_or_new_axes(ax: Axes | None, size: tuple[float, float]) -> Axes:
    """Return the axes given, or those of a new figure of pyplot of this size, inch."""
    if ax is not None:
        return ax
    from matplotlib import pyplot as plt

    return plt.subplots(figsize=size, layout="constrained")[1]
