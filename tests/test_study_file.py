"""Study files, couplings, networks and ranges of operators as Python sees them."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import pytest

import telespring as ts

TEXT = """\
name = "a held dyad"
[robot1]
name = "left"
mass = [1.0, 2.0]
damping = 5
[robot2]
mass = [1.5, 2.5]
damping = [4, 6]
[operator1]
mass = 0.5
stiffness = {min = 0, max = 300}
[coupling]
stiffness = 71.2
damping = 0.5
[network]
delay = {forward = 0.04, backward = 0.06}
jitter = 0.01
max_gap = 0.02
[controller]
sample_period = 0.001
computing_time = 0.0002
"""


def test_ref_every_value_of_the_file_arrives(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(TEXT, encoding="utf-8")
    study = ts.Study.read(path)
    assert study == ts.Study.from_toml(TEXT) == ts.Study.read(str(path))
    assert study.name == "a held dyad"
    assert study.robot_names == ("left", None)
    assert study.dyad.robots == (ts.Robot([1.0, 2.0], [5.0, 5.0]), ts.Robot([1.5, 2.5], [4.0, 6.0]))
    assert study.dyad.operators[0].stiffness.tolist() == [150.0, 150.0]
    assert study.coupling == ts.Coupling(71.2, 0.5)
    assert study.dyad.coupling_damping == 0.5
    assert study.stiffness == 71.2
    assert study.delay == (0.04, 0.06)
    assert study.network == ts.Network((0.04, 0.06), 0.01, 0.02, 0.001, 0.0002)
    assert study.operator_ranges is not None
    first, second = study.operator_ranges
    assert first == ts.OperatorRange(
        ts.Operator([0.5, 0.5], [0.0, 0.0], [0.0, 0.0]), ts.Operator([0.5, 0.5], [0.0, 0.0], [300.0, 300.0])
    )
    assert second.low == second.high


def test_law_a_study_writes_what_it_reads() -> None:
    for study in (ts.Study.from_toml(TEXT), ts.Study.paper()):
        assert ts.Study.from_toml(study.to_toml()) == study
        assert pickle.loads(pickle.dumps(study)) == study
        assert copy.deepcopy(study) == study
    assert ts.Study.paper() != ts.Study.from_toml(TEXT)


def test_ref_the_paper_is_the_default_study(hman: ts.Dyad) -> None:
    paper = ts.Study.paper()
    assert paper.dyad == hman
    assert paper.stiffness == pytest.approx(2 * 35.61599, rel=1e-6)  # 2 K_xy
    assert paper.delay == (0.167, 0.167)
    assert paper.network == ts.Network(0.167)
    assert paper.operator_ranges is None


@pytest.mark.parametrize(
    ("old", "new", "field", "line", "said"),
    [
        ("mass = 0.5", "mas = 0.5", "operator1.mas", 10, "mass"),
        ("damping = [4, 6]", "damping = [4, -6]", "robot2.damping[1]", 8, "a damping"),
        ("forward = 0.04", "forward = 40", "network.delay.forward", 16, "40 ms? Write 0.04"),
        ("delay = {forward = 0.04, backward = 0.06}", "delay = 167", "network.delay", 16, "0.167"),
        ("stiffness = 71.2", 'stiffness = "stiff"', "coupling.stiffness", 13, "number"),
        ("computing_time = 0.0002", "computing_time = 0.2", "controller.computing_time", 21, "sample period"),
    ],
)
def test_ref_a_wrong_file_is_refused_with_field_and_line(
    old: str, new: str, field: str, line: int, said: str
) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Study.from_toml(TEXT.replace(old, new))
    assert refused.value.field == field
    assert f"line {line}" in str(refused.value)
    assert said in str(refused.value)


def test_ref_a_file_that_cannot_be_read_says_why(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"none\.toml"):
        ts.Study.read(tmp_path / "none.toml")
    latin = tmp_path / "latin.toml"
    latin.write_bytes('robot1.mass = 1\nname = "Zürich"'.encode("latin-1"))
    with pytest.raises(ts.InvalidInput, match="UTF-8") as refused:
        ts.Study.read(latin)
    assert refused.value.field == str(latin)
    assert "line 2" in refused.value.value
    with pytest.raises(ts.InvalidInput):
        ts.Study.read(3)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "value",
    [
        ts.Coupling(71.2, 0.5),
        ts.Network((0.04, 0.06), jitter=0.01, max_gap=0.02, sample_period=0.001, computing_time=0.0002),
        ts.OperatorRange(ts.Operator(), ts.Operator(mass=1.5, stiffness=[1.0, 2.0])),
    ],
    ids=lambda value: type(value).__name__,
)
def test_law_copies_are_equal_and_the_text_builds_the_same_value(value: object) -> None:
    assert pickle.loads(pickle.dumps(value)) == value
    assert copy.deepcopy(value) == value
    assert eval(repr(value), vars(ts)) == value
    with pytest.raises(AttributeError):
        value.stiffness = 1.0  # type: ignore[attr-defined]


def test_ref_what_a_network_adds_to_the_age_of_a_sample() -> None:
    network = ts.Network((0.05, 0.07), 0.01, 0.004, 0.001, 0.0002)
    assert network.oldest_partner_sample == pytest.approx((0.0652, 0.0852), rel=1e-12)
    assert network.oldest_own_sample == pytest.approx(0.0012, rel=1e-12)
    assert network.buffered == pytest.approx((0.064, 0.084), rel=1e-12)
    assert not network.is_constant
    assert ts.Network(0.05, sample_period=0.001).is_constant


def test_ref_bad_values_are_refused_at_the_door() -> None:
    with pytest.raises(ts.InvalidInput, match="coupling stiffness"):
        ts.Coupling(0.0)
    with pytest.raises(ts.InvalidInput, match="sample_period"):
        ts.Network(0.1, sample_period=-1.0)
    with pytest.raises(ts.InvalidInput, match="Swap the two"):
        ts.OperatorRange(ts.Operator(stiffness=2.0), ts.Operator(stiffness=1.0))
