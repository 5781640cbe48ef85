"""The tiers of the verdicts and the paper's verdict, in words."""

from typing import NamedTuple

__all__ = ["TIERS", "TierText"]


class TierText(NamedTuple):
    """What one tier lets the network do, and its rule.

    Attributes
    ----------
    key
        Its key in `study.json` and in the output of `decide --json`.
    network
        What the network may do.
    rule
        The rule in words.
    formula
        The rule in the symbols of NOTATION.md, for a narrow column; T is the age of the oldest sample.
    """

    key: str
    network: str
    rule: str
    formula: str


#: By name, the strongest guarantee last; the paper's verdict stands beside them.
TIERS = {
    "constant delay": TierText(
        "constant_delay",
        "one known constant delay",
        "the delay lies in a stable interval of this stiffness",
        "δ in a stable interval",
    ),
    "any constant delay": TierText(
        "any_constant_delay",
        "any constant delay (a playout buffer makes it constant)",
        "the stiffness is below the critical stiffness",
        "k < kₘ exact",
    ),
    "bounded varying delay": TierText(
        "bounded_varying_delay",
        "any variation up to a known longest age of a sample",
        (
            "twice the mean damping √(b₁b₂) exceeds the stiffness times the age of the "
            "oldest samples, there and back"
        ),
        "k < 2√(b₁b₂)/(T₁+T₂)",
    ),
    "any network": TierText(
        "any_network",
        "anything at all, with bounded gaps",
        "no robot overshoots a partner that is held still: stiffness ≤ b²/(4m) for a free handle",
        "k ≤ b²/(4m) if free",
    ),
    "paper": TierText(
        "paper",
        "the paper's claim (Eqs. 5 to 9): one constant delay",
        "the stiffness is at most that of Eq. 5, or the delay is below that of Eq. 6",
        "k ≤ Eq. 5 or δ < Eq. 6",
    ),
}
