"""Figs. 9 and 10 and the residuals: they show what was computed, and the same each time."""

from __future__ import annotations

import numpy as np
import pytest

from telespring.identification import Identification, identify, paper_excitation
from telespring.show.drawings.identification import draw_excitation, draw_regression, draw_residuals
from telespring.show.figures import to_svg


@pytest.fixture(scope="module")
def found() -> Identification:
    time = np.arange(12000) / 1000.0
    command = paper_excitation()
    random = np.random.default_rng(1)
    force = 0.8 * command.acceleration(time) + 7.0 * command.velocity(time)
    force[4000:4200] += 8.0
    return identify(time, command.position(time), force + random.normal(0.0, 0.1, time.size))


def test_law_fig_9_shows_the_movement_in_its_units() -> None:
    command = paper_excitation()
    drawn = draw_excitation([("the paper's", command)])
    velocity, position, acceleration = drawn.axes
    for axes, quantity, scale in (
        (velocity, command.velocity, 1.0),
        (position, command.position, 1e3),
        (acceleration, command.acceleration, 1.0),
    ):
        time, values = (np.asarray(each, dtype=float) for each in axes.lines[1].get_data())
        np.testing.assert_allclose(values, scale * quantity(time))
    assert "mm" in position.get_ylabel()


def test_law_fig_10_has_force_and_plane_for_every_robot_and_axis(found: Identification) -> None:
    drawn = draw_regression([("one", found), ("other", found)])
    assert len(drawn.axes) == 4
    measured, estimated = (np.asarray(line.get_ydata()) for line in drawn.axes[0].lines)
    np.testing.assert_array_equal(measured, found.axes[0].measured_force)
    np.testing.assert_array_equal(estimated, found.axes[0].estimated_force)
    assert "kg" in drawn.axes[1].get_title()


def test_law_residuals_that_were_left_out_are_marked(found: Identification) -> None:
    drawn = draw_residuals(found)
    legend = drawn.axes[0].get_legend()
    assert legend is not None
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == ["used", "rejected"]


def test_law_the_same_figure_gives_the_same_text(found: Identification) -> None:
    first, second = (to_svg(draw_residuals(found), "residuals", "Residuals", "…") for _ in range(2))
    assert first == second
