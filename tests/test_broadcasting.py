"""How the criteria treat arrays; their values are tested elsewhere."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import telespring as ts

HMAN_X = (0.8334, 7.7257, 0.7776, 7.4208)


def test_law_scalars_give_a_float_and_arrays_an_array_of_their_common_shape() -> None:
    assert type(ts.critical_stiffness(*HMAN_X)) is float
    assert type(ts.critical_stiffness(np.float64(1), np.float64(4), np.float64(1), np.float64(4))) is float
    assert type(ts.maximum_delay(1, 4, 1, 4, 100)) is float
    m1 = np.array([[0.5], [1.0], [2.0]])
    b2 = np.array([4.0, 5.0, 6.0, 7.0])
    result = ts.critical_stiffness(m1, 4.0, 1.0, b2)
    assert isinstance(result, np.ndarray)
    assert result.shape == (3, 4)
    assert np.shape(ts.critical_stiffness([[1.0]], 4.0, 1.0, 4.0)) == (1, 1)
    assert np.shape(ts.critical_stiffness(np.empty((0, 3)), 4.0, 1.0, 4.0)) == (0, 3)
    assert type(ts.unstable_root_count(*HMAN_X, 71.2, 0.2)) is int
    assert ts.unstable_root_count(*HMAN_X, [71.2], 0.2).dtype == np.int64  # type: ignore[union-attr]


# 3: one thread; 5000: several
@pytest.mark.parametrize("count", [3, 5000])
def test_law_an_array_gives_what_its_elements_give(count: int) -> None:
    draw = np.random.default_rng(1)
    m1, m2 = draw.uniform(0.5, 2.0, (2, count))
    b1, b2 = draw.uniform(4.0, 15.0, (2, count))
    k = draw.uniform(10.0, 300.0, count)
    cases: list[tuple[Any, tuple[Any, ...]]] = [
        (ts.critical_stiffness, ()),
        (ts.maximum_delay, (k,)),
        (ts.maximum_stiffness, (k / 1000,)),
        (ts.minimum_damping, (k, 0.1)),
        (ts.unstable_root_count, (k, 0.3)),
    ]
    for function, more in cases:
        whole = function(m1, b1, m2, b2, *more)
        for i in range(0, count, max(1, count // 50)):
            one = (value[i] if isinstance(value, np.ndarray) else value for value in more)
            assert whole[i] == function(m1[i], b1[i], m2[i], b2[i], *one), (function.__name__, i)


def test_law_memory_order_and_type_of_the_array_do_not_matter() -> None:
    m1 = np.linspace(0.5, 2.0, 12).reshape(3, 4)
    expected = ts.critical_stiffness(m1, 4.0, 1.0, 5.0)
    for same in (np.asfortranarray(m1), np.repeat(m1, 2, axis=1)[:, ::2], m1.tolist()):
        np.testing.assert_array_equal(ts.critical_stiffness(same, 4.0, 1.0, 5.0), expected)
    np.testing.assert_array_equal(
        ts.critical_stiffness(np.array([1, 2], dtype=np.int32), 4.0, 1.0, 5.0),
        ts.critical_stiffness([1.0, 2.0], 4.0, 1.0, 5.0),
    )


@pytest.mark.parametrize(
    ("call", "field", "said"),
    [
        (lambda: ts.critical_stiffness(0.0, 1, 1, 1), "m1", "a mass must be a number"),
        (lambda: ts.critical_stiffness([1, 1], 1, [[1], [-2], [1]], 1), "m2[1, 0]", "-2"),
        (lambda: ts.critical_stiffness(np.ones((2, 3)), [1, np.nan, 1], 1, 1), "b1[1]", "NaN"),
        (lambda: ts.maximum_delay(1, 1, 1, 1, [5.0, 0.0]), "k[1]", "coupling stiffness"),
        (lambda: ts.maximum_stiffness(*HMAN_X, 167), "delay", "if 167 was meant in ms, write 0.167"),
        (lambda: ts.unstable_root_count(*HMAN_X, 10, [0.1, 167]), "delay[1]", "0.167"),
        (lambda: ts.stability_map(*HMAN_X, [10, 0], [0.1]), "k[1]", "coupling stiffness"),
        (lambda: ts.stability_map(*HMAN_X, [10], [0.1, -1]), "delay[1]", "a delay"),
        (lambda: ts.stability_map(*HMAN_X, [[10]], [0.1]), "k", "one-dimensional"),
        (lambda: ts.stability_map([1, 2], 1, 1, 1, [10], [0.1]), "m1", "one number"),  # type: ignore[call-overload]
        (lambda: ts.crossings(1, 1, 1, -1, 10), "b2", "a damping"),
        (lambda: ts.critical_stiffness("one", 1, 1, 1), "m1", "'one'"),
        (lambda: ts.critical_stiffness(1j, 1, 1, 1), "m1", "real number"),
        (lambda: ts.critical_stiffness([[1], [1, 2]], 1, 1, 1), "m1", "real number"),
        (lambda: ts.critical_stiffness([1, 2], 1, [1, 2, 3], 1), "m1, m2", "m1 (2,), m2 (3,)"),
        (lambda: ts.crossings([1, 2], 1, 1, 1, 10), "m1", "one number"),  # type: ignore[call-overload]
        (lambda: ts.critical_stiffness(1, 1, 1, 1, method="best"), "method", '"exact"'),  # type: ignore[call-overload]
    ],
)
def test_ref_the_refused_element_is_named(call: Any, field: str, said: str) -> None:
    with pytest.raises(ts.InvalidInput, match=re.escape(said)) as refused:
        call()
    assert refused.value.field == field


def test_law_the_first_refused_element_is_named_whatever_the_threads() -> None:
    m1 = np.ones(20_000)
    m1[[7_000, 9_000, 19_999]] = -1.0
    for _ in range(20):
        with pytest.raises(ts.InvalidInput) as refused:
            ts.critical_stiffness(m1, 4.0, 1.0, 4.0)
        assert refused.value.field == "m1[7000]"


def test_law_crossings_are_records() -> None:
    first = ts.crossings(*HMAN_X, 71.231976)[0]
    assert first == (first.delay, first.frequency, first.direction)
    assert isinstance(first.direction, int)


# the non-monotone example of DESIGN: stable again between 1.7738 and 2.1128 s
@pytest.mark.parametrize("axis", [HMAN_X, (0.97670822, 2.15372614, 0.30379312, 4.59594729)])
def test_cross_the_map_the_count_and_the_intervals_say_the_same(
    axis: tuple[float, float, float, float],
) -> None:
    k, delay = np.linspace(1.0, 80.0, 50), np.linspace(0.0, 2.5, 60)
    found = ts.stability_map(*axis, k, delay)
    assert found.shape == (50, 60)
    assert found.dtype == np.bool_
    np.testing.assert_array_equal(found, ts.unstable_root_count(*axis, k[:, None], delay) == 0)
    row = ts.stability_map(*axis, 9.174736188, delay)[0]
    stable = ts.stable_delays(*axis, 9.174736188, 3.0)
    np.testing.assert_array_equal(row, [any(start <= d < end for start, end in stable) for d in delay])
