"""Figs. 1, 2 and 6: the coupled robots, their control loop, and the laboratory, as schematics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyBboxPatch, Polygon, Rectangle

from telespring.show.figures.style import (
    COLOURS,
    FULL_WIDTH,
    GREY,
    ROBOT_COLOURS,
    figure_style,
    text_colour,
)

if TYPE_CHECKING:
    from telespring._types import FloatArray

__all__ = ["DrawnSide", "dyad_schematic", "laboratory_schematic", "loop_schematic"]

_INK = "#202020"
_SPRING = COLOURS["purple"]
_FORCE = _INK
_FIRST, _SECOND = ROBOT_COLOURS
_FILL = "#F3F6F5"

_Point = tuple[float, float]

#: Letters of a robot's name that find room.
_LETTERS = 22


@dataclass(frozen=True)
class DrawnSide:
    """One side of the laboratory: robot, arm and agent.

    Attributes
    ----------
    robot
        Its name.
    agent
        Label next to the target, in one or two lines.
    spots
        Of the cloud that the agent follows; 0 if it follows the target itself.
    arm
        What is written below the arm.
    links
        "drawn" for a two-link arm, "dashed" for one that is not simulated, "block" for an arm with mass and
        damping, "none" for a massless one.
    elbow
        "left" or "right", seen from the shoulder.
    """

    robot: str
    agent: str
    spots: int = 0
    arm: str = ""
    links: Literal["drawn", "dashed", "block", "none"] = "drawn"
    elbow: str = "left"


def dyad_schematic() -> Figure:
    """Draw Fig. 1: two masses with dampers, coupled by a spring through delayed positions."""
    with figure_style():
        figure, axes = _schematic_canvas(10.0, 3.5)
        axes.plot([0.15, 9.85], [0.75, 0.75], color=_INK, linewidth=1.0)
        for x in np.arange(0.2, 9.8, 0.3):
            axes.plot([x, x - 0.12], [0.75, 0.6], color=GREY, linewidth=0.6)
        for x in (0.15, 9.85):
            axes.plot([x, x], [0.75, 2.1], color=_INK, linewidth=1.0)
        for left, colour, number in ((2.1, _FIRST, 1), (6.3, _SECOND, 2)):
            axes.add_patch(
                Rectangle((left, 0.85), 1.6, 1.3, facecolor=_FILL, edgecolor=colour, linewidth=1.4, zorder=3)
            )
            axes.text(left + 0.8, 1.5, f"$m_{number}$", ha="center", va="center", fontsize=11, zorder=4)
            for wheel in (left + 0.35, left + 1.25):
                axes.add_patch(Circle((wheel, 0.8), 0.05, facecolor="white", edgecolor=_INK, linewidth=0.6))
        _draw_damper_cylinder(axes, (0.15, 1.5), (2.1, 1.5))
        _draw_damper_cylinder(axes, (9.85, 1.5), (7.9, 1.5))
        axes.text(1.1, 1.85, "$b_1$", ha="center", fontsize=9)
        axes.text(8.9, 1.85, "$b_2$", ha="center", fontsize=9)
        _draw_spring_zigzag(axes, (3.7, 1.5), (6.3, 1.5), turns=7)
        axes.text(5.0, 1.76, "$k$", ha="center", fontsize=10, color=text_colour(_SPRING))
        axes.text(
            5.0,
            1.0,
            r"virtual spring, delay $\delta$ each way",
            ha="center",
            fontsize=6.5,
            color=text_colour(_SPRING),
        )
        for x, number, tip in ((2.9, 1, 2.95), (7.1, 2, 7.65)):
            _draw_schematic_arrow(axes, (tip - 0.8, 2.4), (tip, 2.4), _FORCE)
            axes.text(tip - 0.4, 2.52, f"$f_{number}(t)$", ha="center", fontsize=8.5, color=_FORCE)
            axes.plot([x, x], [0.32, 0.56], color=_INK, linewidth=0.7)
            _draw_schematic_arrow(axes, (x, 0.44), (x + 0.75, 0.44), _INK)
            axes.text(x + 0.85, 0.44, f"$x_{number}(t)$", va="center", fontsize=8.5)
        _draw_schematic_arrow(axes, (3.75, 2.4), (4.5, 2.4), _SPRING)
        _draw_schematic_arrow(axes, (5.5, 2.4), (6.25, 2.4), _SPRING)
        axes.text(
            4.0, 2.58, r"$k\,(x_2(t-\delta)-x_1(t))$", ha="left", fontsize=7.5, color=text_colour(_SPRING)
        )
        axes.text(
            6.2, 2.98, r"$k\,(x_1(t-\delta)-x_2(t))$", ha="right", fontsize=7.5, color=text_colour(_SPRING)
        )
        axes.plot([5.9, 5.9], [2.48, 2.92], color=_SPRING, linewidth=0.5, linestyle=(0, (1, 1.5)))
    return figure


def loop_schematic() -> Figure:
    """Draw Fig. 2: the control loop with both robots and both delays."""
    with figure_style():
        figure, axes = _schematic_canvas(10.0, 4.75)
        rows = ((3.4, 1, 2, 1.0, _FIRST), (1.2, 2, 1, -1.0, _SECOND))
        for y, own, partner, sense, colour in rows:

            def at(x: float, sense: float = sense) -> float:
                """Robot 2's row runs from right to left."""
                return x if sense > 0 else 10.0 - x

            low, high = min(at(1.9), at(7.95)), max(at(1.9), at(7.95))
            axes.add_patch(
                FancyBboxPatch(
                    (low, y - 0.85),
                    high - low,
                    1.62,
                    boxstyle="round,pad=0.02",
                    facecolor="none",
                    edgecolor=colour,
                    linewidth=1.0,
                    linestyle=(0, (4, 2)),
                )
            )
            axes.text(
                at(7.85),
                y + 0.56,
                f"robot {own}",
                ha="right" if sense > 0 else "left",
                color=text_colour(colour),
            )
            _draw_schematic_arrow(axes, (at(0.95), y), (at(2.22), y))
            _draw_summing_point(axes, (at(2.4), y))
            _draw_schematic_arrow(axes, (at(2.58), y), (at(3.1), y))
            _draw_block(axes, (at(3.45), y), 0.7, 0.62, "$k$", _SPRING)
            _draw_schematic_arrow(axes, (at(3.8), y), (at(4.32), y))
            _draw_summing_point(axes, (at(4.5), y))
            _draw_schematic_arrow(axes, (at(4.68), y), (at(5.15), y))
            _draw_block(axes, (at(6.05), y), 1.8, 0.8, rf"$\dfrac{{1}}{{m_{own}s^2+b_{own}s}}$", colour)
            axes.plot([at(6.95), at(9.05)], [y, y], color=_INK, linewidth=0.9)
            axes.plot([at(7.5)], [y], "o", color=_INK, markersize=2.6)
            axes.plot([at(7.5), at(7.5), at(2.4)], [y, y - 0.62, y - 0.62], color=_INK, linewidth=0.9)
            _draw_schematic_arrow(axes, (at(2.4), y - 0.62), (at(2.4), y - 0.18))
            axes.text(at(2.4) + 0.1, y - 0.34, "−", fontsize=8, va="center")
            axes.text(at(2.16), y + 0.17, "+", fontsize=7, ha="center")
            axes.text(at(4.26), y + 0.17, "+", fontsize=7, ha="center")
            _draw_schematic_arrow(axes, (at(4.5), y + 1.05), (at(4.5), y + 0.18), _FORCE)
            axes.text(at(4.5) + 0.12, y + 0.9, f"$F_{own}(s)$", color=_FORCE, fontsize=8.5, va="center")
            axes.text(at(8.4), y + 0.12, f"$X_{own}(s)$", ha="center", fontsize=8.5)
            axes.text(
                at(1.3), y + 0.12, rf"$e^{{-\delta s}}X_{partner}$", ha="center", fontsize=7.5, color=_INK
            )
        for x, start, end, words in (
            (9.05, 3.4, 1.2, "to side 2"),
            (0.95, 1.2, 3.4, "to side 1"),
        ):
            middle = (start + end) / 2
            step = 0.36 if end < start else -0.36
            _draw_schematic_arrow(axes, (x, start), (x, middle + step))
            _draw_block(axes, (x, middle), 1.15, 0.66, r"$e^{-\delta s}$", COLOURS["orange"])
            axes.plot([x, x], [middle - step, end], color=_INK, linewidth=0.9)
            axes.text(
                x + (-0.68 if x > 5 else 0.68), middle, words, ha="right" if x > 5 else "left", va="center"
            )
        axes.text(
            3.6,
            2.3,
            r"round trip $2\delta$",
            ha="center",
            va="center",
            color=text_colour(COLOURS["orange"]),
            fontsize=8,
        )
    return figure


