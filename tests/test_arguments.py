"""Arguments of the wrong type, arrays with labels, and what frozen classes promise, over all public names."""

import copy
import inspect
import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import telespring as ts
from made_session import write_session

DYAD = ts.hman()
ROBOT = ts.Robot([1.0, 2.0], [3.0, 4.0])
WRONG: list[Any] = [
    "xy",
    None,
    object(),
    [1, "a"],
    {"a": 1},
    -1,
    2**80,
    True,
    float("nan"),
    1j,
    b"x",
    (1, 2, 3),
    [[1.0]],
    np.ones((2, 2)),
    ts.Operator(),
]
# a valid value for each name of a parameter
VALID: dict[str, Any] = {
    "a0": [[0.0]],
    "amplitude": 1.0,
    "angular_frequency": 1.0,
    "atol": 1e-9,
    "b1": 1.0,
    "b2": 1.0,
    "breakpoints": (),
    "computing_time": 0.0,
    "convention": "exact",
    "correlation": [0.0],
    "count": 4,
    "coupling_damping": 0.0,
    "damping": 1.0,
    "damping_sd": [1.0],
    "decay_rate": 0.5,
    "delay": 0.1,
    "delayed": (),
    "delays": [1.0],
    "duration": 1.0,
    "dyad": DYAD,
    "forces": [[0.0, 0.0], [0.0, 0.0]],
    "factors": (0.9, 1.1),
    "frequency": [1.0],
    "function": lambda t: t,
    "hold": "linear",
    "horizon": 1.0,
    "high": 10.0,
    "jitter": 0.0,
    "k": 20.0,
    "limit": 1000,
    "low": 0.1,
    "m1": 1.0,
    "m2": 1.0,
    "mass": 1.0,
    "mass_sd": [1.0],
    "max_gap": 0.0,
    "method": "exact",
    "name": "x",
    "network": ts.Network(0.1),
    "rate": 100.0,
    "resolution": 0.1,
    "rhs": lambda _t, y, _delayed: -y,
    "robot": 0,
    "robot1": ROBOT,
    "robot2": ROBOT,
    "rtol": 1e-6,
    "s": 1j,
    "stiffness": 30.0,
    "stiffnesses": (20.0, 30.0),
    "t_span": (0.0, 1.0),
    "values": [1.0, 2.0],
    "velocities": True,
}
OWN: dict[str, dict[str, Any]] = {
    "assess_trace": {"trace": ts.Trace([0.01 * n for n in range(1000)], [0.05] * 1000)},
    "OperatorRange": {"low": ts.Operator(), "high": ts.Operator(1.0)},
    "solve_dde": {"history": [1.0], "max_steps": 1000},
}


#: What reads a file may find none.
READERS = {"Study.read", "analyse_recording", "merge_recordings", "read_recording", "read_trace", "replay"}
OTHERS = {"Adversary", "Agent", "Arm", "Experiment", "Study", "Task", "Trajectory", "compare", "rehearse"} | {
    "merge_shards",
    "merge_surveys",
    "survey_dyads",
    "sweep",
    "unsafe_quantile",
}
METHODS = ["maximum_delay", "critical_stiffness", "stability_map", "is_stable", "crossings", "stable_delays"]


