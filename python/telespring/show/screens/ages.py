"""Which ages of the motion in use were judged, and what was not, in words."""

from __future__ import annotations

from collections.abc import Sequence

from telespring.model import JudgedNetwork, Network, Study
from telespring.show.quantities import format_time

__all__ = ["ages_clause", "ages_notes", "not_simulated"]

_SOURCES = {
    "loss": "lost packets",
    "burst": "losses in bursts",
    "blackout": "blackouts",
    "rate": "a link of limited rate",
    "rate below need": "a link slower than its packets",
    "trace": "the recorded trace",
    "adversary": "an adversary",
    "play-out": "the play-out of [session]",
    "adaptive play-out": "the adaptive play-out of [session]",
}
_UNJUDGED = {
    "unread trace": "Nothing is proven: the ages come from the recorded trace, whose content was not given: "
    "telespring decide reads it from the study's folder; ts.decide takes it as traces=(text, text).",
    "lying peer": "Nothing is proven: no verdict holds for a partner that lies about its motion.",
    "predictor": "Nothing is proven: the numbers are those of the spring without the session's predictor, "
    "which changes the loop; ts.maximum_stiffness(…, predictor=…) judges it at one constant delay.",
    "strategy": "Nothing is proven: the numbers are those of the bare spring, not of the session's strategy "
    "(docs/strategies.md says what it promises).",
    "actuator lag": "Nothing is proven: no verdict judges forces that lag behind their commands "
    "(laboratory.actuator_lag).",
}
_TOO_SHORT = "max_gap is shorter than the gaps that the losses make: the longer ones count."


def ages_notes(
    ages: JudgedNetwork | None, stated: Network | None, *, is_delay_given: bool = True
) -> tuple[str, ...]:
    """Say which ages were judged where they are not those of delay, jitter and gap, and what was not judged.

    Without a delay each row of the answer has its own ages.

    Examples
    --------
    >>> import telespring as ts
    >>> study = ts.Study.paper().replace(network={"delay": 0.05, "loss": 0.01})
    >>> ages_notes(study.judged_network(), study.network)
    ('Judged for ages of 49 to 57 ms each way: lost packets.',)
    """
    if ages is None:
        return ()
    notes = [_UNJUDGED[word] for word in ages.unjudged]
    if ages.has_computing_tick:
        notes.append("Forces act a sample period late, as in the laboratory (laboratory.computing_tick).")
    if ages.is_guard_predicted:
        notes.append("The guard's predictor is not in this answer: it changes how often the guard acts.")
    if ages.is_as_stated or "unread trace" in ages.unjudged:
        return tuple(notes)
    why = _join([_SOURCES[word] for word in _said(ages.sources)])
    if ages.ages is None:
        notes.append(f"Nothing bounds the ages ({why}): only what is stable on any network is proven.")
    elif not is_delay_given:
        notes.append(f"Each delay is judged for the ages that come of it: {why}.")
    elif not _is_the_same(ages, stated):
        notes.append(f"Judged for {ages_clause(ages.ages)}: {why}.")
    if "stated gap too short" in ages.sources:
        notes.append(_TOO_SHORT)
    return tuple(notes)


def not_simulated(study: Study) -> str | None:
    """Say what of a study `telespring simulate` leaves out; None if it simulates all of it.

    Examples
    --------
    >>> import telespring as ts
    >>> not_simulated(ts.Study.paper().replace(network={"jitter": 0.01, "loss": 0.02}))
    'Not simulated, since the delay is constant here: jitter and lost packets. Rehearse the study for that.'
    """
    ages = study.judged_network()
    parts = ["jitter"] if study.network.jitter > 0.0 else []
    parts += ["gaps"] if study.network.max_gap > 0.0 else []
    parts += [_SOURCES[word] for word in _said(ages.sources)]
    parts += ["the recorded trace"] if "unread trace" in ages.unjudged else []
    session = study.session
    parts += [f"the strategy {session.strategy}"] if session.strategy != "spring" else []
    parts += [f"the predictor {session.predictor}"] if session.predictor != "hold" else []
    if not parts:
        return None
    return f"Not simulated, since the delay is constant here: {_join(parts)}. Rehearse the study for that."


def _is_the_same(ages: JudgedNetwork, stated: Network | None) -> bool:
    """Whether a play-out only makes what is stated anyway."""
    return stated is not None and ages.network == stated


def _said(sources: Sequence[str]) -> list[str]:
    """Leave out what another word says."""
    left_out = {"stated gap too short"} | ({"rate"} if "rate below need" in sources else set())
    return [word for word in sources if word not in left_out]


def _join(parts: Sequence[str]) -> str:
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def ages_clause(ages: tuple[tuple[float, float], tuple[float, float]]) -> str:
    """Write the ages of both ways.

    Examples
    --------
    >>> ages_clause(((0.3, 0.3), (0.3, 0.3))), ages_clause(((0.049, 0.057), (0.05, 0.05)))
    ('a constant age of 300 ms each way', 'ages of 49 to 57 ms forward and 50 ms backward')
    """
    forward, backward = ages
    if forward != backward:
        return f"ages of {_range(forward)} forward and {_range(backward)} backward"
    if forward[0] == forward[1]:
        return f"a constant age of {_range(forward)} each way"
    return f"ages of {_range(forward)} each way"


def _range(ages: tuple[float, float]) -> str:
    low, high = (format_time(age, 6) for age in ages)
    if low == high:
        return low
    number, _, unit = low.partition(" ")
    return f"{number} to {high}" if high.endswith(f" {unit}") else f"{low} to {high}"