def laboratory_schematic(path: FloatArray, sides: tuple[DrawnSide, DrawnSide]) -> Figure:
    """Draw Fig. 6: both robots from above, with arms, agents, target (its path in m) and virtual spring."""
    with figure_style():
        figure, axes = _schematic_canvas(10.0, 6.1)
        axes.text(0.15, 5.85, r"$\mathbf{(a)}$ what each arm follows", va="center")
        axes.text(0.15, 3.72, r"$\mathbf{(b)}$ the robots from above", va="center")
        for centre, side, colour in ((2.5, sides[0], _FIRST), (7.5, sides[1], _SECOND)):
            drawn, half = _scale_laboratory_path(path, (centre, 4.75))
            axes.plot(*drawn.T, color=GREY, linewidth=0.7, linestyle=(0, (3, 1.6)))
            # Where the figure of eight is well away from its crossing.
            x, y = drawn[round(0.0875 * (len(drawn) - 1))].tolist()
            if side.spots:
                _draw_target_spots(axes, (x, y), side.spots, colour)
                words, beside = rf"$\mathbf{{p}}^*_i(t),\ i=1\ldots {side.spots}$", 0.62
            else:
                axes.plot(x, y, "o", color=colour, markersize=6)
                words, beside = r"$\mathbf{p}^*(t)$", 0.16
            axes.text(max(x + beside, centre + half + 0.1), y, words, va="center", fontsize=8.5)
            axes.text(
                centre - half - 0.25,
                4.75,
                side.agent,
                ha="right",
                va="center",
                color=text_colour(colour),
                parse_math=False,
            )
        handles = {}
        for centre, number, colour in ((2.1, 1, _FIRST), (7.9, 2, _SECOND)):
            handles[number] = _draw_planar_robot(axes, centre, number, colour, sides[number - 1])
        first, second = handles[1], handles[2]
        y = first[1]
        _draw_spring_zigzag(axes, first, (4.3, y), turns=5)
        _draw_spring_zigzag(axes, (5.7, y), second, turns=5)
        _draw_block(
            axes, (5.0, y), 1.4, 0.78, "network\n$e^{-\\delta s}$ each way", COLOURS["orange"], size=6.5
        )
        axes.text(3.7, y + 0.25, r"$\mathbf{k}$", ha="center", color=text_colour(_SPRING), fontsize=9)
        axes.text(6.3, y + 0.25, r"$\mathbf{k}$", ha="center", color=text_colour(_SPRING), fontsize=9)
        _draw_schematic_arrow(axes, (3.35, y - 0.52), (4.65, y - 0.52), _FIRST)
        axes.text(4.0, y - 0.74, r"$\mathbf{p}_1(t)$", ha="center", color=text_colour(_FIRST), fontsize=7.5)
        _draw_schematic_arrow(axes, (5.35, y - 0.52), (6.65, y - 0.52), _FIRST)
        axes.text(
            6.0, y - 0.74, r"$\mathbf{p}_1(t-\delta)$", ha="center", color=text_colour(_FIRST), fontsize=7.5
        )
        _draw_schematic_arrow(axes, (6.65, y - 1.0), (5.35, y - 1.0), _SECOND)
        axes.text(6.0, y - 1.24, r"$\mathbf{p}_2(t)$", ha="center", color=text_colour(_SECOND), fontsize=7.5)
        _draw_schematic_arrow(axes, (4.65, y - 1.0), (3.35, y - 1.0), _SECOND)
        axes.text(
            4.0, y - 1.24, r"$\mathbf{p}_2(t-\delta)$", ha="center", color=text_colour(_SECOND), fontsize=7.5
        )
        origin = (4.72, 0.35)
        _draw_schematic_arrow(axes, origin, (5.25, 0.35), _INK)
        _draw_schematic_arrow(axes, origin, (4.72, 0.88), _INK)
        axes.text(5.33, 0.35, "x", va="center")
        axes.text(4.72, 0.97, "y", ha="center")
    return figure


