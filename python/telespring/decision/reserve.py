"""What a stable dyad must keep in reserve before it is called stable: 5 % of stiffness and of delay."""

from __future__ import annotations

from telespring._core import LEAST_PROBABILITY, RESERVE, WITHIN
from telespring._types import Status

__all__ = ["LEAST_PROBABILITY", "RESERVE", "WITHIN", "Status"]
