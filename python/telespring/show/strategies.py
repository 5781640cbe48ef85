"""The strategies of a comparison in words."""

from __future__ import annotations

import re

__all__ = ["name_strategy"]

#: What the words of a study file are called.
_WORDS = {
    "spring": "bare spring",
    "guard": "guard",
    "injected-damping": "damping injection",
    "wave-variables": "wave variables",
    "time-domain-passivity": "time-domain passivity",
    "two-layer": "two layers",
    "set-position-modulation": "set-position modulation",
    "kalman": "Kalman",
    "shared-target": "shared target",
}


def name_strategy(label: str) -> str:
    """Name a strategy with its predictor and play-out, from its label in a comparison.

    Examples
    --------
    >>> name_strategy("guard + shared-target"), name_strategy("spring, adaptive"), name_strategy("guard (2)")
    ('guard + shared target', 'bare spring, adaptive', 'guard (2)')
    """
    return "".join(_WORDS.get(part, part) for part in re.split(r"( \+ |, | \(\d+\)$)", label))
