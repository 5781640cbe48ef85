"""The summary that `telespring reproduce` prints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from telespring.show.quantities import format_number

__all__ = ["allowed_stiffnesses"]


def allowed_stiffnesses(summary: Mapping[str, Any]) -> Iterator[str]:
    """Yield the stiffness that each kind of network allows, from `summary` of `study.json`."""
    row = summary["rows"][summary["highlight"]]
    yield f"Over {1e3 * row['delay']:.0f} ms each way the spring may have up to"
    for tier in summary["tiers"]:
        entry = row[tier["key"]]
        if entry["unbounded"]:
            limit = "no limit"
        elif entry["stiffness"] is None:
            limit = "not available"
        else:
            limit = f"{format_number(entry['stiffness'], rounding='down')} N/m (axis {entry['axis']})"
        yield f"  {limit:<24} {tier['name']}"