def _schematic_canvas(width: float, height: float) -> tuple[Figure, Axes]:
    """Return empty axes that span the given width and height in units of length."""
    figure = Figure(figsize=(FULL_WIDTH, FULL_WIDTH * height / width))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, width), ylim=(0.0, height))
    axes.set_axis_off()
    return figure, axes


def _draw_schematic_arrow(axes: Axes, start: _Point, end: _Point, colour: str = _INK) -> None:
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={
            "arrowstyle": "-|>",
            "color": colour,
            "lw": 0.9,
            "mutation_scale": 8.0,
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
    )


def _draw_block(
    axes: Axes, centre: _Point, width: float, height: float, text: str, colour: str, size: float = 9
) -> None:
    axes.add_patch(
        Rectangle(
            (centre[0] - width / 2, centre[1] - height / 2),
            width,
            height,
            facecolor=_FILL,
            edgecolor=colour,
            linewidth=1.2,
            zorder=3,
        )
    )
    axes.text(*centre, text, ha="center", va="center", fontsize=size, zorder=4)


def _draw_summing_point(axes: Axes, centre: _Point) -> None:
    axes.add_patch(Circle(centre, 0.18, facecolor="white", edgecolor=_INK, linewidth=0.9, zorder=3))
    axes.text(*centre, "Σ", ha="center", va="center", fontsize=7, zorder=4)


