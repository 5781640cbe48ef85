"""A masked value is missing wherever arrays enter: refused or left out, never taken for a number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import telespring as ts
from telespring import InvalidInput
from telespring._arrays import as_numbers
from telespring.analysis import compare, kruskal_wallis
from telespring.identification import Excitation, identify, paper_excitation

#: 999 stands for a sensor that failed.
MASKED = np.ma.array([1.0, 999.0, 2.0], mask=[False, True, False])
WHOLE = np.ma.array([1, 999, 2], mask=[False, True, False])
MATRIX = np.ma.array([[-3.0, 999.0], [0.0, -4.0]], mask=[[False, True], [False, False]])

REFUSED: dict[str, Callable[[], Any]] = {
    "criterion": lambda: ts.critical_stiffness(MASKED, 4.0, 1.0, 4.0),
    "whole numbers": lambda: ts.critical_stiffness(WHOLE, 4.0, 1.0, 4.0),
    "list of masked arrays": lambda: ts.critical_stiffness([MASKED, MASKED], 4.0, 1.0, 4.0),
    "missing in a series": lambda: ts.critical_stiffness(
        pd.Series([1.0, None, 2.0], dtype="Float64"), 4.0, 1.0, 4.0
    ),
    "missing in labelled data": lambda: ts.critical_stiffness(xr.DataArray(MASKED), 4.0, 1.0, 4.0),
    "stability map": lambda: ts.stability_map(ts.hman(), MASKED, [0.1]),
    "frequencies": lambda: ts.frequency_response(ts.hman(), 30.0, 0.1, MASKED),
    "a system's matrix": lambda: ts.DelaySystem(MATRIX, []),
    "a delay's matrix": lambda: ts.DelaySystem([[-1.0, 0.0], [0.0, -1.0]], [(0.1, MATRIX)]),
    "an excitation": lambda: Excitation(MASKED, MASKED),
}


@pytest.mark.parametrize("what", REFUSED)
def test_law_a_masked_value_is_refused(what: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        REFUSED[what]()
    assert "999" not in str(refused.value) or "--" in refused.value.value


def test_law_a_mask_that_hides_nothing_changes_nothing() -> None:
    values = np.array([1.0, 2.0, 3.0])
    expected = ts.critical_stiffness(values, 4.0, 1.0, 4.0)
    for same in (np.ma.array(values), np.ma.array(values, mask=[False] * 3), [np.ma.array(values)]):
        np.testing.assert_array_equal(
            np.ravel(ts.critical_stiffness(same, 4.0, 1.0, 4.0)),
            expected,
        )


def test_law_a_test_leaves_masked_values_out() -> None:
    """The same as without them, by plain selection."""
    random = np.random.default_rng(4)
    first, second = random.normal(0.0, 1.0, 30), random.normal(0.5, 1.0, 30)
    lost = np.arange(30) % 7 == 0
    masked = np.ma.array(np.where(lost, 999.0, first), mask=lost)
    assert compare(masked, second) == compare(first[~lost], second)
    groups = {"a": masked, "b": second}
    assert kruskal_wallis(groups) == kruskal_wallis({"a": first[~lost], "b": second})


def test_law_a_masked_point_of_the_complex_plane_is_refused() -> None:
    masked = np.ma.array([1j, 2j], mask=[False, True])
    with pytest.raises(InvalidInput, match=r"s\[1\] = NaN"):
        ts.transfer_matrix(ts.hman(), 30.0, 0.1, masked)


def test_law_a_masked_slope_ends_an_equation_at_once() -> None:
    slope = np.ma.array([1.0, 999.0], mask=[False, True])
    with pytest.warns(UserWarning, match="masked element"):
        solution = ts.solve_dde(lambda *_: slope, 0.1, [0.0, 0.0], (0.0, 1.0))
    assert solution.status != "completed"
    whole = ts.solve_dde(lambda *_: np.ma.array([1.0, 2.0]), 0.1, [0.0, 0.0], (0.0, 1.0))
    np.testing.assert_allclose(whole(1.0), [1.0, 2.0], rtol=1e-12)


def test_law_a_masked_history_ends_an_equation_at_once() -> None:
    solution = ts.solve_dde(lambda _, y, __: -y, 0.1, MASKED, (0.0, 1.0))
    assert solution.status != "completed"


def test_law_masked_samples_of_a_log_are_lost_samples() -> None:
    """The log with masked samples gives what the log without these rows gives."""
    time = np.arange(12_000) / 1000.0
    command, random = paper_excitation(), np.random.default_rng(6)
    position = command.position(time)
    force = (
        0.8 * command.acceleration(time) + 7.0 * command.velocity(time) + random.normal(0.0, 0.1, time.size)
    )
    lost = np.isin(np.arange(time.size), [500, 501, 4000, 9000])
    masked = np.ma.array(np.where(lost, 999.0, force), mask=lost)
    with_mask = identify(time, position, masked)
    without = identify(time[~lost], position[~lost], force[~lost])
    assert any("Lost samples: 4" in warning for warning in with_mask.warnings)
    assert with_mask.axes[0].mass.value == pytest.approx(without.axes[0].mass.value, rel=1e-12)
    assert np.isnan(as_numbers("force", masked)[lost]).all()
