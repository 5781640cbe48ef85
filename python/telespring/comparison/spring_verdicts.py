"""What `decide` says about the bare spring on the networks of a comparison."""

from __future__ import annotations

import math

from telespring._core import Network, Study
from telespring.decision.decide import decide
from telespring.decision.question import Question
from telespring.theory.verdicts import verdicts

__all__ = ["SpringVerdicts"]

#: The found age is right to this, s.
_STEP = 1e-4


class SpringVerdicts:
    """The verdicts on the spring of a study on its network, as `telespring decide` answers them.

    Parameters
    ----------
    study
        With one of the networks of the comparison.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._has_adversary = any(adversary is not None for adversary in study.adversaries)
        # A study may leave the delay to its protocol.
        self._controllers = study.replace(network={"delay": 0.0}).network
        self._statuses: dict[tuple[float, Network, bool], str] = {}
        self._bounds: dict[tuple[tuple[float, float], tuple[float, float]], float | None] = {}

    def status(
        self,
        stiffness: float,
        delay: float,
        shortest: tuple[float, float],
        longest: tuple[float, float],
        *,
        is_playout_fixed: bool,
    ) -> str:
        """Return the answer for free and held handles together, the worse of both.

        With a fixed play-out it is the answer for the network that the study states at this delay, as long
        as the ages that were played are those which it promises. Otherwise (an adaptive play-out, a
        recorded trace with later packets) it is that for ages between those that were played. Behind an
        adversary nothing is as the study states it, and the ages are what it claims: "not proven".

        Parameters
        ----------
        stiffness, delay
            N/m; one way, s.
        shortest, longest
            Ages of the samples that robots 1 and 2 used, s; NaN where none was used.
        is_playout_fixed
            Whether samples are played at a fixed age.
        """
        if self._has_adversary:
            return "not proven"
        stated = self._study.replace(network={"delay": delay})
        network, has_buffer = stated.network, stated.has_playout_buffer
        # Robot 1 receives on the way backward.
        oldest = network.buffered[1], network.buffered[0]
        period = 0.5 * network.sample_period + 1e-9
        is_as_stated = is_playout_fixed and all(
            not age > promised + period for age, promised in zip(longest, oldest, strict=True)
        )
        is_as_stated = is_as_stated or not all(map(math.isfinite, (*shortest, *longest)))
        if not is_as_stated:
            network, has_buffer = _network_of_ages(network, shortest, longest), False
        key = (stiffness, network, has_buffer)
        if key not in self._statuses:
            question = Question.of(self._study, network, has_playout_buffer=has_buffer)
            self._statuses[key] = decide(
                question, stiffness, uncertainty=self._study.uncertainty, compare_free=True
            ).worst_status
        return self._statuses[key]

    def longest_ages(
        self, stiffness: float, shortest: tuple[float, float], longest: tuple[float, float]
    ) -> tuple[float, float]:
        """Return up to which age robots 1 and 2 may use samples, s, by the verdict on an age in a range.

        The range begins at `shortest` and is as wide on both ways. It is as long as `longest` or longer only
        if the verdict holds for all ages that were played. If it holds for none, the result is 0; without a
        verdict (a coupling damper under sampled controllers, an adversary) it is NaN.
        """
        if self._has_adversary:
            return math.nan, math.nan
        widest = max(0.0, *(high - low for low, high in zip(shortest, longest, strict=True)))
        holds = self._holds(stiffness, shortest, widest)
        if holds is None:
            return math.nan, math.nan
        if holds:
            return shortest[0] + widest, shortest[1] + widest
        if not self._holds(stiffness, shortest, 0.0):
            return 0.0, 0.0
        low, high = 0.0, widest
        while high - low > _STEP:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self._holds(stiffness, shortest, middle) else (low, middle)
        return shortest[0] + low, shortest[1] + low

    def _holds(self, stiffness: float, shortest: tuple[float, float], width: float) -> bool | None:
        """Return whether the verdict holds for ages from `shortest` on; None without a verdict."""
        longest = shortest[0] + width, shortest[1] + width
        key = (shortest, longest)
        if key not in self._bounds:
            network = _network_of_ages(self._controllers, shortest, longest)
            judged = verdicts(
                self._study.dyad, stiffness, network, operator_range=self._study.operator_ranges
            )
            self._bounds[key] = judged.tier("age in a range").stiffness_bound
        bound = self._bounds[key]
        return None if bound is None else stiffness < bound


def _network_of_ages(
    network: Network, shortest: tuple[float, float], longest: tuple[float, float]
) -> Network:
    """Return a network on which the samples of robots 1 and 2 have ages in these ranges, s."""
    first, second = shortest
    jitter = max(0.0, longest[0] - first, longest[1] - second)
    return Network((second, first), jitter, 0.0, network.sample_period, network.computing_time)
