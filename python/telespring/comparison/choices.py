"""The best safe choice of a comparison, and what became of the others, as data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = [
    "Alternative",
    "Candidate",
    "Grounds",
    "LeftOut",
    "Objection",
    "Recommendation",
    "Rejection",
]

#: Why a choice is safe: whatever the network does, or because the spring is stable on every network compared.
Grounds: TypeAlias = Literal["any network", "stable spring"]

#: Why a choice is not recommended, in the order in which it is looked for.
Objection: TypeAlias = Literal["not at every delay", "ran away", "ended early", "not proven", "overdraft"]


@dataclass(frozen=True)
class Candidate:
    """An architecture with a stiffness, which a user may choose; delay and network are what they are.

    Attributes
    ----------
    architecture
        Label, such as "guard + shared-target".
    strategy, predictor, playout
        Its parts.
    stiffness
        N/m.
    tracking_error
        Mean of each person over all networks, delays and trials, m.
    worst_tracking_error
        Of each person on the network and at the delay that were worst for it, m.
    grounds
        Why it is safe.
    """

    architecture: str
    strategy: str
    predictor: str
    playout: str
    stiffness: float
    tracking_error: tuple[float, float]
    worst_tracking_error: tuple[float, float]
    grounds: Grounds

    @property
    def mean_tracking_error(self) -> float:
        """Mean of both people, m."""
        return 0.5 * sum(self.tracking_error)


@dataclass(frozen=True)
class Rejection:
    """Why an architecture with one stiffness cannot be recommended.

    Attributes
    ----------
    stiffness
        N/m.
    objection
        What was found first.
    network, delay
        Where: on which network, and at which delay (s).
    trials
        How many trials ran away or ended early there; 0 for other objections.
    verdict
        The answer for the spring there; "" for other objections.
    """

    stiffness: float
    objection: Objection
    network: str
    delay: float
    trials: int = 0
    verdict: str = ""


@dataclass(frozen=True)
class Alternative:
    """What became of one architecture that was not chosen.

    Attributes
    ----------
    architecture
        Its label.
    candidate
        It with its best stiffness; None if it has none that is safe.
    difference
        How much larger its mean tracking error is than that of the choice, m; NaN without a candidate.
    difference_error
        Standard error of that difference, from pairs of trials with the same random numbers, m; NaN with
        fewer than two.
    rejections
        Why its other stiffnesses cannot be recommended.
    """

    architecture: str
    candidate: Candidate | None
    difference: float
    difference_error: float
    rejections: tuple[Rejection, ...]


@dataclass(frozen=True)
class Recommendation:
    """The best safe choice of a comparison.

    Attributes
    ----------
    candidate
        The choice; None if nothing that was compared is safe.
    conditions, trials
        On how many networks and delays together, and by how many trials, every candidate was judged.
    alternatives
        What became of the other architectures, in the order of the comparison.
    rejections
        Why the chosen architecture cannot be recommended with other stiffnesses.
    """

    candidate: Candidate | None
    conditions: int
    trials: int
    alternatives: tuple[Alternative, ...]
    rejections: tuple[Rejection, ...]

    @property
    def next_best(self) -> Alternative | None:
        """The architecture that comes next; None if no other is safe."""
        safe = [each for each in self.alternatives if each.candidate is not None]
        return min(safe, key=lambda each: each.difference, default=None)


@dataclass(frozen=True)
class LeftOut:
    """An architecture of the usual list that this study cannot have, and why."""

    architecture: str
    reason: str
