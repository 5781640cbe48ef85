"""The answer of `telespring trace --json`: SI units, and None for what is infinite or does not exist."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from telespring._json import finite_or_none
from telespring.show.tiers import TIERS

if TYPE_CHECKING:
    from telespring.traces import PlayoutChoice, TraceAssessment

__all__ = ["trace_json"]


def trace_json(found: TraceAssessment) -> dict[str, Any]:
    """Return what `docs/traces.md` lists for `telespring trace --json`."""
    best, paused = found.recommended, found.if_paused
    return {
        "schema": 1,
        "ways": [
            {
                "statistics": way.statistics.to_dict(),
                "duration": way.trace.duration,
                "missing_rows": None if way.missing is None else asdict(way.missing),
                "fit": way.fit.to_dict(),
                "evidence": asdict(way.evidence),
                "silences": asdict(way.silences),
            }
            for way in found.ways
        ],
        "sample_period": found.sample_period,
        "playouts": [_choice_json(choice) for choice in found.playouts],
        "recommended": _choice_json(best)
        | {"guard": found.needs_guard, "stiffness": found.stiffness, "settings": found.settings()},
        "guarded": _choice_json(found.guarded),
        "guard_stiffness": found.guard_stiffness,
        "recommended_if_paused": None if paused is None else _choice_json(paused),
        "axes_independent": found.axes_independent,
    }


def _choice_json(choice: PlayoutChoice) -> dict[str, Any]:
    return {
        "delay": choice.delay,
        "packets_awaited": choice.share,
        "in_time": choice.in_time,
        "ages": [list(ages) for ages in choice.ages],
        "mostly_ages": [list(ages) for ages in choice.mostly_ages],
        "bounds": {
            TIERS[tier].key: None if bound is None else finite_or_none(bound)
            for tier, bound in choice.bounds.items()
        },
        "stiffness_limit": finite_or_none(choice.stiffness_limit),
        "tier": choice.tier,
        "usable_stiffness": finite_or_none(choice.usable_stiffness),
        "recommended_stiffness": choice.recommended_stiffness,
        "mostly_usable_stiffness": finite_or_none(choice.mostly_usable_stiffness),
    }
