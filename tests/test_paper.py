"""The paper's formulas and tables as they are printed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import telespring as ts
from printed_formulas import maximum_delay
from telespring.paper import as_printed
from telespring.paper.published import TABLE_II
from telespring.paper.scene import Scene
from telespring.paper.sections.number_sets.section import (
    find_number_sets,
    roots_of_identical_robots,
    table_2_set,
)


@pytest.fixture(scope="module")
def table() -> dict[str, Any]:
    found: dict[str, Any] = find_number_sets(Scene.of(ts.Study.paper())).numbers["table2"]
    return found


def test_ref_printed_delay_equals_the_exact_one_on_the_h_mans() -> None:
    """Eqs. 6 to 9 hold where the dampings are alike; to 1e-9 through the roots of the cubic."""
    for parameters, delay in (
        ((0.8334, 7.7257, 0.7776, 7.4208), 0.16718632424),
        ((1.0649, 10.1168, 1.3407, 9.3496), 0.23185110031),
    ):
        k = 2 * 35.615987936
        assert maximum_delay(*parameters, k)[0] == pytest.approx(delay, rel=1e-9)
        assert ts.maximum_delay(*parameters, k, method="paper") == pytest.approx(delay, rel=1e-9)


def test_cross_printed_formulas_in_the_core_against_companion_matrix_roots() -> None:
    """A few hundred dyads of the H-MANs' size, whose cubic may have one or three positive roots."""
    random = np.random.default_rng(20251122)
    compared = 0
    for _ in range(400):
        m1, m2 = np.exp(random.uniform(np.log(0.3), np.log(3.0), 2))
        b1, b2 = np.exp(random.uniform(np.log(2.0), np.log(20.0), 2))
        k = float(ts.critical_stiffness(m1, b1, m2, b2, method="paper")) * random.uniform(0.5, 4.0)
        expected, frequency = maximum_delay(m1, b1, m2, b2, k)
        found = ts.maximum_delay(m1, b1, m2, b2, k, method="paper")
        if math.isinf(expected):
            assert math.isinf(found)
            continue
        # near B = 0 the printed sign jumps, and rounding of the root decides
        if abs(as_printed.sign_of_equation_9(m1, b1, m2, b2, k, frequency)) < 1e-6 * frequency**2:
            continue
        compared += 1
        # 1e-7: the companion matrix' roots, worst where two of them are close
        assert found == pytest.approx(expected, rel=1e-7)
    assert compared > 250


def test_ref_table_ii_is_transcribed(du2025: dict[str, Any]) -> None:
    assert [tuple(row["sets"]) for row in du2025["table2"]["row"]] == list(TABLE_II)
    assert du2025["table2"]["columns"] == ["eta1", "eta2", "xi1", "xi2", "xi3"]


def test_cross_roots_of_identical_robots_against_the_companion_matrix() -> None:
    """Appendix A2's factors, with the prefactor corrected, against numpy's roots of Eq. 8."""
    mass, damping = 0.8334, 7.7257
    for stiffness in (5.0, 14.0, 20.0, 30.0, 50.0, 142.0):
        ours = np.sort_complex(np.array(roots_of_identical_robots(mass, damping, stiffness)))
        theirs = np.sort_complex(
            np.roots(as_printed.cubic_equation_8(mass, damping, mass, damping, stiffness))
        )
        # 1e-6: two roots are close at 14 N/m, where rounding grows by its square root
        assert ours == pytest.approx(theirs, rel=1e-6)


def test_cross_table_ii_against_numbers_read_from_the_companion_matrix(table: dict[str, Any]) -> None:
    """In each open range, the sets of the roots that numpy finds, as ours and as printed."""
    mass, damping = table["mass"], table["damping"]
    for at in (0, 2, 4):
        row = table["rows"][at]
        roots = np.roots(as_printed.cubic_equation_8(mass, damping, mass, damping, row["stiffness"]))
        size = damping**2 / mass**2
        real = sorted(("R+" if root.real > 0 else "R-") for root in roots if abs(root.imag) < 1e-6 * size)
        named = [row[f"xi{i}_set"] for i in (1, 2, 3)]
        assert sorted(each for each in named if each != "C") == real
        assert named.count("C") == 3 - len(real)
    for row in table["rows"]:
        assert {key: row[key] for key in row["printed"]} == row["printed"]


def test_ref_table_ii_changes_where_the_second_eta_vanishes(table: dict[str, Any]) -> None:
    """(√2 − 1) b²/(2m), 14.83 N/m for the base robot; between both numbers the table is wrong."""
    mass, damping = 0.8334, 7.7257
    assert table["sign_change"]["ours"] == pytest.approx(0.41421356237 * damping**2 / (2 * mass), rel=1e-10)
    assert table["sign_change"]["printed"] == pytest.approx(damping / (2 * mass), rel=1e-12)
    # the polynomial in k, b⁴ − 4m²k² − 4mb²k, has this one positive root
    polynomial = [-4 * mass**2, -4 * mass * damping**2, damping**4]
    assert max(np.roots(polynomial)) == pytest.approx(table["sign_change"]["ours"], rel=1e-12)
    assert table["between"]["eta2"] > 0
    assert table["between"]["xi2_set"] == "R-"
    assert table["rows"][2]["printed"]["xi2_set"] == "C"


@pytest.mark.parametrize(
    ("value", "name"),
    [
        (0.0, "0"),
        (1e-15, "0"),
        (-1e-15j, "0"),
        (0.5, "R+"),
        (-0.5, "R-"),
        (-0.5 + 1e-9j, "R-"),
        (1 + 1j, "C"),
    ],
)
def test_law_a_value_is_in_the_smallest_set_that_holds_it(value: complex, name: str) -> None:
    assert table_2_set(value, 1.0) == name
