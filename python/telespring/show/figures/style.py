"""One look for all figures: colours told apart by colour-blind readers, never colour alone."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.typing import LineStyleType

__all__ = ["COLOURS", "DASHES", "FULL_WIDTH", "GREY", "SERIES", "panel_label", "styled", "to_svg"]

#: Width of a journal page's text, inch.
FULL_WIDTH = 7.16

#: Okabe and Ito's palette, by the names they gave.
COLOURS = {
    "black": "#000000",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "green": "#009E73",
    "blue": "#0072B2",
    "vermilion": "#D55E00",
    "purple": "#CC79A7",
}
GREY = "#8A8A8A"

#: Four members of a family, in the order of their factor.
SERIES = (COLOURS["sky"], COLOURS["blue"], COLOURS["vermilion"], COLOURS["black"])
DASHES: tuple[LineStyleType, ...] = (
    (0.0, (1.2, 1.2)),
    (0.0, (5.0, 1.6)),
    "solid",
    (0.0, (5.0, 1.4, 1.2, 1.4)),
)

_STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "axes.titlesize": 7.5,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#404040",
    "axes.labelcolor": "#202020",
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
    "mathtext.fontset": "dejavusans",
    "hatch.linewidth": 0.5,
    "figure.dpi": 100.0,
    "svg.fonttype": "path",
    "path.simplify": True,
    "path.simplify_threshold": 0.02,
}


@contextmanager
def styled(**overrides: object) -> Iterator[None]:
    """Everything drawn or saved inside has this look, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        # Any: the type of rcParams names every key that exists, a plain dict does not have it.
        settings: Any = {**_STYLE, **overrides}
        mpl.rcParams.update(settings)
        yield


def panel_label(axes: Axes, label: str, text: str = "") -> None:
    """Write a panel's bold letter, and what it shows, above its top left corner."""
    axes.set_title(rf"$\mathbf{{({label})}}$ {text}" if label else text, loc="left", pad=3.0)


def to_svg(figure: Figure, name: str, title: str, description: str) -> str:
    """Render a figure as the text of one `<svg>` element that can stand inside a page.

    The same figure gives the same text every time: no date, no random identifiers.

    Parameters
    ----------
    figure
        What to draw.
    name
        A word that is unique in the page; every identifier inside begins with it.
    title, description
        What a reader who cannot see the figure is told.

    Returns
    -------
    str
        `<svg role="img" ...>` to `</svg>`, with nothing loaded from elsewhere.
    """
    buffer = io.StringIO()
    with styled(**{"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    body = text[text.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.DOTALL)
    # Several figures share the page: without the prefix their glyphs and clips would share names.
    body = re.sub(r'\bid="([^"]+)"', rf'id="{name}-\1"', body)
    body = re.sub(r'href="#([^"]+)"', rf'href="#{name}-\1"', body)
    body = re.sub(r"url\(#([^)]+)\)", rf"url(#{name}-\1)", body)
    # The page knows SVG's name spaces; as attributes they would be the page's only addresses.
    body = re.sub(r'\s+xmlns(?::\w+)?="[^"]*"', "", body).replace("xlink:href", "href")
    opening = f'<svg role="img" aria-labelledby="{name}-title {name}-description"'
    words = (
        f'<title id="{name}-title">{html.escape(title)}</title>'
        f'<desc id="{name}-description">{html.escape(description)}</desc>'
    )
    body = re.sub(r'<svg\b([^>]*?) width="[^"]*pt"', r"<svg\1", body, count=1)
    body = re.sub(r'<svg\b([^>]*?) height="[^"]*pt"', r"<svg\1", body, count=1)
    body = body.replace("<svg", opening, 1)
    end_of_tag = body.index(">") + 1
    return (body[:end_of_tag] + words + body[end_of_tag:]).strip()
