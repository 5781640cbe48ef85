"""How people hold the handles, on the command line."""

from __future__ import annotations

import typer

from telespring._errors import InvalidInput
from telespring.cli.units import DAMPING, MASS, STIFFNESS, read_interval

__all__ = ["read_grip"]

_PARTS = (("stiffness", STIFFNESS), ("damping", DAMPING), ("mass", MASS))


def read_grip(written: str, option: str) -> dict[str, object]:
    """Read stiffness, damping and mass of a hand, each a number or low:high, as keys of `[operator1]`.

    Examples
    --------
    >>> read_grip("50:300", "--grip")
    {'stiffness': {'min': 50.0, 'max': 300.0}}
    >>> read_grip("120,2:5,0.5", "--grip")
    {'stiffness': 120.0, 'damping': {'min': 2.0, 'max': 5.0}, 'mass': 0.5}
    """
    parts = written.split(",")
    if len(parts) > len(_PARTS):
        raise InvalidInput(
            option,
            written,
            "a grip has a stiffness, a damping and a mass at most",
            "Write, for example, 50:300 (N/m), or 50:300,0:5,0:0.5 (N/m, N·s/m, kg).",
        )
    keys: dict[str, object] = {}
    for part, (key, unit) in zip(parts, _PARTS, strict=False):
        try:
            low, high = read_interval(part, unit)
        except typer.BadParameter as refused:
            raise InvalidInput(option, written, f"the {key} is a number or low:high", str(refused)) from None
        keys[key] = low if low == high else {"min": low, "max": high}
    return keys
