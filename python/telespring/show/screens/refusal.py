"""Refused input on the terminal."""

from rich.console import Console
from rich.text import Text

__all__ = ["refusal_screen"]


def refusal_screen(console: Console, field: str, value: str, allowed: str, remedy: str) -> None:
    """Print why an input was refused: field, value, allowed values and remedy."""
    if value:
        console.print(Text.assemble(("Refused: ", "bold red"), (field, "bold"), f" = {value}"))
        console.print(Text(f"  because {allowed}."))
    else:
        unit = f" ({allowed})" if allowed else ""
        console.print(Text.assemble(("Refused: ", "bold red"), (field, "bold"), f" is missing{unit}."))
    console.print(Text(f"  {remedy}"))
