"""The exception for invalid input, and the warnings about results that are less than they should be."""

from __future__ import annotations

from typing import Self

__all__ = ["ApproximationWarning", "CertificateWarning", "InvalidInput"]


class InvalidInput(ValueError):
    """A value that was refused, what is allowed, and how to correct it.

    Parameters
    ----------
    field : str
        The place of the value, such as ``robot1.mass[0]`` or ``k[2, 3]``.
    value : str
        The value as given; empty if it is missing.
    allowed : str
        What is allowed there, with its unit; of a missing value only the unit.
    remedy : str
        The nearest way to correct it, a full sentence.

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
        """Return the same refusal for another field."""
        return type(self)(field, self.value, self.allowed, self.remedy)


class CertificateWarning(RuntimeWarning):
    """The argument principle does not confirm that all characteristic roots were found."""


class ApproximationWarning(RuntimeWarning):
    """A force or a history given as a function of time is not approximated as well as it should be."""
