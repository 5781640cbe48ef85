"""The strategies of a study or a comparison in words."""

from __future__ import annotations

import re

from telespring._core import Architecture

__all__ = ["describe_strategy", "name_strategy"]

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

#: What they do to the force of the spring; docs/strategies.md says for which networks and hands each holds.
_DEEDS = {
    "spring": "nothing limits the force of the spring",
    "guard": "where the spring would give out more energy than its account holds, the guard gives less force",
    "injected-damping": "a damper on each handle is sized for the delays of the network",
    "wave-variables": "the handles are joined by a virtual line instead of the spring",
    "time-domain-passivity": "no more energy may come out at a handle than went in at the other",
    "two-layer": "a tank of energy on each side limits the force of the spring",
    "set-position-modulation": "the spring's end jumps only as far as a reservoir of energy pays",
}


def name_strategy(label: str) -> str:
    """Name a strategy with its predictor and play-out, from its label in a comparison.

    Examples
    --------
    >>> name_strategy("guard + shared-target"), name_strategy("spring, adaptive"), name_strategy("guard (2)")
    ('guard + shared target', 'bare spring, adaptive', 'guard (2)')
    """
    return "".join(_WORDS.get(part, part) for part in re.split(r"( \+ |, | \(\d+\)$)", label))


def describe_strategy(session: Architecture) -> str:
    """Describe what the session's strategy does to the spring's force, without a full stop.

    Examples
    --------
    >>> import telespring as ts
    >>> describe_strategy(ts.Architecture(strategy="two-layer"))
    'a tank of energy on each side limits the force of the spring'
    """
    return _DEEDS[session.strategy]
