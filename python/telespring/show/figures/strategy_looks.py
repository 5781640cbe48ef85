"""How every figure of a comparison tells the strategies apart: colour, marker and line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.typing import LineStyleType

from telespring.show.figures.style import COLOURS, GREY

__all__ = ["StrategyLook", "looks_of_strategies"]

_DASHED: LineStyleType = (0.0, (4.5, 1.6))
_DOTTED: LineStyleType = (0.0, (1.2, 1.4))
_DASH_DOTTED: LineStyleType = (0.0, (5.0, 1.4, 1.2, 1.4))


@dataclass(frozen=True)
class StrategyLook:
    """Colour, marker and line of one strategy, the same in every figure of a comparison."""

    colour: str
    marker: str
    line: LineStyleType
    width: float = 1.0


#: The strategies that a comparison has by default; the bare spring and the shared target stand out.
_LOOKS = {
    "spring": StrategyLook(COLOURS["black"], "X", "solid", 1.5),
    "spring, adaptive": StrategyLook(GREY, "P", _DASHED),
    "guard": StrategyLook(COLOURS["blue"], "v", _DASHED, 1.3),
    "guard + linear": StrategyLook(COLOURS["orange"], "<", _DASHED),
    "guard + kalman": StrategyLook(COLOURS["purple"], ">", "solid"),
    "guard + shared-target": StrategyLook(COLOURS["green"], "o", "solid", 1.8),
    "injected-damping": StrategyLook(COLOURS["vermilion"], "s", _DOTTED),
    "wave-variables": StrategyLook(COLOURS["sky"], "D", "solid"),
    "time-domain-passivity": StrategyLook(COLOURS["sky"], "^", _DOTTED),
    "two-layer": StrategyLook(COLOURS["purple"], "h", _DOTTED),
    "set-position-modulation": StrategyLook(COLOURS["vermilion"], "p", _DASH_DOTTED),
}
_MORE = tuple(
    StrategyLook(colour, marker, line)
    for line, marker in ((_DASH_DOTTED, "*"), (_DOTTED, "d"), (_DASHED, "H"), ("solid", "8"))
    for colour in (
        COLOURS["blue"],
        COLOURS["orange"],
        COLOURS["green"],
        COLOURS["purple"],
        COLOURS["vermilion"],
        GREY,
    )
)


def looks_of_strategies(labels: Sequence[str]) -> dict[str, StrategyLook]:
    """Give every label of a comparison a look, each its own up to two dozen beyond the usual ones."""
    others = [label for label in labels if label not in _LOOKS]
    return {
        label: _LOOKS[label] if label in _LOOKS else _MORE[others.index(label) % len(_MORE)]
        for label in labels
    }
