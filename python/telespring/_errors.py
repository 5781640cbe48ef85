"""The one exception that bad input raises."""

from __future__ import annotations

from typing import Self


class InvalidInput(ValueError):
    """A value that was refused, with what is allowed instead and how to mend it.

    Parameters
    ----------
    field : str
        Where the value stands, such as ``robot1.mass[0]`` or ``k[2, 3]``.
    value : str
        The value as given; empty where it is missing.
    allowed : str
        What is allowed there, with its unit; of a missing value only the unit.
    remedy : str
        The nearest way to mend it, a full sentence.

    Examples
    --------
    >>> import telespring as ts
    >>> try:
    ...     ts.Robot(mass=-1.0, damping=4.0)
    ... except ts.InvalidInput as refused:
    ...     print(refused.field, refused.value)
    mass[0] -1
    """

    field: str
    value: str
    allowed: str
    remedy: str
    _index: int | None = None

    def __init__(self, field: str, value: str, allowed: str, remedy: str) -> None:
        super().__init__(field, value, allowed, remedy)
        self.field = field
        self.value = value
        self.allowed = allowed
        self.remedy = remedy

    def __str__(self) -> str:
        return f"{self.statement} {self.remedy}"

    @property
    def statement(self) -> str:
        """The first sentence of the message: what is wrong, without the remedy."""
        if self.value:
            return f"{self.field} = {self.value}: {self.allowed}."
        return f"Missing {self.field} ({self.allowed})." if self.allowed else f"Missing {self.field}."

    def at(self, field: str) -> Self:
        """Return the same refusal with another place."""
        return type(self)(field, self.value, self.allowed, self.remedy)
