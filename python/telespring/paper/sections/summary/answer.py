"""Whether the study's own stiffness is stable over its network, and how close the limit is."""

from __future__ import annotations

from typing import Any

from telespring._json import finite_or_none
from telespring.decision.decide import decide
from telespring.decision.question import Question
from telespring.decision.reserve import RESERVE
from telespring.model import Study
from telespring.show.decision_json import varying_json

__all__ = ["answer_study"]


def answer_study(study: Study) -> dict[str, Any]:
    """Compute the key `summary.answer` of `study.json`."""
    question = Question(study.dyad, study.network, study.operator_ranges, study.has_playout_buffer)
    decision = decide(question, study.stiffness, uncertainty=study.uncertainty, compare_free=True)
    known = decision.uncertainty
    return {
        "status": decision.status,
        "axis": decision.worst_axis.name,
        "stiffness": decision.stiffness,
        "constant_delay_in_use": decision.mean_delay,
        "constant_delay_status": decision.constant_delay_status,
        "is_buffered": decision.buffered,
        "has_playout_buffer": decision.has_playout_buffer,
        "varying_delay": varying_json(decision.varying),
        "sample_period": study.network.sample_period,
        "reserve": RESERVE,
        "stiffness_limit": finite_or_none(decision.stiffness_limit),
        "stiffness_to_spare": finite_or_none(decision.stiffness_limit - decision.stiffness),
        "delay_limit": finite_or_none(decision.delay_limit),
        "delay_to_spare": finite_or_none(decision.delay_limit - decision.mean_delay),
        "probability_stable": None if known is None else known.stable.value,
        "free_handles": None if decision.free is None else decision.free.status,
    }