def callables() -> Iterator[tuple[str, Callable[..., Any]]]:
    for name in ts.__all__:
        public = getattr(ts, name)
        # what takes any keywords is tested with the study file; a named tuple checks nothing
        is_warning = inspect.isclass(public) and issubclass(public, Exception)
        if is_warning or not callable(public) or name in OTHERS:
            continue
        yield name, public
    yield "Study.from_toml", ts.Study.from_toml
    yield "Study.read", lambda path: ts.Study.read(path)
    for method in METHODS:
        yield f"DyadAxis.{method}", getattr(DYAD["x"], method)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of a live session."""
    return write_session(tmp_path_factory.mktemp("recordings"))[0]


@pytest.mark.parametrize(
    ("name", "public"), list(callables()), ids=lambda value: value if isinstance(value, str) else ""
)
@pytest.mark.filterwarnings("ignore")
def test_law_a_value_of_the_wrong_type_is_refused_by_name_with_a_remedy(
    name: str, public: Callable[..., Any], recording: Path
) -> None:
    parameters = inspect.signature(public).parameters
    required = [key for key, parameter in parameters.items() if parameter.default is parameter.empty]
    # the classes of results take any number of arguments that only other results have
    own = OWN.get(name, {})
    if name in {"analyse_recording", "replay"}:
        own = {next(iter(parameters)): recording}
    valid = {key: VALID.get(key) for key in {*required, *VALID} & parameters.keys()} | own
    for key in parameters:
        for wrong in WRONG:
            try:
                public(**(valid | {key: wrong}))
            except ts.InvalidInput as refused:
                says = refused.allowed or str(refused).startswith(f"Missing {refused.field}")
                if not (refused.field and says and refused.remedy.endswith(".")):
                    raise
            except FileNotFoundError:
                assert name in READERS


@pytest.mark.parametrize(
    ("call", "field", "remedy"),
    [
        (lambda: ts.Robot([1.0, 2.0], [3.0, 4.0], axes="xy"), "axes", "['x', 'y']"),
        (lambda: ts.Dyad(ROBOT, ROBOT, operators=ts.Operator()), "operators", "(operator, None)"),  # type: ignore[arg-type]
        (
            lambda: ts.verdicts(DYAD, 20.0, 0.1, operator_range=ts.Operator()),  # type: ignore[arg-type]
            "operator_range",
            "OperatorRange(low, high)",
        ),
        (
            lambda: ts.solve_dde(lambda _t, y, _d: -y, 1.0, [1.0], (0.0, 1.0), max_steps=-1),
            "max_steps",
            "int",
        ),
        (
            lambda: ts.solve_dde(lambda _t, y, _d: -y, 1.0, [[1.0, 2.0]], (0.0, 1.0)),
            "history",
            "numpy.ravel",
        ),
    ],
)
def test_ref_a_refusal_says_what_to_write(call: Callable[[], Any], field: str, remedy: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        call()
    assert refused.value.field == field
    assert remedy in refused.value.remedy


def test_law_a_number_of_a_robot_applies_to_every_axis() -> None:
    assert ts.Robot([1.0, 2.0], 3.0) == ts.Robot([1.0, 2.0], [3.0, 3.0])
    assert ts.Robot(1.0, [3.0, 4.0]) == ts.Robot([1.0, 1.0], [3.0, 4.0])


NUMBERS = (0.8334, 7.7257, 0.7776, 7.4208)


def test_law_labelled_arrays_broadcast_by_name() -> None:
    delay = xr.DataArray([0.05, 0.1, 0.2], dims="delay", coords={"delay": [50, 100, 200]})
    k = xr.DataArray([[20.0, 40.0, 80.0]], dims=("run", "delay"), coords={"delay": [50, 100, 200]}).T
    found: Any = ts.unstable_root_count(*NUMBERS, k=k, delay=delay)
    assert isinstance(found, xr.DataArray)
    assert set(found.dims) == {"delay", "run"}
    for place in (50, 100, 200):
        one = ts.unstable_root_count(
            *NUMBERS, float(k.sel(delay=place, run=0)), float(delay.sel(delay=place))
        )
        assert int(found.sel(delay=place, run=0)) == one
    # methods, a dyad, and a dimension that only one of the arguments has
    c = xr.DataArray([0.0, 1.0], dims="c")
    grid: Any = ts.maximum_stiffness(*NUMBERS, delay=delay, c=c)
    assert isinstance(grid, xr.DataArray)
    assert float(grid.sel(delay=100).isel(c=1)) == ts.maximum_stiffness(*NUMBERS, 0.1, c=1.0)
    axis: Any = DYAD["x"]
    by_axis = axis.maximum_stiffness(delay)
    assert by_axis.dims == ("delay",)
    np.testing.assert_array_equal(by_axis, DYAD["x"].maximum_stiffness(delay.values))


def test_law_labels_that_do_not_fit_are_refused() -> None:
    delay = xr.DataArray([0.05, 0.1], dims="delay", coords={"delay": [50, 100]})
    k = xr.DataArray([20.0, 40.0], dims="delay", coords={"delay": [100, 50]})
    with pytest.raises(ts.InvalidInput, match="labels must be equal"):
        ts.unstable_root_count(*NUMBERS, k, delay)
    with pytest.raises(ts.InvalidInput, match="without labels"):
        ts.unstable_root_count(*NUMBERS, np.array([20.0, 40.0]), delay)
    with pytest.raises(ts.InvalidInput, match="another for the delay"):
        ts.stability_map(DYAD, k, delay)


def test_law_a_series_keeps_its_index() -> None:
    delay = pd.Series([0.1, 0.05], index=["b", "a"])
    found: Any = ts.maximum_stiffness(DYAD, delay)
    assert isinstance(found, pd.Series)
    assert found["a"] == ts.maximum_stiffness(DYAD, 0.05)


def test_law_a_labelled_map_and_response() -> None:
    k = xr.DataArray([20.0, 71.2], dims="stiffness", coords={"stiffness": [20.0, 71.2]})
    found: Any = ts.stability_map(DYAD, k, [0.1, 0.2])
    assert isinstance(found, xr.DataArray)
    assert found.dims == ("stiffness", "delay")
    assert bool(found.sel(stiffness=71.2, delay=0.1))
    assert not bool(found.sel(stiffness=71.2, delay=0.2))
    s = xr.DataArray([1j, 2j], dims="frequency")
    matrix: Any = ts.transfer_matrix(DYAD, 71.2, 0.1, s)
    assert matrix.dims == ("frequency", "output", "input")


STUDY = ts.Study.paper()
EXPERIMENT = STUDY.experiment
assert EXPERIMENT is not None
FROZEN: list[Any] = [
    ROBOT,
    ts.Operator(0.0, 1.0, [2.0, 3.0]),
    DYAD,
    DYAD["x"],
    ts.Network((0.1, 0.2), jitter=0.01),
    ts.Coupling(20.0),
    ts.OperatorRange(ts.Operator(), ts.Operator(1.0)),
    ts.Uncertainty([0.1], [0.2], [0.3]),
    ts.verdicts(DYAD, 71.2, 0.1, sample_period=0.001),
    ts.verdicts(DYAD, 71.2, 0.1, jitter=0.01).tiers[3],
    STUDY,
    EXPERIMENT,
    EXPERIMENT.laboratory,
    EXPERIMENT.settings,
    EXPERIMENT.task,
    *EXPERIMENT.agents,
    *EXPERIMENT.arms,
    *EXPERIMENT.conditions[:2],
    DYAD.delay_system(20.0, 0.1),
    ts.crossings(DYAD["x"], 71.2)[0],
    ts.Sine(1.0, 2.0),
]


@pytest.mark.parametrize("value", FROZEN, ids=lambda value: type(value).__name__)
def test_law_equal_values_have_equal_hashes_and_survive_a_pickle(value: Any) -> None:
    again = pickle.loads(pickle.dumps(value))
    assert again == value
    assert hash(again) == hash(value)
    assert copy.deepcopy(value) == value
    assert len({value, again}) == 1
    assert repr(again) == repr(value)


def test_law_negative_zero_hashes_as_zero() -> None:
    assert ts.Operator(-0.0) == ts.Operator(0.0)
    assert hash(ts.Operator(-0.0)) == hash(ts.Operator(0.0))


def test_law_a_solution_survives_a_pickle() -> None:
    solution = ts.solve_dde(lambda _t, _y, delayed: -delayed[0], 1.0, [1.0], (0.0, 5.0))
    again = pickle.loads(pickle.dumps(solution))
    times = np.linspace(0.0, 5.0, 77)
    np.testing.assert_array_equal(again(times), solution(times))
    np.testing.assert_array_equal(again.derivative(times), solution.derivative(times))
    assert repr(again) == repr(solution)
    assert (again.message, again.discontinuities) == (solution.message, solution.discontinuities)
    short = ts.solve_dde(lambda _t, y, _d: y * y, 1.0, [1.0], (0.0, 5.0), max_steps=20)
    assert pickle.loads(pickle.dumps(short)).message == short.message != solution.message


def test_law_the_version_is_that_of_the_core() -> None:
    assert ts.__version__.count(".") == 2
    assert "__version__" in ts.__all__


def test_law_notebooks_and_prompts_show_the_answer() -> None:
    verdicts = ts.verdicts(DYAD, 71.2, 0.1, sample_period=0.001)
    assert "constant delay" in repr(verdicts.stiffness_allowed)
    assert "71.2" in repr(STUDY)[:200] or "71.23" in repr(STUDY)
    for shown in (verdicts, verdicts.tiers[0], DYAD, ROBOT, STUDY, ts.Network(0.1)):
        html = shown._repr_html_()
        assert html.startswith("<table>")
        assert html.count("<table>") == html.count("</table>")
    assert "satisfied" in verdicts._repr_html_()
    named = STUDY.replace(name="<b>mine</b>")
    assert "<b>mine" not in named._repr_html_()


def test_law_defaults_where_an_argument_has_an_obvious_value() -> None:
    assert ts.stable_delays(DYAD, 71.2) == ts.stable_delays(DYAD, 71.2, 100.0)
    assert DYAD["x"].stable_delays(71.2) == DYAD["x"].stable_delays(71.2, 100.0)
    response = ts.frequency_response(DYAD, 71.2, 0.1)
    np.testing.assert_array_equal(response.frequency, ts.open_loop(DYAD, 71.2, 0.1).frequency)
    np.testing.assert_array_equal(response.frequency, ts.partner_response(DYAD, 71.2, 0.1).frequency)
    # the resonance near √(k/m) lies inside
    assert response.frequency[0] < 1.0 < 50.0 < response.frequency[-1]


def test_law_objects_replace_sections_of_a_study() -> None:
    robot = ts.Robot([2.0, 2.5], [8.0, 9.0])
    text = "mass = [1, 1]\ndamping = 5\ncoulomb = 0.5\nmass_sd = 0.1\nname = 'old'"
    old = STUDY.with_robot(1, f"[robot]\n{text}")
    study = old.replace(robot1=robot)
    assert study.dyad.robots[0] == robot
    assert study.dyad.robots[1] == old.dyad.robots[1]
    # what was known of the old robot is gone
    assert study.uncertainty[0] is None
    assert not study.coulomb[0].any()
    operator = ts.Operator(0.5, [1.0, 2.0], 30.0)
    network = ts.Network((0.05, 0.1), 0.01, 0.004, 0.002, 0.001)
    study = old.replace(coupling=ts.Coupling(40.0, 1.0), network=network)
    assert (study.coupling, study.network) == (ts.Coupling(40.0, 1.0), network)
    operators = old.replace(operator2=operator).dyad.operators[1]
    assert operators.damping.tolist() == [1.0, 2.0]
    assert operators.stiffness.tolist() == [30.0, 30.0]
