"""Checks of a study before its rehearsal: what will spoil the trials."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from telespring._core import Arm, Study
from telespring._types import FloatArray
from telespring.rehearsal.target import target_path

__all__ = [
    "JitterWarning",
    "LateWarning",
    "LossWarning",
    "PreflightWarning",
    "ReachWarning",
    "TraceWarning",
    "preflight_warnings",
]

#: m; an arm that comes closer than this to a limit of its reach gets a warning.
_MARGIN = 0.03


@dataclass(frozen=True)
class JitterWarning:
    """Jitter (s) that is no shorter than the duration of a trial (s): most packets arrive after its end."""

    jitter: float
    duration: float


@dataclass(frozen=True)
class LateWarning:
    """A play-out delay (s) shorter than the longest delay (s) of a condition: no motion comes in time."""

    playout: float
    delay: float


@dataclass(frozen=True)
class LossWarning:
    """All packets are lost."""


@dataclass(frozen=True)
class TraceWarning:
    """Delays of conditions (s, each once) that are not those of the network, which is a recorded trace.

    `use` is what they are: "play-out", the age at which a motion is played, or "none", where the session's
    play-out has a delay of its own or follows the network.
    """

    delays: tuple[float, ...]
    use: Literal["play-out", "none"]


@dataclass(frozen=True)
class ReachWarning:
    """The target comes close to a limit of a two-link arm's reach, or passes it.

    Attributes
    ----------
    arm
        1 or 2.
    limit
        The farthest or the nearest distance from the shoulder that the hand reaches.
    reach
        That distance, m.
    room
        Smallest distance of the target from the limit, m; negative beyond it.
    position
        The position of the target there, m.
    """

    arm: int
    limit: Literal["farthest", "nearest"]
    reach: float
    room: float
    position: tuple[float, float]


PreflightWarning: TypeAlias = JitterWarning | LateWarning | LossWarning | ReachWarning | TraceWarning


def preflight_warnings(study: Study, modules: Path | None = None) -> list[PreflightWarning]:
    """Check a study for what will spoil its trials.

    Nothing is refused: a network that loses every packet can be studied too. A study without an experiment
    has no warnings. `modules`, the folder of the study file, is where a Python target is looked up first; it
    is refused where it is missing or its positions are invalid.
    `telespring.show.screens.rehearsal.preflight_sentence` puts each warning into words.

    Examples
    --------
    >>> import telespring as ts
    >>> preflight_warnings(ts.Study.paper())
    []
    >>> preflight_warnings(ts.Study.paper().replace(network={"loss": 1.0}))
    [LossWarning()]
    """
    experiment = study.experiment
    if experiment is None:
        return []
    settings = experiment.settings
    warnings: list[PreflightWarning] = []
    if settings.jitter >= experiment.duration:
        warnings.append(JitterWarning(settings.jitter, experiment.duration))
    if settings.loss >= 1.0:
        warnings.append(LossWarning())
    playout = study.session.playout_delay
    delays = sorted({delay for stiffness, delay in experiment.conditions if stiffness})
    # a recorded trace has its own delays
    if experiment.trace_files != (None, None):
        is_used = playout is None and study.session.playout == "fixed"
        if len(delays) > 1 or (delays and not is_used and delays != [playout]):
            warnings.append(TraceWarning(tuple(delays), "play-out" if is_used else "none"))
    elif playout is not None and delays and playout < delays[-1]:
        warnings.append(LateWarning(playout, delays[-1]))
    if any(arm.kind == "two-link" for arm in experiment.arms):
        path = target_path(experiment, modules)
        for number, arm in enumerate(experiment.arms, start=1):
            if arm.kind == "two-link":
                warnings += _reach_warnings(number, arm, path)
    return warnings


def _reach_warnings(number: int, arm: Arm, path: FloatArray) -> list[ReachWarning]:
    assert arm.link_length is not None  # a two-link arm
    upper, lower = arm.link_length
    distance = np.hypot(*(path - np.asarray(arm.base)).T)
    farthest, nearest = upper + lower, abs(upper - lower)
    warnings = []
    limits: tuple[tuple[Literal["farthest", "nearest"], float, FloatArray], ...] = (
        ("farthest", farthest, farthest - distance),
        ("nearest", nearest, distance - nearest),
    )
    for limit, reach, room in limits:
        worst = int(np.argmin(room))
        # A nanometre for rounding: just 3 cm are enough.
        if room[worst] < _MARGIN - 1e-9:
            x, y = path[worst].tolist()
            warnings.append(ReachWarning(number, limit, reach, float(room[worst]), (x, y)))
    return warnings
