"""What section V of the paper says of its tests, beside ours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["reported"]

#: Words, the family of pairwise tests and the pair, whether significant, and at which level.
_PAIRS = (
    ("TE₁ is less than TE₂ in UM", "robots", "TE1 UM", "TE2 UM", True, 0.001),
    ("TE₂, CM-142-0 against UM", "baseline", "TE2 CM-142-0", "TE2 UM", True, 0.05),
    ("TE₂, CM-142-84 against UM", "baseline", "TE2 CM-142-84", "TE2 UM", True, 0.05),
    ("TE₂, CM-142-167 against UM", "baseline", "TE2 CM-142-167", "TE2 UM", True, 0.05),
    ("TE₂, CM-142-334 against UM", "baseline", "TE2 CM-142-334", "TE2 UM", True, 0.05),
    ("TE₂, CM-71-0 against UM", "baseline", "TE2 CM-71-0", "TE2 UM", False, 0.05),
    ("TE₂, CM-71-167 against UM", "baseline", "TE2 CM-71-167", "TE2 UM", True, 0.001),
    ("TE₂, CM-71-334 against UM", "baseline", "TE2 CM-71-334", "TE2 UM", True, 0.001),
    ("TE₂, CM-71-167 against CM-71-334", "te2_pairs", "TE2 CM-71-167", "TE2 CM-71-334", False, 0.05),
    ("TE₂, CM-142-0 against CM-142-84", "te2_pairs", "TE2 CM-142-0", "TE2 CM-142-84", True, 0.01),
    ("TE₂, CM-142-84 against CM-142-167", "te2_pairs", "TE2 CM-142-84", "TE2 CM-142-167", True, 0.01),
    ("TE₂, CM-142-167 against CM-142-334", "te2_pairs", "TE2 CM-142-167", "TE2 CM-142-334", True, 0.01),
)

#: Words, the conditions of a Kruskal-Wallis test over TE2 by their stiffness and whether with UM.
_GROUPS = (
    ("TE₂ over UM and CM-18", "CM-18-", True, False, 0.05),
    ("TE₂ over UM and CM-36", "CM-36-", True, False, 0.05),
    ("TE₂ over CM-71", "CM-71-", False, True, 0.001),
    ("TE₂ over CM-142", "CM-142-", False, True, 0.001),
)


def reported(analysed: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Set each statement of the paper's section V beside the same test of our trials.

    Parameters
    ----------
    analysed
        What `telespring.analysis.analyse_trials` gives.

    Returns
    -------
    list of dict
        `statement`, `test`, `printed_significant` at the `level` that is printed, our raw `p` and `p_holm`
        (None where a group has no trial), and `agrees`: ours is on the same side of that level. A
        statement on conditions that were not run is left out.
    """
    rows = []
    for words, conditions, with_baseline, significant, level in _GROUPS:
        for each in analysed["kruskal_wallis"]:
            names = [name.removeprefix("TE2 ") for name in each["groups"]]
            connected = [name for name in names if name.startswith(conditions)]
            if each["robot"] == 2 and connected and len(names) == len(connected) + with_baseline:
                rows.append(_row(words, "Kruskal-Wallis", significant, level, each))
    for words, family, first, second, significant, level in _PAIRS:
        rows += [
            _row(words, "Wilcoxon rank-sum", significant, level, each)
            for each in analysed["wilcoxon"][family]["comparisons"]
            if {each["first"], each["second"]} == {first, second}
        ]
    return rows


def _row(words: str, test: str, significant: bool, level: float, found: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "statement": words,
        "test": test,
        "printed_significant": significant,
        "level": level,
        "p": found["p"],
        "p_holm": found["p_holm"],
        "agrees": None if found["p"] is None else (found["p"] < level) == significant,
    }