def _draw_spring_zigzag(axes: Axes, start: _Point, end: _Point, turns: int) -> None:
    """Draw a zigzag with a straight piece at both ends."""
    along = np.concatenate([[0.0], np.linspace(0.15, 0.85, 4 * turns + 1), [1.0]])
    across = np.concatenate([[0.0], 0.13 * np.sin(np.pi / 2 * np.arange(4 * turns + 1)), [0.0]])
    one, other = np.array(start), np.array(end)
    forward = (other - one) / np.hypot(*(other - one))
    side = np.array([-forward[1], forward[0]])
    points = one + along[:, None] * (other - one) + across[:, None] * side
    axes.plot(*points.T, color=_SPRING, linewidth=1.1, solid_joinstyle="round")


def _draw_damper_cylinder(axes: Axes, wall: _Point, mass: _Point) -> None:
    """Draw a cylinder on the wall and a piston on the mass."""
    sense = 1.0 if mass[0] > wall[0] else -1.0
    middle, y = (wall[0] + mass[0]) / 2, wall[1]
    axes.plot([wall[0], middle - 0.25 * sense], [y, y], color=_INK, linewidth=0.9)
    axes.plot(
        [middle + 0.25 * sense, middle - 0.25 * sense, middle - 0.25 * sense, middle + 0.25 * sense],
        [y + 0.2, y + 0.2, y - 0.2, y - 0.2],
        color=_INK,
        linewidth=0.9,
    )
    axes.plot([middle + 0.05 * sense] * 2, [y - 0.15, y + 0.15], color=_INK, linewidth=1.6)
    axes.plot([middle + 0.05 * sense, mass[0]], [y, y], color=_INK, linewidth=0.9)


