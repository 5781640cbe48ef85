"""The tiers of the verdicts and the paper's verdict, in words."""

from typing import NamedTuple

__all__ = ["TIERS", "TierText"]


class TierText(NamedTuple):
    """What one tier assumes about the network, and its rule.

    Attributes
    ----------
    key
        Its key in `study.json` and in the output of `decide --json`.
    network
        What it assumes about the network.
    rule
        The rule in words.
    formula
        The rule in the symbols of NOTATION.md, for a narrow column; T is the age of the oldest sample.
    """

    key: str
    network: str
    rule: str
    formula: str


#: By name, the strongest guarantee last, and the paper's verdict.
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
    "age in a range": TierText(
        "age_in_a_range",
        "any variation of the delay within a range of sample ages; no sample is played after a newer one",
        (
            "stable at the mean age, and half the width of the range times the largest gain from a delay's "
            "error to the coupling signals' rates is below 1 (docs/age-range.md)"
        ),
        "J·sup σₘₐₓ < 1",
    ),
    "bounded varying delay": TierText(
        "bounded_varying_delay",
        "any variation of the delay, with a known limit on the age of a sample",
        (
            "twice the geometric mean √(b₁b₂) of the dampings exceeds the stiffness times the sum of "
            "the largest sample ages in both directions"
        ),
        "k < 2√(b₁b₂)/(T₁+T₂)",
    ),
    "any network": TierText(
        "any_network",
        "any delays, jitter, losses and reordering, with gaps of bounded length",
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
