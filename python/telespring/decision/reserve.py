"""What a stable dyad must keep in reserve before it is called stable: 5 % of stiffness and of delay."""

from __future__ import annotations

from typing import Literal, TypeAlias

__all__ = ["LEAST_PROBABILITY", "RESERVE", "WITHIN", "Status"]

#: Share of the stiffness, and of the delay, that a stable dyad keeps in reserve; with less it is marginal.
RESERVE = 0.05
#: A dyad whose robots have errors is marginal if it is stable with a smaller probability.
LEAST_PROBABILITY = 0.95
#: A factor that keeps rounding on the safe side of a limit.
WITHIN = 1.0 - 1e-9

#: The answer in one word. "marginal" is stable without the reserve; "not proven" is stable as far as was
#: examined, where something that was not examined may decide.
Status: TypeAlias = Literal["stable", "marginal", "unstable", "not proven"]
