"""The words of the live program in plain sentences: states, events, causes, and what limits the force."""

from __future__ import annotations

from telespring.connection import Line
from telespring.show.quantities import format_number

__all__ = ["describe_cause", "describe_event", "describe_limits", "describe_phase", "describe_watchdog"]

_PHASES = {
    "connecting": "waiting for the partner",
    "greeting": "waiting for the partner",
    "homing": "waiting for the robots: home and enable them",
    "aligning": "align the handles",
    "consenting": "waiting for consent",
    "ramping-in": "force ramps in",
    "running": "running",
    "paused": "paused, no force",
    "ramping-out": "force ramps out",
    "leaving": "force ramps out",
    "stopped": "emergency stop, no force",
    "ended": "ended",
}

_CAUSES = {
    "stop-requested": "somebody or the clock ended it",
    "partner-left": "the partner left",
    "refused": "the two sides did not agree",
    "emergency-stop": "the emergency stop was pressed",
    "device-not-ready": "the robot was not ready any more",
    "device-silent": "the robot fell silent",
    "device-halted": "the simulated robot could not move on",
    "starting": "the session has just begun",
    "silence": "no packet came",
    "frozen-stamps": "the partner's clock stands still",
    "frozen-motion": "the partner's position is frozen",
    "partner-restarted": "the partner has started anew",
    "clock-stepped": "a clock was set",
    "own-measurement": "the own robot reported an impossible value",
    "own-silence": "the own robot or loop stood still",
}

_EVENTS = {
    "agreed": "agrees with the partner",
    "disagreed": "does not agree with the partner",
    "running": "both sides agree: the session runs",
    "leaving": "leaves",
    "ended": "has ended",
    "path-changed": "the way of the packets has changed, and so has their delay",
    "path-lost": "no way to the partner is left",
    "partner-found": "hears the partner",
    "partner-restarted": "the partner has started anew",
    "holding": "holds the force",
    "ramping-out": "force ramps out",
    "disengaged": "force is zero",
    "ramping-in": "force ramps in",
    "engaged": "full force",
    "datagram-refused": "refused a packet",
    "impossible-value": "the robot reported an impossible value",
    "clock-stepped": "a clock was set",
    "impossible-force": "an impossible force was not commanded",
    "recording-broken": "the recording has broken off; the session goes on",
}

#: Causes that are numbers or ids, which say nothing to a person.
_SILENT_CAUSES = {"agreed", "partner-found", "partner-restarted"}

_LIMITS = {
    "strategy": "coupling holds back",
    "force": "cut at the force limit",
    "held": "old motion held",
}


def describe_phase(status: Line) -> str:
    """Write the state of a side."""
    phase = str(status.get("phase", ""))
    text = _PHASES.get(phase, _plain(phase))
    offset = status.get("offset")
    if phase == "aligning" and isinstance(offset, int | float):
        text += f": {format_number(float(offset), 2, shift=3)} mm apart"
    return text


def describe_watchdog(status: Line) -> str:
    """Write what the watchdog does with the force, and why.

    Examples
    --------
    >>> describe_watchdog({"watchdog": "holding", "watchdog_cause": "silence"})
    'holds the force: no packet came'
    """
    word = str(status.get("watchdog") or "")
    cause = status.get("watchdog_cause")
    text = _EVENTS.get(word, _plain(word)) or "–"
    return f"{text}: {describe_cause(str(cause))}" if cause else text


def describe_cause(word: str) -> str:
    """Write why something happened; a word that is not known as it is."""
    return _CAUSES.get(word, _plain(word))


def describe_event(event: Line) -> str:
    """Write what happened, and why.

    Examples
    --------
    >>> describe_event({"event": "ramping-out", "cause": "silence"})
    'force ramps out: no packet came'
    """
    word, cause = str(event.get("event", "")), event.get("cause")
    text = _EVENTS.get(word, _plain(word))
    if cause and word not in _SILENT_CAUSES:
        text += f": {describe_cause(str(cause))}"
    return text


def describe_limits(status: Line) -> str:
    """Write what changes the force now; a dash if nothing does."""
    words = status.get("limits") or []
    return "; ".join(_LIMITS.get(str(word), _plain(str(word))) for word in words) or "–"


def _plain(word: str) -> str:
    """Return a word of the program as text, so that what it may send harms no terminal."""
    return "".join(letter for letter in word.replace("-", " ") if letter.isprintable())[:80]
