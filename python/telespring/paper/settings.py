"""The multiples of K and Δ at which the paper draws its figures, in numbers and in words."""

from __future__ import annotations

__all__ = ["FACTORS", "WORDS", "setting_in_words"]

FACTORS = (0.5, 1.0, 2.0, 4.0)
WORDS = {0.0: "0", 0.5: "0.5", 1.0: "", 2.0: "2", 4.0: "4"}


def setting_in_words(stiffness_factor: float, delay_factor: float) -> str:
    """Write a stiffness and a delay in multiples of K and Δ."""
    delay = f"δ = {WORDS[delay_factor]}{'Δ' if delay_factor else ''}"
    return f"k = {WORDS[stiffness_factor]}K, {delay}"
