"""The words of the live program in plain sentences: states, events, causes, and what limits the force."""

from __future__ import annotations

import re

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

#: By whether the person here consents, and the one there.
_CONSENTS = {
    (False, False): "waiting for both consents: press c",
    (False, True): "waiting for the consent here: press c",
    (True, False): "waiting for the partner's consent",
}

_CAUSES = {
    "stop-requested": "somebody ended it",
    "time-over": "the time was over",
    "partner-left": "the partner left",
    "refused": "the two sides did not agree",
    "emergency-stop": "the emergency stop was pressed",
    "device-not-ready": "the robot was not ready any more",
    "device-silent": "the robot fell silent",
    "device-impossible": "the robot reported values that cannot be",
    "device-halted": "the simulated robot could not move on",
    "delay-refused": "the network takes longer than the imposed delay",
    "pause-ordered": "somebody wants a pause",
    "consent-withdrawn": "somebody took the consent back",
    "network": "the network was bad for too long",
    "velocity": "the handle was too fast",
    "workspace": "the handle left its workspace",
    "suspended": "the machine was suspended",
    "partner": "the partner let go",
    "partner-paused": "the partner wants a pause",
    "partner-stopped": "the partner's emergency stop was pressed",
    "partner-not-ready": "the partner's robot is silent or not ready",
    "partner-changed": "another partner came",
    "here": "at this side",
    "guard": "the guard holds back",
    "force": "the force limit",
    "loss": "packets lost",
    "held": "old motions held",
    "age": "the partner's motion is old",
    "version": "the version of the program",
    "axes": "the number of axes",
    "side": "who moves which robot",
    "robots": "the robots",
    "coupling": "stiffness or damping",
    "sample-period": "the sample period",
    "strategy": "strategy, predictor or play-out",
    "study": "the rest of the study",
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
    "path-direct": "packets go directly to the partner",
    "path-relayed": "packets go through the relay",
    "path-withheld": "only the relay is left, which may carry no packets",
    "path-refused": "the partner does not know the key of this site",
    "path-stranger": "somebody with an unknown key was refused",
    "path-rate": "the rate of the packets has changed",
    "partner-found": "hears the partner",
    "partner-restarted": "the partner has started anew",
    "holding": "holds the force",
    "force-ramping-out": "force ramps out",
    "ramping-out": "force ramps out",
    "disengaged": "force is zero",
    "force-ramping-in": "force ramps in",
    "ramping-in": "force ramps in",
    "engaged": "full force",
    "datagram-refused": "refused a packet",
    "impossible-value": "the robot reported an impossible value",
    "clock-stepped": "a clock was set",
    "impossible-force": "an impossible force was not commanded",
    "recording-broken": "the recording has broken off; the session goes on",
    "consented": "the person here consents",
    "partner-consented": "the person there consents",
    "consent-lost": "the consent is gone",
    "interrupted": "the coupling is interrupted",
    "emergency-stop": "emergency stop pressed",
    "cleared": "the emergency stop is cleared",
    "resumed": "wants the pause no more",
    "order-refused": "that is not possible now",
    "mark": "mark",
    "offset": "the handles are apart",
    "axis-locked": "an axis is left out at both sites",
    "device-awaited": "no row has come from the device yet",
    "partner-awaited": "nothing has come from the partner yet",
    "limiting": "the force is held back",
    "limiting-over": "the force is whole again",
    "softened": "bad network: the force is softened",
    "restored": "good network: the force is whole again",
    "network-pause": "bad network: the session pauses",
    "delay-too-short": "the imposed delay is too short",
}

#: Causes that are numbers or ids, which say nothing to a person.
_SILENT_CAUSES = {"agreed", "partner-found", "partner-restarted"}

_LIMITS = {
    "strategy": "coupling holds back",
    "force": "cut at the force limit",
    "held": "old motion held",
    "softened": "softened: bad network",
}


def describe_phase(status: Line) -> str:
    """Write the state of a side."""
    phase = str(status.get("phase", ""))
    text = _PHASES.get(phase, _plain(phase))
    offset = status.get("offset")
    if phase == "aligning" and isinstance(offset, int | float):
        text += f": {format_number(float(offset), 2, shift=3)} mm apart"
    elif phase == "consenting" and status.get("consents"):
        text = _CONSENTS.get(tuple(status["consents"]), text)
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
    """Write why something happened; a word that is not known as it is.

    Examples
    --------
    >>> describe_cause("axes: 2 axes here, 1 axes there")
    'the number of axes: 2 axes here, 1 axes there'
    """
    head, colon, details = word.partition(": ")
    return _CAUSES[head] + colon + _printable(details) if head in _CAUSES else _plain(word)


def describe_event(event: Line) -> str:
    """Write what happened, and why.

    Examples
    --------
    >>> describe_event({"event": "force-ramping-out", "cause": "silence"})
    'force ramps out: no packet came'
    >>> describe_event({"event": "order-refused", "cause": "resume while paused", "remedy": "Ask there."})
    'that is not possible now: resume while paused. Ask there.'
    >>> describe_event({"event": "offset", "cause": "move the handle of site 1 by -26 mm in x"})
    'the handles are apart: move the handle of site 1 by -26 mm in x'
    """
    word, cause = str(event.get("event", "")), event.get("cause")
    if word == "phase":
        return describe_phase({"phase": cause})
    text = _EVENTS.get(word, _plain(word))
    if cause and word not in _SILENT_CAUSES:
        text += f": {describe_cause(str(cause))}"
    if event.get("remedy"):
        text += f". {_printable(str(event['remedy']))}"
    return text


def describe_limits(status: Line) -> str:
    """Write what changes the force now; a dash if nothing does."""
    words = status.get("limits") or []
    return "; ".join(_LIMITS.get(str(word), _plain(str(word))) for word in words) or "–"


def _plain(word: str) -> str:
    """Return a word of the program as text, such as `device silent`; a minus stays one."""
    return _printable(re.sub(r"(?<=[a-z])-(?=[a-z])", " ", word))


def _printable(text: str) -> str:
    """Return a text of the program without what may harm a terminal."""
    return "".join(letter for letter in text if letter.isprintable())[:200]
