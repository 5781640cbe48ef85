"""Refused input on the terminal."""

from rich.console import Console
from rich.text import Text

from telespring._errors import InvalidInput

__all__ = ["refusal_screen"]


def refusal_screen(console: Console, refused: InvalidInput) -> None:
    """Print why an input was refused: field, value, allowed values and remedy."""
    if refused.value:
        value = f" = {refused.value}"
        console.print(Text.assemble(("Refused: ", "bold red"), (refused.field, "bold"), value))
        console.print(Text(f"  because {refused.allowed}."))
    else:
        console.print(Text.assemble(("Refused: ", "bold red"), refused.statement))
    console.print(Text(f"  {refused.remedy}"))
