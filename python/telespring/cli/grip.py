"""How people hold the handles, on the command line."""

from __future__ import annotations

import re

import typer

from telespring._errors import InvalidInput
from telespring.cli.units import DAMPING, MASS, STIFFNESS, WithUnit, read_interval, read_number

__all__ = ["read_grip"]

_RANGE = re.compile(r"\s*(\d+\.?\d*)\s*(?:-|–|\.\.+|…|to|/|\s)\s*(\d+\.?\d*\s*[^\d\s.]*.*)")
_PARTS = (("stiffness", STIFFNESS), ("damping", DAMPING), ("mass", MASS))


def read_grip(written: str, option: str, *, allow_unusual: bool = False) -> dict[str, object]:
    """Read stiffness, damping and mass of a hand, each a number or low:high, as keys of `[operator1]`.

    A comma that was meant as a colon is refused, unless unusual values are allowed.

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
    if not allow_unusual:
        _refuse_a_comma_for_a_colon(parts, written, option)
    keys: dict[str, object] = {}
    for part, (key, unit) in zip(parts, _PARTS, strict=False):
        try:
            low, high = read_interval(part, unit)
        except typer.BadParameter as refused:
            remedy = _colon_between(part) or str(refused)
            raise InvalidInput(option, written, f"the {key} is a number or low:high", remedy) from None
        keys[key] = low if low == high else {"min": low, "max": high}
    return keys


def _colon_between(part: str) -> str:
    """Ask whether 50-300 and 50..300 are ranges; empty if they are something else."""
    found = _RANGE.fullmatch(part)
    return f"Did you mean {found[1]}:{found[2]}? A colon joins the ends of a range." if found else ""


def _refuse_a_comma_for_a_colon(parts: list[str], written: str, option: str) -> None:
    """Refuse "50,300", which was meant as 50:300: N·s/m above the N/m beside them belong to no hand.

    Such a hand would take more than a second to come back. A written unit says what is meant.
    """
    if len(parts) != 2 or ":" in written:
        return
    try:
        stiffness, damping = read_number(parts[0], STIFFNESS), read_number(parts[1], DAMPING)
    except typer.BadParameter:
        return  # refused with the name of its part
    if isinstance(damping, WithUnit) or not 0.0 < stiffness <= damping:
        return
    raise InvalidInput(
        option,
        written,
        f"this is a hand of {stiffness:g} N/m with {damping:g} N·s/m, and no hand is so strongly damped",
        f"Did you mean {parts[0].strip()}:{parts[1].strip()}, a range of stiffness? If the damping is meant, "
        f"write {parts[0].strip()},{parts[1].strip()}Ns/m.",
    )
