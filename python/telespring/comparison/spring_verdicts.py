"""What `decide` says about the bare spring on the networks of a comparison."""

from __future__ import annotations

import math

import numpy as np

from telespring._core import Network, Study
from telespring.decision.decide import decide
from telespring.decision.question import Question
from telespring.rehearsal.run import require_experiment
from telespring.theory.verdicts import verdicts

__all__ = ["SpringVerdicts"]

#: The found age is right to this, s.
_STEP = 1e-4


class SpringVerdicts:
    """The verdicts on the spring of a study on its network, as `telespring decide` answers them.

    Parameters
    ----------
    study
        With one of the networks of the comparison, and the play-out of one of its architectures; whatever
        strategy and predictor it has, the bare spring is judged.
    """

    def __init__(self, study: Study) -> None:
        self._study = _with_sampled_controllers(study).replace(
            session={"strategy": "spring", "predictor": "hold"}
        )
        # Behind an adversary the ages that were played are what it claims.
        self._has_adversary = any(adversary is not None for adversary in study.adversaries)
        # A study may leave the delay to its protocol.
        self._controllers = self._study.judged_network(0.0, (None, None)).network
        self._asked: dict[float, Question] = {}
        self._statuses: dict[tuple[float, Network, bool, bool], str] = {}
        self._bounds: dict[tuple[tuple[float, float], tuple[float, float]], float | None] = {}

    def status(
        self, stiffness: float, delay: float, shortest: tuple[float, float], longest: tuple[float, float]
    ) -> str:
        """Return the answer for free and held handles together, the worse of both.

        It is the answer for the ages that network and play-out make at this delay, together with those that
        were played. On a recorded trace it is that for the ages that were played, and behind an adversary,
        whose stamps claim them, nothing is proven of one.

        Parameters
        ----------
        stiffness, delay
            N/m; one way, s.
        shortest, longest
            Ages of the samples that robots 1 and 2 used, s; NaN where none was used.
        """
        question = self._question(delay, shortest, longest)
        key = (stiffness, question.network, question.has_playout_buffer, question.is_bounded)
        if key not in self._statuses:
            self._statuses[key] = decide(
                question, stiffness, uncertainty=self._study.uncertainty, compare_free=True
            ).worst_status
        return self._statuses[key]

    def oldest(self, delay: float, longest: tuple[float, float]) -> tuple[float, float]:
        """Return how old the samples of robots 1 and 2 may be, s; infinite where nothing bounds it.

        `longest` are the ages that were played: those of a recorded trace, and never less.
        """
        asked = self._asked_at(delay)
        assert asked.ages is not None  # it comes with a study
        if "unread trace" in asked.unjudged and not self._has_adversary and all(map(math.isfinite, longest)):
            return longest
        if asked.unjudged or asked.ages.ages is None:
            return math.inf, math.inf
        (_, forward), (_, backward) = asked.ages.ages
        # Robot 1 receives on the way backward. Without a sample played, fmax leaves what the network makes.
        return float(np.fmax(backward, longest[0])), float(np.fmax(forward, longest[1]))

    def _asked_at(self, delay: float) -> Question:
        """Return the question of the study at a delay, s, which is the same at every stiffness."""
        if delay not in self._asked:
            self._asked[delay] = Question.of_study(self._study, delay=delay)
        return self._asked[delay]

    def _question(
        self, delay: float, shortest: tuple[float, float], longest: tuple[float, float]
    ) -> Question:
        asked = self._asked_at(delay)
        assert asked.ages is not None  # it comes with a study
        if self._has_adversary or not all(map(math.isfinite, (*shortest, *longest))):
            return asked
        if "unread trace" in asked.unjudged:
            # Whatever buffer is promised, these are the ages behind it.
            network = _network_of_ages(self._controllers, shortest, longest)
            return Question.of(self._study, network, has_playout_buffer=False)
        if asked.ages.ages is None:
            return asked
        # Robot 1 receives on the way backward.
        (forward_low, forward), (backward_low, backward) = asked.ages.ages
        # Between samples that overtake each other a motion is a period apart from them at most.
        near = self._controllers.sample_period + 1e-9
        if all(
            low - near <= least and most <= high + 1e-9
            for low, least, most, high in zip(
                (backward_low, forward_low), shortest, longest, (backward, forward), strict=True
            )
        ):
            return asked
        least = min(shortest[0], backward_low), min(shortest[1], forward_low)
        most = max(longest[0], backward), max(longest[1], forward)
        network = _network_of_ages(self._controllers, least, most)
        return Question.of(self._study, network, has_playout_buffer=False)

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


def _with_sampled_controllers(study: Study) -> Study:
    """Return the study with controllers that are sampled as those of its rehearsal are, if it states none."""
    if study.replace(network={"delay": 0.0}).network.sample_period > 0.0:
        return study
    return study.replace(controller={"sample_period": require_experiment(study).sample_period})


def _network_of_ages(
    network: Network, shortest: tuple[float, float], longest: tuple[float, float]
) -> Network:
    """Return a network on which the samples of robots 1 and 2 have ages in these ranges, s."""
    # Robot 1 receives on the way backward.
    (second, first) = shortest
    jitters = max(0.0, longest[1] - first), max(0.0, longest[0] - second)
    return Network((first, second), jitters, 0.0, network.sample_period, network.computing_time)
