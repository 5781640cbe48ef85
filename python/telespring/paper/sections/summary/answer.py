"""Whether the study's own stiffness is stable over its network, and how close the limit is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from telespring._core import RESERVE, is_stable
from telespring._json import finite_or_none
from telespring.decision.arm_stability import arm_stability
from telespring.decision.decide import decide
from telespring.decision.question import Question
from telespring.model import Study
from telespring.rehearsal.traces import read_traces
from telespring.show.decision_json import arm_stability_json, varying_json
from telespring.show.screens.ages import ages_notes
from telespring.show.screens.questions import session_notes

__all__ = ["answer_study"]

#: The starts of an attack on a delay that varies.
_ATTACK_SEED = 1


def answer_study(study: Study, modules: Path | None = None) -> dict[str, Any]:
    """Compute the key `summary.answer` of `study.json`; programs of a target are looked up in `modules`."""
    question = Question.of_study(study, traces=read_traces(study, modules).texts)
    decision = decide(
        question,
        study.stiffness,
        uncertainty=study.uncertainty,
        compare_free=True,
        attack_seed=_ATTACK_SEED,
    )
    known = decision.uncertainty
    arms = None
    if study.names_arms_or_agents and study.experiment is not None:
        arms = arm_stability(study, [(decision.stiffness, decision.constant_delay)], modules)
    return {
        "status": decision.status,
        "axis": decision.worst_axis.name,
        "stiffness": decision.stiffness,
        "constant_delay_in_use": decision.mean_delay,
        "constant_delay_status": decision.constant_delay_status,
        "is_buffered": decision.buffered,
        "has_playout_buffer": decision.has_playout_buffer,
        "varying_delay": varying_json(decision.varying),
        "is_as_stated": decision.is_as_stated,
        "is_judged": not question.unjudged,
        "ages_notes": [*session_notes(study.session), *ages_notes(question.ages, question.stated)],
        "sample_period": study.network.sample_period,
        "reserve": RESERVE,
        "stiffness_limit": finite_or_none(decision.stiffness_limit),
        "stiffness_to_spare": finite_or_none(decision.stiffness_limit - decision.stiffness),
        "delay_limit": finite_or_none(decision.delay_limit),
        "delay_to_spare": finite_or_none(decision.delay_limit - decision.mean_delay),
        "probability_stable": None if known is None else known.stable.value,
        "free_handles": None if decision.free is None else decision.free.status,
        "in_arms": None if arms is None else arm_stability_json(arms),
        "unstable_conditions": _unstable_conditions(study, question.released()),
    }


def _unstable_conditions(study: Study, free: Question) -> list[dict[str, float]]:
    """List the conditions of the protocol that are unstable with free handles at their constant delay."""
    if study.experiment is None:
        return []
    return [
        {"stiffness": stiffness, "delay": delay}
        for stiffness, delay in study.experiment.conditions
        if stiffness is not None and not is_stable(free.at_delay(delay).judge(stiffness))
    ]
