"""Labels in the names of BIDS files: letters and digits only."""

from __future__ import annotations

import re
from collections.abc import Iterable

from telespring._arrays import quoted_value
from telespring._errors import InvalidInput

__all__ = ["bids_label", "check_distinct"]


def bids_label(text: str, field: str) -> str:
    """Return the letters and digits of a text; InvalidInput if it has none.

    Examples
    --------
    >>> bids_label("CM-36-167", "condition")
    'CM36167'
    """
    label = re.sub(r"[^0-9A-Za-z]", "", text)
    if not label:
        raise InvalidInput(
            field,
            quoted_value(text),
            "a label with letters a to z or digits is required: BIDS allows no others in a name",
            "Name it otherwise.",
        )
    return label


def check_distinct(people: Iterable[tuple[str, str]]) -> None:
    """Refuse one person at both robots, and labels that differ in case only: some disks do not tell them."""
    spellings: dict[str, str] = {}
    for pair in people:
        if pair[0].casefold() == pair[1].casefold():
            raise InvalidInput(
                "participants",
                f"{pair[0]} at both robots",
                "two people are required",
                "Name both, as in --participants P01,P02.",
            )
        for label in pair:
            other = spellings.setdefault(label.casefold(), label)
            if other != label:
                raise InvalidInput(
                    "participants",
                    f"{other} and {label}",
                    "labels that differ in more than case are required",
                    "Write each code in one way.",
                )
