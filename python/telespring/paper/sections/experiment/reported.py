"""Statistical tests reported in Section V of the paper, and the same tests on our trials."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from telespring.references import read_reference

__all__ = ["compare_reported_tests"]


def compare_reported_tests(analysed: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Compare each test reported in Section V of the paper with the same test on our trials.

    A row's `agrees` is whether our raw `p` is on the same side of the printed `level`. Statements on
    conditions that were not run are left out; `p` is None if a group has no trial, and `agrees` also if the
    distinct trials are too few for a p below the level.
    """
    printed = read_reference("du2025")["section5"]
    rows = []
    for statement in printed["kruskal_wallis"]:
        for result in analysed["kruskal_wallis"]:
            labels = [name.removeprefix("TE2 ") for name in result["groups"]]
            connected = [label for label in labels if label.startswith(statement["conditions"])]
            is_same_test = len(labels) == len(connected) + statement["with_baseline"]
            if result["robot"] == 2 and connected and is_same_test:
                rows.append(_reported_test_row("Kruskal-Wallis", statement, result))
    for statement in printed["rank_sum"]:
        rows += [
            _reported_test_row("Wilcoxon rank-sum", statement, result)
            for result in analysed["wilcoxon"][statement["family"]]["comparisons"]
            if {result["first"], result["second"]} == {statement["first"], statement["second"]}
        ]
    return rows


def _reported_test_row(test: str, statement: Mapping[str, Any], result: Mapping[str, Any]) -> dict[str, Any]:
    significant, level = statement["significant"], statement["level"]
    least = result.get("least_p")
    is_possible = result["p"] is not None and (least is None or least < level)
    return {
        "statement": statement["statement"],
        "test": test,
        "printed_significant": significant,
        "level": level,
        "p": result["p"],
        "p_holm": result["p_holm"],
        "is_p_bound": bool(result.get("is_p_bound", False)),
        "agrees": (result["p"] < level) == significant if is_possible else None,
    }
