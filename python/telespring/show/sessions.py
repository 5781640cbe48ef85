"""What both sides of a session do with the partner's motion, in words."""

from __future__ import annotations

from telespring._core import Architecture

__all__ = ["describe_bare_verdict", "describe_strategy"]

#: docs/strategies.md says for which networks and hands each holds.
_STRATEGIES = {
    "spring": "nothing limits the force of the spring",
    "guard": "where the spring would give out more energy than its account holds, the guard gives less force",
    "injected-damping": "a damper on each handle is sized for the delays of the network",
    "wave-variables": "the handles are joined by a virtual line instead of the spring",
    "time-domain-passivity": "no more energy may come out at a handle than went in at the other",
    "two-layer": "a tank of energy on each side limits the force of the spring",
    "set-position-modulation": "the spring's end jumps only as far as a reservoir of energy pays",
}


def describe_strategy(session: Architecture) -> str:
    """Describe what the session's strategy does to the spring's force, without a full stop.

    Examples
    --------
    >>> import telespring as ts
    >>> describe_strategy(ts.Architecture(strategy="two-layer"))
    'a tank of energy on each side limits the force of the spring'
    """
    return _STRATEGIES[session.strategy]


def describe_bare_verdict(session: Architecture) -> str | None:
    """Say that a verdict is one on the bare spring, and what the study runs; None if it is that spring.

    Examples
    --------
    >>> import telespring as ts
    >>> describe_bare_verdict(ts.Architecture(strategy="guard", predictor="linear"))
    'This is the answer for the bare spring with a fixed play-out. The study runs guard + linear: where ...'
    """
    if session == Architecture():
        return None
    return (
        "This is the answer for the bare spring with a fixed play-out. "
        f"The study runs {session.label}: {describe_strategy(session)}."
    )
