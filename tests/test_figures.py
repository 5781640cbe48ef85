"""Figures: what is drawn is what was given, the text is whole, and the same figure gives the same text."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import telespring as ts
from made_comparison import LABELS, made_account_trial, made_comparison
from telespring.show import figures
from telespring.show.drawings.comparison import draw_account, draw_delays, draw_plane


def nyquist() -> Figure:
    angle = np.linspace(0.0, 6.0, 200)
    locus = -np.exp(-1j * angle) * np.exp(-0.3 * angle)
    panel = figures.NyquistPanel("k = K, δ = Δ", locus, "stable", "stable")
    return figures.nyquist_figure([[panel, panel], [panel, panel]])


def frequency() -> Figure:
    grid = np.geomspace(0.5, 60.0, 50)
    curves = [figures.FrequencyCurve(f"{i}K", i / (1 + grid**2), -grid, (1.0, -90.0)) for i in (1, 2, 3, 4)]
    return figures.frequency_figure(grid, [figures.FrequencyFamily("stiffness k", curves)] * 4)


def responses() -> Figure:
    time = np.linspace(0.0, 4.0, 100)
    position = np.sin(time)[:, None, None] * np.array([[1.0, 0.5], [-1.0, -0.5]])
    panel = figures.ResponsePanel("a", "k = K, δ = Δ", time, position, ["stable", "unstable"])
    return figures.response_figure(["x", "y"], [[panel] * 3] * 2)


def tiers() -> Figure:
    stiffness = np.linspace(1.0, 100.0, 120)
    exact = np.where(stiffness > 30.0, 5.0 / stiffness, np.inf)
    axes = [figures.MapAxis(name, stiffness, exact, exact) for name in ("x", "y")]
    return figures.tier_map(
        axes,
        any_network=15.0,
        any_constant=30.0,
        bounded=(stiffness, 3.0 / stiffness),
        conditions=[(18.0, 0.084)],
        extent=(100.0, 0.4),
    )


def regions() -> Figure:
    columns = [figures.MapColumn(float(k), [(0.0, 1.0 / k), (1.5 / k, 2.0 / k)]) for k in range(1, 30)]
    printed = np.where(np.arange(1, 30) > 10, 1.2 / np.arange(1, 30), np.inf)
    panels = [("left", columns, printed), ("right", columns, printed)]
    return figures.region_map(panels, longest=[1.0, 2.0], marks=[(5.0, 0.1), None])


def trajectories() -> Figure:
    time = np.linspace(0.0, 12.0, 1500)
    target = np.stack([0.05 * np.sin(2.0 * time), 0.1 * np.sin(time)], axis=-1)
    position = np.stack([target, 0.9 * target], axis=1)[None] * np.linspace(0.9, 1.05, 8)[:, None, None, None]
    panel = figures.TrialPanel("36 N/m, 84 ms", position, target)
    away = position * np.exp(time / 4.0)[:, None, None]
    away[0, 900:] = np.nan
    leaving = figures.TrialPanel("142 N/m, 334 ms", away, target, "1 ended early")
    return figures.trajectory_figure(panel, [[panel] * 4, [panel, None, panel, leaving]])


def errors() -> Figure:
    rng = np.random.default_rng(1)
    groups = [
        figures.ErrorGroup(
            "UM" if i == 0 else "84",
            "" if i == 0 else f"{36 if i < 3 else 71} N/m",
            (0.03 + 0.001 * rng.normal(size=20), 0.04 + 0.002 * rng.normal(size=20)),
            ("↓", "" if i < 3 else "↑"),
            2 if i == 4 else 0,
        )
        for i in range(5)
    ]
    groups.append(
        figures.ErrorGroup("334", "71 N/m", (np.full(20, np.nan), np.full(20, np.nan)), ("", ""), 20)
    )
    return figures.error_figure(groups, 0.04)


def laboratory() -> Figure:
    phase = np.linspace(0.0, 2.0 * np.pi, 200)
    return figures.laboratory_schematic(
        np.column_stack([0.08 * np.sin(2.0 * phase), 0.12 * np.sin(phase)]),
        (
            figures.DrawnSide("light", "skilled", 0, "two-link arm", "drawn", "right"),
            figures.DrawnSide("heavy", "less skilled:\n5 spots", 5, "two-link arm", "drawn", "left"),
        ),
    )


def papers_laboratory() -> Figure:
    phase = np.linspace(0.0, 2.0 * np.pi, 200)
    return figures.laboratory_schematic(
        np.column_stack([0.05 * np.sin(2.0 * phase), 0.1 * np.sin(phase)]),
        (
            figures.DrawnSide("H-MAN 1", "skilled", 0, "two-link arm,\nhere massless", "dashed", "left"),
            figures.DrawnSide(
                "H-MAN 2", "less skilled", 10, "two-link arm,\nhere massless", "dashed", "right"
            ),
        ),
    )


def laboratory_of_circles() -> Figure:
    phase = np.linspace(0.0, 8.0 * np.pi, 500)
    return figures.laboratory_schematic(
        0.08 * np.column_stack([np.cos(phase), np.sin(phase)]),
        (
            figures.DrawnSide(
                "a robot of many letters, $ of them odd", "program\nTremor", 0, "massless arm", "none"
            ),
            figures.DrawnSide("robot 2", "less skilled:\n80 spots", 80, "arm: a mass and a damper", "block"),
        ),
    )


def delays() -> Figure:
    return draw_delays(made_comparison(), unconnected=(0.0219, 0.0241))


def delays_of_networks() -> Figure:
    comparison = made_comparison(LABELS[:3], (142.5,), (0.0, 0.084, 0.334), networks=("5G", "fixed line"))
    return draw_delays(comparison)


def plane() -> Figure:
    held = ts.Dyad(*ts.hman().robots, (ts.Operator(stiffness=120.0), ts.Operator(stiffness=120.0)))
    return draw_plane(made_comparison(), dyad=ts.hman(), held=held)


def plane_of_three() -> Figure:
    return draw_plane(made_comparison(), ("spring", "guard", "guard + shared-target"))


def account() -> Figure:
    return draw_account(made_account_trial(), without_guard=made_account_trial(3.0))


def account_alone() -> Figure:
    return draw_account(made_comparison().sel(architecture="guard", network="study", condition="CM-142-84"))


DRAWINGS = {
    "nyquist": nyquist,
    "frequency": frequency,
    "responses": responses,
    "tiers": tiers,
    "regions": regions,
    "dyad": figures.dyad_schematic,
    "loop": figures.loop_schematic,
    "laboratory": laboratory,
    "laboratory of the paper": papers_laboratory,
    "laboratory of circles": laboratory_of_circles,
    "trajectories": trajectories,
    "errors": errors,
    "delays": delays,
    "delays of networks": delays_of_networks,
    "plane": plane,
    "plane of three": plane_of_three,
    "account": account,
    "account alone": account_alone,
}
SCHEMATICS = ("dyad", "loop", "laboratory", "laboratory of the paper", "laboratory of circles")


@pytest.fixture(params=DRAWINGS, scope="module")
def drawing(request: pytest.FixtureRequest) -> tuple[str, Figure]:
    return request.param, DRAWINGS[request.param]()


def test_law_nothing_is_cut_off(drawing: tuple[str, Figure]) -> None:
    _, figure = drawing
    with figures.style.figure_style():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib gives it no types
        box = figure.get_tightbbox(canvas.get_renderer())  # type: ignore[no-untyped-call]
    width, height = figure.get_size_inches()
    # a hundredth of an inch: half of a line's width may stand over the edge
    assert box.x0 > -0.01
    assert box.y0 > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01


def test_law_every_outer_axis_has_a_label_with_a_unit(drawing: tuple[str, Figure]) -> None:
    name, figure = drawing
    if name in SCHEMATICS:
        assert not any(axes.axison for axes in figure.axes)
        return
    labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
    labels += [figure.get_supxlabel(), figure.get_supylabel()]
    used = [label for label in labels if label]
    assert len(used) >= 2
    assert all(re.search(r", (1|m/m|mm|mJ|ms|s|N|N/m|rad/s|degree)$", label) for label in used)


def test_law_svg_is_well_formed_alone_and_names_itself(drawing: tuple[str, Figure]) -> None:
    name, figure = drawing
    text = figures.to_svg(figure, name, "A title & more", "What is to be seen.")
    root = ET.fromstring(text)
    assert root.tag == "svg"
    assert root.get("role") == "img"
    assert [child.text for child in list(root)[:2]] == ["A title & more", "What is to be seen."]
    assert "http" not in text
    identifiers = re.findall(r'\bid="([^"]+)"', text)
    assert identifiers
    assert all(each.startswith(f"{name}-") for each in identifiers)
    targets = set(re.findall(r'href="#([^"]+)"', text)) | set(re.findall(r"url\(#([^)]+)\)", text))
    assert targets <= set(identifiers)


def test_law_same_figure_same_text(drawing: tuple[str, Figure]) -> None:
    name, _ = drawing
    one, other = (figures.to_svg(DRAWINGS[name](), name, "t", "d") for _ in range(2))
    assert one == other


@pytest.mark.parametrize("name", SCHEMATICS)
def test_law_no_two_words_of_a_schematic_overlap(name: str) -> None:
    figure = DRAWINGS[name]()
    with figures.style.figure_style():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib gives it no types
        renderer = canvas.get_renderer()  # type: ignore[no-untyped-call]
    words = [text for axes in figure.axes for text in axes.texts if text.get_text()]
    assert len(words) > 8
    # half a pixel: boxes of letters that touch
    boxes = [(text.get_text(), text.get_window_extent(renderer).padded(-0.5)) for text in words]
    for i, (one, box) in enumerate(boxes):
        for other, another in boxes[i + 1 :]:
            assert not box.overlaps(another), f"{one!r} and {other!r}"


def test_law_trajectories_are_all_drawn_and_stay_small() -> None:
    """17 conditions of 20 trials: every trial is a line, and the page can hold them."""
    rng = np.random.default_rng(2)
    time = np.linspace(0.0, 24.0, 2400)
    target = np.stack([0.05 * np.sin(5.18 * time), 0.1 * np.sin(2.59 * time)], axis=-1)
    lags = rng.uniform(0.1, 0.2, (20, 2))
    path = np.stack(
        [
            np.stack([0.05 * np.sin(5.18 * (time - lag)), 0.1 * np.sin(2.59 * (time - lag))], axis=-1)
            for lag in lags.T.reshape(-1)
        ]
    ).reshape(2, 20, len(time), 2)
    drift = 0.3 * np.cumsum(rng.normal(0.0, 5e-4, path.shape), axis=2)
    panel = figures.TrialPanel("36 N/m, 84 ms", np.moveaxis(path + drift, 0, 2), target)
    figure = figures.trajectory_figure(panel, [[panel] * 4] * 4)
    assert len(figure.axes) == 34
    assert all(len(axes.collections[0].get_paths()) == 20 for axes in figure.axes)
    assert len(figures.to_svg(figure, "trajectories", "t", "d")) < 1.5e6


def eight(trials: int, scale: float = 1.0, lag: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """Make paths (trial, time, robot, axis) that follow a figure eight, and the target (time, axis)."""
    time = np.linspace(0.0, 24.0, 2400)

    def path(delay: float) -> np.ndarray:
        return np.stack([0.05 * np.sin(5.18 * (time - delay)), 0.1 * np.sin(2.59 * (time - delay))], axis=-1)

    lags = lag * (1.0 + 0.1 * np.arange(trials))
    return scale * np.stack([np.stack([path(each)] * 2, axis=1) for each in lags]), path(0.0)


def test_law_completed_trials_are_shown_whole() -> None:
    """Robots that move more than the target, and a condition that moves far more."""
    calm, target = eight(3)
    wide, far = eight(3, 2.0)[0], eight(3, 6.3)[0]
    panels = [
        figures.TrialPanel(name, paths, target) for name, paths in (("a", calm), ("b", wide), ("c", far))
    ]
    figure = figures.trajectory_figure(None, [panels])
    for axes, paths in zip(figure.axes, np.repeat(np.stack([calm, wide, far]), 2, axis=0), strict=True):
        limit = np.array([axes.get_xlim()[1], axes.get_ylim()[1]])
        assert np.all(1e3 * np.abs(paths).max(axis=(0, 1, 2)) <= limit)
    widths = [axes.get_xlim()[1] for axes in figure.axes]
    assert widths[0] == widths[2]
    words = [text.get_text() for axes in figure.axes for text in axes.texts]
    # 6.3 times the target, in a view that fits 2 times: 3.15 times, so the next one
    assert words == ["view 4× wider"] * 2
    assert widths[4] == pytest.approx(4.0 * widths[0])


def test_law_a_trial_that_runs_away_leaves_its_panel_and_shrinks_no_other() -> None:
    calm, target = eight(4)
    away = calm.copy()
    away[3] *= np.exp(np.linspace(0.0, 6.0, 2400))[:, None, None]
    alone = figures.trajectory_figure(None, [[figures.TrialPanel("a", calm, target)]])
    early = np.array([False, False, False, True])
    figure = figures.trajectory_figure(
        None, [[figures.TrialPanel("a", away, target, "1 ended early", early)]]
    )
    # the trial that runs away is the one that lags most, by the fourth digit of its largest position
    assert figure.axes[0].get_xlim() == pytest.approx(alone.axes[0].get_xlim(), abs=1e-3)
    words = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert words == ["leaves the panel", "1 ended early", "leaves the panel"]


def test_law_where_trials_hide_each_other_one_is_shown() -> None:
    calm, target = eight(20)
    noise = np.random.default_rng(1).uniform(-0.05, 0.05, (20, 2400, 2, 2))
    panels = [figures.TrialPanel("a", calm, target), figures.TrialPanel("b", calm + noise, target)]
    figure = figures.trajectory_figure(None, [panels])
    assert [len(axes.collections[0].get_paths()) for axes in figure.axes] == [20, 20, 1, 1]
    assert [text.get_text() for axes in figure.axes[2:] for text in axes.texts] == ["1 of 20 trials"] * 2


def test_law_far_conditions_leave_the_others_legible() -> None:
    rng = np.random.default_rng(1)

    def group(level: float, published: bool = True) -> figures.ErrorGroup:
        errors = level * (1.0 + 0.02 * rng.normal(size=(2, 20)))
        pair = ((level, 0.001), (1.1 * level, 0.001)) if published else None
        return figures.ErrorGroup(f"{level}", "36 N/m", (errors[0], errors[1]), ("↑", "↓"), 0, pair)

    near = [group(0.030 + 0.001 * i) for i in range(6)]
    assert len(figures.error_figure(near, 0.03).axes) == 1
    figure = figures.error_figure(
        [*near, group(0.4, published=False), group(0.2, published=False)], 0.03, "UM", 0.035
    )
    upper, lower = figure.axes
    assert (upper.get_yscale(), lower.get_yscale()) == ("log", "linear")
    # one scale goes on where the other ends, and both together show every error
    assert upper.get_ylim()[0] == lower.get_ylim()[1]
    low, high = lower.get_ylim()
    for each in near:
        assert low < 1e3 * np.concatenate(each.errors).min() <= 1e3 * np.concatenate(each.errors).max() < high
        # a box of 0.6 mm is as high as a line is thick several times over
    assert (high - low) < 1e3 * 0.015
    assert upper.get_ylim()[1] > 430.0
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "published median TE2 in UM, 35.00 mm" in labels
    assert "published mean ± standard deviation" in labels
    arrows = [text.get_text() for axes in figure.axes for text in axes.texts if text.get_text() in ("↑", "↓")]
    assert len(arrows) == 16