def _scale_laboratory_path(path: FloatArray, centre: _Point) -> tuple[FloatArray, float]:
    """Scale a path into its place, and return half its width there too."""
    low, high = path.min(axis=0), path.max(axis=0)
    scale = 0.8 / max(float((high - low).max()) / 2.0, 1e-9)
    return np.asarray(centre) + scale * (path - (low + high) / 2.0), scale * float(high[0] - low[0]) / 2.0


def _draw_target_spots(axes: Axes, centre: _Point, count: int, colour: str) -> None:
    """Draw spots around the target, each with its own velocity, the same in every study."""
    random = np.random.default_rng(4)
    # More would be one blot.
    shown = min(count, 40)
    offsets = 0.17 * random.standard_normal((shown, 2))
    velocities = 0.2 * random.standard_normal((shown, 2))
    axes.plot(*centre, "+", color=_INK, markersize=6, markeredgewidth=0.9)
    for offset, velocity in zip(offsets, velocities, strict=True):
        spot = (centre[0] + offset[0], centre[1] + offset[1])
        for radius, alpha in ((0.13, 0.12), (0.09, 0.18), (0.05, 0.55)):
            axes.add_patch(Circle(spot, radius, facecolor=colour, edgecolor="none", alpha=alpha))
        axes.plot(
            [spot[0], spot[0] + velocity[0]], [spot[1], spot[1] + velocity[1]], color=colour, linewidth=0.6
        )


def _draw_planar_robot(axes: Axes, centre: float, number: int, colour: str, side: DrawnSide) -> _Point:
    """Draw an H-shaped planar robot from above, and return the place of its handle."""
    low, high, half = 1.15, 3.35, 1.15
    handle = (centre + (0.35 if number == 1 else -0.35), 2.35)
    for x in (centre - half, centre + half):
        axes.add_patch(
            Rectangle((x - 0.06, low), 0.12, high - low, facecolor="#DADADA", edgecolor=GREY, linewidth=0.6)
        )
    axes.add_patch(
        Rectangle(
            (centre - half, handle[1] - 0.07),
            2 * half,
            0.14,
            facecolor="#E9E9E9",
            edgecolor=GREY,
            linewidth=0.6,
        )
    )
    name = side.robot if len(side.robot) <= _LETTERS else f"{side.robot[: _LETTERS - 1]}…"
    axes.text(
        centre - half + 0.15, high - 0.12, name, color=text_colour(colour), va="center", parse_math=False
    )
    words = (centre + 0.05, 0.18) if number == 1 else (centre - 0.05, 0.18)
    axes.text(
        *words, side.arm, ha="left" if number == 1 else "right", va="center", fontsize=7, parse_math=False
    )
    axes.add_patch(Circle(handle, 0.13, facecolor=colour, edgecolor="white", linewidth=0.8, zorder=6))
    axes.text(
        handle[0],
        handle[1] + 0.24,
        rf"$\mathbf{{p}}_{number}$",
        ha="center",
        color=text_colour(colour),
        fontsize=9,
    )
    if side.links in ("drawn", "dashed"):
        _draw_two_links(axes, centre, number, colour, handle, side)
    else:
        _draw_agent_force(axes, number, colour, handle, block=side.links == "block")
    return handle


def _draw_agent_force(axes: Axes, number: int, colour: str, handle: _Point, *, block: bool) -> None:
    """Draw the agent's force on the handle, through a block of the arm's mass where it has one."""
    start = (handle[0] - (0.9 if number == 1 else -0.9), handle[1] - 1.55)
    towards = np.array(handle) - np.array(start)
    forward = towards / np.hypot(*towards)
    near = np.array(handle) - 0.14 * forward
    middle = np.array(start) + 0.5 * towards
    label = np.array(start) + 0.2 * towards
    if block:
        axes.plot(*np.array([middle, near]).T, color=colour, linewidth=2.0, zorder=4)
        _draw_block(axes, (float(middle[0]), float(middle[1])), 0.72, 0.36, "arm", colour, size=7)
        _draw_schematic_arrow(axes, start, tuple((middle - 0.21 / forward[1] * forward).tolist()), _FORCE)
    else:
        _draw_schematic_arrow(axes, start, tuple(near.tolist()), _FORCE)
    axes.text(
        float(label[0]) + (-0.12 if number == 1 else 0.12),
        float(label[1]) + 0.05,
        rf"$\mathbf{{F}}_{number}$",
        ha="right" if number == 1 else "left",
        color=_FORCE,
        fontsize=8.5,
    )


