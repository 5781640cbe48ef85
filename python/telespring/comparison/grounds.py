"""On which grounds a strategy is safe: a function per strategy, each with its own conditions.

`docs/strategies.md` proves what is used here. A condition that nobody has proven is none.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np

from telespring._core import Experiment, HeldCoupling, Study
from telespring._types import FloatArray
from telespring.comparison.choices import Grounds, Lack
from telespring.rehearsal.run import require_experiment

__all__ = ["STRATEGY_GROUNDS", "Place", "find_grounds"]

#: Predictors that leave the loop as it is: what they add does not depend on the robots (docs/prediction.md).
_OUTSIDE_OF_THE_LOOP = frozenset({"hold", "shared-target"})
#: The share of the energy behind a held force that may come out in one sample period without being foreseen.
_UNFORESEEN = 0.1


@dataclass(frozen=True, eq=False)
class Place:
    """One architecture on one network at one stiffness and delay.

    Attributes
    ----------
    study
        The study with this architecture on this network.
    stiffness, delay
        N/m; one way, s.
    oldest
        Age of the oldest sample that robots 1 and 2 may use, s; infinite where nothing bounds it.
    verdict
        What `decide` answers for the bare spring.
    """

    study: Study
    stiffness: float
    delay: float
    oldest: tuple[float, float]
    verdict: str

    @property
    def has_forger(self) -> bool:
        """Whether an adversary hands over other packets than the partner sent."""
        kinds = {each.kind for each in self.study.adversaries if each is not None}
        return bool(kinds - {"stretch-timed"})

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment of the study."""
        return require_experiment(self.study)

    @cached_property
    def held(self) -> HeldCoupling:
        """What the strategy holds on the handles over a sample period."""
        return self.experiment.held_coupling(self.stiffness, self.delay)

    @cached_property
    def damper(self) -> FloatArray:
        """The strongest damper on each handle, N·s/m, (robot, axis)."""
        return np.asarray(self.held.damping)

    @cached_property
    def mass(self) -> FloatArray:
        """The mass that each robot has at least, kg, (robot, axis)."""
        return self.study.least_mass

    @cached_property
    def damping(self) -> FloatArray:
        """The damping that each robot has at least, N·s/m, (robot, axis)."""
        return self.study.least_damping


def find_grounds(place: Place) -> tuple[Grounds | Literal[""], Lack | Literal[""]]:
    """Return on which grounds a strategy is safe at a place, and what it lacks if it has none.

    Returns
    -------
    tuple
        The grounds and "", or "" and what is lacking.

    Examples
    --------
    >>> study = Study.paper().replace(session={"strategy": "wave-variables"})
    >>> find_grounds(Place(study, 71.2, 0.3, (0.3, 0.3), "unstable"))
    ('honest partner', '')
    >>> find_grounds(Place(Study.paper(), 71.2, 0.3, (0.3, 0.3), "unstable"))
    ('', 'stable spring')
    """
    lack, grounds = STRATEGY_GROUNDS[place.study.session.strategy]
    found = lack(place)
    if found is None and grounds == "honest partner" and place.has_forger:
        found = "honest partner"
    return (grounds, "") if found is None else ("", found)


def _lack_of_guard(place: Place) -> Lack | None:
    """Check that the account's overdraft is small beside the energy of the robots."""
    return None if place.study.guard_overdraft(place.stiffness).is_proven else "softer spring"


def _lack_of_spring(place: Place) -> Lack | None:
    """Trust the verdict on the spring that follows the motion as played, if forces act as it assumes.

    It counts a computing tick of the laboratory as a computing time of one period, whatever time is stated.
    """
    if place.study.session.predictor not in _OUTSIDE_OF_THE_LOOP:
        return "known prediction"
    if place.experiment.settings.actuator_lag > 0.0:
        return "force without a lag"
    return None if place.verdict == "stable" else "stable spring"


def _lack_of_injected_damping(place: Place) -> Lack | None:
    """Apply the rule of bounded delays to the held damper and the oldest samples."""
    if place.study.session.predictor not in _OUTSIDE_OF_THE_LOOP:
        return "known prediction"
    lack = _lack_of_immediate_force(place) or _lack_of_mass(place)
    if lack is not None:
        return lack
    period, k = place.experiment.sample_period, place.stiffness
    # A held sample is half a period older on average, the own one too.
    round_trip = sum(place.oldest) + period
    rest = place.damping + place.damper - 0.5 * k * period
    is_enough = (rest > 0.0).all() and (k * round_trip < 2.0 * np.sqrt(rest[0] * rest[1])).all()
    return None if is_enough and math.isfinite(round_trip) else "shorter ages"


def _lack_of_wave_variables(place: Place) -> Lack | None:
    """Check that both ends are passive with a held spring and damper; the line is, with true energies."""
    lack = _lack_of_immediate_force(place) or _lack_of_exact_positions(place) or _lack_of_mass(place)
    return lack or _lack_of_damper(place)


def _lack_of_an_observer(place: Place) -> Lack | None:
    """Check what an observer misses, who counts F·Δx and foresees the next tick by the velocity of now."""
    lack = _lack_of_immediate_force(place) or _lack_of_exact_positions(place) or _lack_of_mass(place)
    period = place.experiment.sample_period
    is_foreseen = 2.0 * place.held.stiffness * period**2 <= _UNFORESEEN * place.mass.min()
    return lack or (None if is_foreseen else "softer spring")


def _lack_of_set_position_modulation(place: Place) -> Lack | None:
    """Check it as an observer, whose damper pays for the hold of the spring."""
    return _lack_of_an_observer(place) or _lack_of_damper(place)


def _lack_of_immediate_force(place: Place) -> Lack | None:
    settings = place.experiment.settings
    if settings.computing_tick:
        return "force without a computing tick"
    return "force without a lag" if settings.actuator_lag > 0.0 else None


def _lack_of_exact_positions(place: Place) -> Lack | None:
    return "exact positions" if place.experiment.settings.encoder_resolution > 0.0 else None


def _lack_of_mass(place: Place) -> Lack | None:
    """Check that d·h is at most the mass: then a held damper d takes energy from the motion."""
    is_strong = (place.damper * place.experiment.sample_period > place.mass).any()
    return "weaker damper" if is_strong else None


def _lack_of_damper(place: Place) -> Lack | None:
    """Check for a damper of K·h: it takes what a held spring K gives out in a tick, up to ½ K Δx²."""
    is_weak = (place.damper < place.held.stiffness * place.experiment.sample_period).any()
    return "stronger damper" if is_weak else None


#: By strategy: what it lacks at a place, if anything, and the grounds that it has else.
STRATEGY_GROUNDS: Mapping[str, tuple[Callable[[Place], Lack | None], Grounds]] = MappingProxyType(
    {
        "spring": (_lack_of_spring, "stable spring"),
        "guard": (_lack_of_guard, "any network"),
        "injected-damping": (_lack_of_injected_damping, "bounded ages"),
        "wave-variables": (_lack_of_wave_variables, "honest partner"),
        "time-domain-passivity": (_lack_of_an_observer, "honest partner"),
        "two-layer": (_lack_of_an_observer, "honest partner"),
        "set-position-modulation": (_lack_of_set_position_modulation, "honest partner"),
    }
)
