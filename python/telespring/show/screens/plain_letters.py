"""Screens in letters that a terminal has: Greek, subscripts and signs spelt out where it has ASCII only."""

from __future__ import annotations

from itertools import pairwise

from rich.console import Group, RenderableType
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from telespring.show.screens.layout import Fitting

__all__ = ["for_encoding", "to_ascii"]

_SPELT = {
    "δₘ": "d_m", "kₘ": "k_m", "δ": "d", "ₘ": "_m", "₁": "1", "₂": "2", "≤": "<=", "≥": ">=", "√": "sqrt",
    "·": "*", "±": "+/-", "–": "-", "−": "-", "—": "-", "…": "...", "²": "^2", "³": "^3", "°": " deg",
    "ε": "eps", "χ": "chi", "ω": "omega", "ξ": "xi", "η": "eta", "Δ": "Delta", "σ": "sigma", "τ": "tau",
    "α": "alpha", "π": "pi", "µ": "u", "μ": "u", "×": "x", "↑": "^", "↓": "v", "→": "->", "⁻": "-", "é": "e",
    "ö": "oe", "ä": "ae", "ü": "ue", "ß": "ss", "ñ": "n", "“": '"', "”": '"', "’": "'", "‘": "'",
    "\N{NO-BREAK SPACE}": " ", "\N{NARROW NO-BREAK SPACE}": " ",
}  # fmt: skip


def to_ascii(text: str) -> str:
    """Spell letters that are not ASCII; unknown ones become a question mark.

    Examples
    --------
    >>> to_ascii("k ≤ b²/(4m), δₘ ± 2 N·s/m")
    'k <= b^2/(4m), d_m +/- 2 N*s/m'
    """
    for letters, spelling in _SPELT.items():
        text = text.replace(letters, spelling)
    return text.encode("ascii", "replace").decode("ascii")


def for_encoding(renderable: RenderableType, encoding: str) -> RenderableType:
    """Return a screen whose text can be written in this encoding; its columns are set after the spelling."""
    if isinstance(renderable, str):
        return _encodable(renderable, encoding)
    if isinstance(renderable, Text):
        return _encodable_text(renderable, encoding)
    if isinstance(renderable, Group):
        return Group(*(for_encoding(part, encoding) for part in renderable.renderables))
    if isinstance(renderable, Padding):
        inner = for_encoding(renderable.renderable, encoding)
        return Padding(inner, (renderable.top, renderable.right, renderable.bottom, renderable.left))
    if isinstance(renderable, Fitting):
        title = None if renderable.title is None else for_encoding(renderable.title, encoding)
        return Fitting(title, *(for_encoding(each, encoding) for each in renderable.choices))
    if isinstance(renderable, Table):
        for column in renderable.columns:
            column.header = for_encoding(column.header, encoding)
            column._cells = [for_encoding(cell, encoding) for cell in column.cells]
        if renderable.title is not None:
            title = renderable.title
            renderable.title = (
                _encodable_text(title, encoding) if isinstance(title, Text) else _encodable(title, encoding)
            )
    return renderable


def _encodable(text: str, encoding: str) -> str:
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return to_ascii(text)
    return text


def _encodable_text(text: Text, encoding: str) -> Text:
    plain = _encodable(text.plain, encoding)
    if plain == text.plain:
        return text
    # Styles keep their words: the text is spelt between the places where a style begins or ends.
    edges = sorted({0, len(text), *(span.start for span in text.spans), *(span.end for span in text.spans)})
    spelt = Text(style=text.style, justify=text.justify, overflow=text.overflow, no_wrap=text.no_wrap)
    for start, end in pairwise(edges):
        styles = [str(span.style) for span in text.spans if span.start <= start and end <= span.end]
        spelt.append(_encodable(text.plain[start:end], encoding), " ".join(styles) or None)
    return spelt