def _draw_two_links(
    axes: Axes, centre: float, number: int, colour: str, handle: _Point, side: DrawnSide
) -> None:
    """Draw a two-link arm with its shoulder on the ground and its end in the handle."""
    simulated = side.links == "drawn"
    shoulder = np.array([centre + (-0.75 if number == 1 else 0.75), 0.35])
    upper, lower = 1.2, 1.25
    to_handle = np.array(handle) - shoulder
    distance = float(np.hypot(*to_handle))
    bend = float(np.arccos((upper**2 + distance**2 - lower**2) / (2 * upper * distance)))
    turned = 1.0 if side.elbow == "left" else -1.0
    angle = float(np.arctan2(to_handle[1], to_handle[0])) + turned * bend
    elbow = shoulder + upper * np.array([np.cos(angle), np.sin(angle)])
    for start, end in ((shoulder, elbow), (elbow, np.array(handle))):
        axes.plot(
            *np.array([start, end]).T,
            color=colour,
            linewidth=4.0 if simulated else 1.2,
            linestyle="-" if simulated else (0, (4, 2)),
            alpha=0.45 if simulated else 1.0,
            zorder=4,
        )
    axes.add_patch(
        Polygon(
            shoulder + np.array([[-0.25, -0.22], [0.25, -0.22], [0.0, 0.0]]),
            facecolor="#DADADA",
            edgecolor=GREY,
            linewidth=0.6,
        )
    )
    for joint in (shoulder, elbow):
        axes.add_patch(
            Circle(tuple(joint), 0.09, facecolor="white", edgecolor=colour, linewidth=1.1, zorder=5)
        )
    odd = 2 * number - 1
    degrees = float(np.degrees(angle))
    axes.plot([shoulder[0], shoulder[0] + 0.55], [shoulder[1]] * 2, color=GREY, linewidth=0.6)
    axes.add_patch(Arc(tuple(shoulder), 0.8, 0.8, theta1=0.0, theta2=degrees, color=_INK, linewidth=0.7))
    half_way = np.radians(degrees / 2.0)
    x, y = shoulder + 0.6 * np.array([np.cos(half_way), np.sin(half_way)])
    axes.text(float(x), float(y), rf"$\theta_{odd}$", ha="center", va="center", fontsize=8)
    forearm = float(np.degrees(np.arctan2(*(np.array(handle) - elbow)[::-1])))
    beyond = elbow + 0.5 * np.array([np.cos(angle), np.sin(angle)])
    axes.plot([elbow[0], beyond[0]], [elbow[1], beyond[1]], color=GREY, linewidth=0.6)
    low_angle, high_angle = sorted((forearm, degrees))
    axes.add_patch(
        Arc(tuple(elbow), 0.7, 0.7, theta1=low_angle, theta2=high_angle, color=_INK, linewidth=0.7)
    )
    middle = np.radians((low_angle + high_angle) / 2)
    axes.text(
        elbow[0] + 0.52 * np.cos(middle),
        elbow[1] + 0.52 * np.sin(middle),
        rf"$\theta_{odd + 1}$",
        ha="center",
        va="center",
        fontsize=8,
    )
    # Each name on the side of its link where no angle is drawn.
    upper_side = -1.0 if number == 1 else -turned
    for start, end, name, sign in (
        (shoulder, elbow, "l_1", upper_side),
        (elbow, np.array(handle), "l_2", turned),
    ):
        centre_of = (start + end) / 2
        direction = (end - start) / np.hypot(*(end - start))
        x, y = centre_of + 0.2 * sign * np.array([direction[1], -direction[0]])
        axes.text(float(x), float(y), f"${name}$", ha="center", va="center", fontsize=8)
