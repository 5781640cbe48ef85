"""The adaptive solver from Python: shapes, callbacks, errors; its accuracy is tested in Rust."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest

import telespring as ts


def test_ref_method_of_steps() -> None:
    # y' = -y(t-1), y = 1 for t <= 0: 1 - t, then 3/2 - 2 t + t²/2 on [1, 2] (integrated by hand)
    solution = ts.solve_dde(lambda _, __, delayed: -delayed[0], 1.0, [1.0], (0.0, 2.0), 1e-10, 1e-12)
    assert solution.completed
    assert (solution.start, solution.end) == (0.0, 2.0)
    late = np.array([[1.0, 1.25], [1.5, 2.0]])
    # 1e-9: ten times the tolerance asked for
    np.testing.assert_allclose(solution(late)[..., 0], 1.5 - 2 * late + late**2 / 2, atol=1e-9)
    assert solution(late).shape == (2, 2, 1)
    assert solution(0.5).shape == (1,)
    np.testing.assert_allclose(solution.derivative(0.5), [-1.0], atol=1e-6)
    assert solution.y.shape == (len(solution.t), 1)
    assert (1.0, 2) in solution.discontinuities


@pytest.mark.parametrize("delay", [0.5, lambda _: 0.5, lambda _, __: 0.5], ids=["constant", "time", "state"])
def test_law_a_constant_delay_is_the_same_however_it_is_given(delay: Any) -> None:
    def rhs(_: float, y: Any, delayed: Any) -> Any:
        return [y[1], -4.0 * delayed[0][0] - y[1]]

    solution = ts.solve_dde(rhs, [delay], [1.0, 0.0], (0.0, 3.0), 1e-9, 1e-11)
    reference = ts.solve_dde(rhs, [0.5], [1.0, 0.0], (0.0, 3.0), 1e-12, 1e-13)
    # a hundred times the tolerance: the equation amplifies
    np.testing.assert_allclose(solution(3.0), reference(3.0), atol=1e-7)


def test_law_what_a_callback_raises_comes_out_unchanged() -> None:
    class Mine(Exception):
        pass

    def raises(*_: Any) -> Any:
        raise Mine("seven")

    cases: list[tuple[Any, ...]] = [
        (raises, [1.0], [1.0]),
        (lambda _, y, __: y, [raises], [1.0]),
        (lambda _, y, __: y, [1.0], raises),
    ]
    for arguments in cases:
        with pytest.raises(Mine, match="seven"):
            ts.solve_dde(arguments[0], arguments[1], arguments[2], (0.0, 1.0))


def test_ref_how_it_ended_is_a_status() -> None:
    blown = ts.solve_dde(lambda _, y, __: y**2, [1.0], [1.0], (0.0, 2.0))  # 1/(1-t)
    assert blown.status in ("step too small", "not finite", "too many steps")
    # the pole is at 1; 1e-3: a thousand times the tolerance asked for
    assert abs(blown.end - 1.0) < 1e-3
    assert f"t = {blown.end}" in blown.message
    few = ts.solve_dde(lambda _, y, __: -y, [1.0], [1.0], (0.0, 100.0), max_steps=3)
    assert few.status == "too many steps"
    future = ts.solve_dde(lambda _, y, __: -y, [lambda t: 0.5 - t], [1.0], (0.0, 1.0))
    assert future.status == "invalid delay"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"delays": [-1.0]}, "delays[0]"),
        ({"delays": [1.0, lambda: 1.0]}, "delays[1]"),
        ({"t_span": (1.0, 0.0)}, "t_span"),
        ({"t_span": 0}, "t_span"),
        ({"t_span": (0.0, 1.0, 2.0)}, "t_span"),
        ({"t_span": (0.0, "end")}, "t_span[1]"),
        ({"t_span": (0.0, [1.0, 2.0])}, "t_span[1]"),
        ({"rtol": 1e-20}, "rtol"),
        ({"atol": [1e-9, 1e-9]}, "atol"),
        ({"rhs": lambda *_: [1.0, 2.0]}, "rhs(t, y, delayed)"),
        ({"initial": [1.0, 2.0]}, "initial"),
        ({"history": "still"}, "history"),
    ],
)
def test_ref_bad_arguments_are_refused_by_name(change: dict[str, Any], field: str) -> None:
    arguments: dict[str, Any] = {
        "rhs": lambda _, y, __: -y,
        "delays": [1.0],
        "history": [1.0],
        "t_span": (0.0, 1.0),
    }
    with pytest.raises(ts.InvalidInput) as refused:
        ts.solve_dde(**(arguments | change))
    assert refused.value.field == field


def test_law_times_outside_the_span_are_refused() -> None:
    solution = ts.solve_dde(lambda _, y, __: -y, [1.0], [1.0], (0.0, 1.0))
    with pytest.raises(ts.InvalidInput, match="known from 0 to 1") as refused:
        solution([0.5, 1.5])
    assert refused.value.field == "times[1]"


def test_law_other_threads_run_while_it_solves() -> None:
    seen: list[int] = []
    inside = threading.Event()

    def rhs(_: float, y: Any, __: Any) -> Any:
        inside.set()
        return -y

    def watch() -> None:
        inside.wait(10)
        seen.append(1)

    other = threading.Thread(target=watch)
    other.start()
    ts.solve_dde(rhs, [1.0], [1.0], (0.0, 1.0))
    other.join(10)
    assert seen == [1]
