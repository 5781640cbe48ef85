"""The look of all figures: colours that colour-blind readers can tell apart, never colour alone."""

from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xml.etree import ElementTree as ET

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.typing import LineStyleType

__all__ = [
    "COLOURS",
    "DASHES",
    "FULL_WIDTH",
    "GREY",
    "ROBOT_COLOURS",
    "SERIES",
    "figure_style",
    "legend_line",
    "legend_mark",
    "panel_label",
    "sized_figure",
    "text_colour",
    "to_svg",
]

#: Width of a journal page's text, inch.
FULL_WIDTH = 7.16

#: The palette of Okabe and Ito, by the names they gave.
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

#: Robots 1 and 2, the same in every figure.
ROBOT_COLOURS = (COLOURS["blue"], COLOURS["vermilion"])

#: Shades for text, with a contrast of at least 4.5 to white (WCAG 2.2, 1.4.3).
_TEXT_COLOURS = {
    COLOURS["orange"]: "#8A5F00",
    COLOURS["purple"]: "#9A3D74",
    COLOURS["vermilion"]: "#A8430A",
    COLOURS["green"]: "#006B4E",
    COLOURS["sky"]: "#1F6E9C",
    GREY: "#606060",
}

#: Four members of a family, in the order of their factor.
SERIES = (COLOURS["sky"], COLOURS["blue"], COLOURS["vermilion"], COLOURS["black"])
DASHES: tuple[LineStyleType, ...] = (
    (0.0, (1.2, 1.2)),
    (0.0, (5.0, 1.6)),
    "solid",
    (0.0, (5.0, 1.4, 1.2, 1.4)),
)

_STYLE = {
    # Matplotlib lays out with the first one; a reader's machine has another of about the same widths.
    "font.family": ["DejaVu Sans"],
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
    # Text that can be searched, copied and enlarged, and that takes a tenth of the space of outlines.
    "svg.fonttype": "none",
    "path.simplify": True,
    "path.simplify_threshold": 0.02,
}


_HREF = "{http://www.w3.org/1999/xlink}href"
_PNG = "data:image/png;base64,"
_DECIMALS = re.compile(r"-?\d+\.\d+")


@contextmanager
def figure_style(**overrides: object) -> Iterator[None]:
    """Draw and save with the look of all figures, whatever the user's own settings are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        # Any: the type of rcParams names every key that exists, a plain dict does not have it.
        settings: Any = {**_STYLE, **overrides}
        mpl.rcParams.update(settings)
        yield


def sized_figure(figure: Figure | None, width: float, height: float) -> Figure:
    """Return the given figure, resized (inch), or a new one."""
    if figure is None:
        return Figure(figsize=(width, height))
    figure.set_size_inches(width, height)
    return figure


def panel_label(axes: Axes, label: str, text: str = "") -> None:
    """Write the bold letter of a panel, and its title, above the top left corner."""
    axes.set_title(rf"$\mathbf{{({label})}}$ {text}" if label else text, loc="left", pad=3.0)


def text_colour(colour: str) -> str:
    """Return the shade in which text of this colour can be read on white."""
    return _TEXT_COLOURS.get(colour, colour)


def legend_line(label: str, colour: str, linestyle: LineStyleType = "solid", **style: Any) -> Line2D:
    """Return a line for the legend of a figure."""
    return Line2D([], [], color=colour, linestyle=linestyle, label=label, **style)


def legend_mark(label: str, colour: str, marker: str, **style: Any) -> Line2D:
    """Return a marker for the legend of a figure."""
    return Line2D([], [], color=colour, linestyle="none", marker=marker, label=label, **style)


def to_svg(figure: Figure, name: str, title: str, description: str) -> str:
    """Render a figure as one `<svg>` element for use inside a page and loads nothing from elsewhere.

    The same figure gives the same text every time: no date, no random identifiers. Every identifier inside
    begins with `name`, a word that is unique in the page. Title and description are for readers who cannot
    see it.
    """
    buffer = io.StringIO()
    with figure_style(**{"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    root = ET.fromstring(buffer.getvalue())
    for metadata in root.findall("{*}metadata"):
        root.remove(metadata)
    for element in root.iter():
        for key in ("d", "x", "y"):
            if key in element.attrib:
                element.set(key, _round_coordinates(element.attrib[key]))
        _share_style_of_markers(element)
        if element.get(_HREF, "").startswith(_PNG):
            element.set(_HREF, _PNG + _with_fewer_colours(element.attrib[_HREF].removeprefix(_PNG)))
        # A page knows SVG's namespaces; as attributes they would be its only addresses.
        element.tag = _svg_local_name(element.tag)
        element.attrib = {
            _svg_local_name(key): _svg_id_with_prefix(_svg_local_name(key), value, f"{name}-")
            for key, value in element.attrib.items()
        }
    size = {key: value for key, value in root.attrib.items() if key not in ("width", "height")}
    root.attrib = {"role": "img", "aria-labelledby": f"{name}-title {name}-description", **size}
    for i, (tag, text) in enumerate((("title", title), ("desc", description))):
        words = ET.Element(tag, id=f"{name}-{'title' if tag == 'title' else 'description'}")
        words.text = text
        root.insert(i, words)
    return ET.tostring(root, encoding="unicode").strip()


def _round_coordinates(text: str) -> str:
    """Round coordinates to a hundredth of a point, which no reader can see."""
    return _DECIMALS.sub(lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), text)


def _share_style_of_markers(group: ET.Element) -> None:
    """Write a style that all markers of a group have once, on the group."""
    markers = group.findall("{*}use")
    styles = {marker.get("style", "") for marker in markers}
    if len(markers) > 1 and len(styles) == 1 and "style" not in group.attrib:
        group.set("style", styles.pop())
        for marker in markers:
            marker.attrib.pop("style", None)


def _with_fewer_colours(encoded: str) -> str:
    """Reduce an image of drawn lines to 64 colours, a third of its size; nobody can tell them apart."""
    from PIL import Image

    image = Image.open(io.BytesIO(base64.b64decode(encoded))).convert("RGBA")
    buffer = io.BytesIO()
    image.quantize(64, method=Image.Quantize.FASTOCTREE).save(buffer, format="png", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def _svg_local_name(name: str) -> str:
    return name.rpartition("}")[2]


def _svg_id_with_prefix(key: str, value: str, prefix: str) -> str:
    """Prefix an identifier or a reference to one: without it, the figures of a page would share names."""
    if key == "id":
        return prefix + value
    if key == "href":
        return value.replace("#", f"#{prefix}", 1)
    return value.replace("url(#", f"url(#{prefix}")
