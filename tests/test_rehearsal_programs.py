"""Agents and targets in Python in a rehearsal."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import telespring as ts
from resuming import interrupted_after, written
from short_rehearsal import command, loaded, study_text
from telespring.rehearsal import run_protocol
from telespring.rehearsal.encoding import SIGNALS

TARGET = '[task]\nkind = "python"\nfunction = "mine:{name}"'


SPRING = '[agent1]\nkind = "python"\nclass = "mine:{name}"\noptions = {options}'


MINE = """
class Spring:
    def __init__(self, seed, stiffness=120.0):
        self.seed, self.stiffness = seed, stiffness

    def __call__(self, time, position, velocity, target):
        return self.stiffness * (target - position)


class Late(Spring):
    def __call__(self, time, position, velocity, target):
        if time > 1.0:
            return 1.0 / 0.0
        return super().__call__(time, position, velocity, target)


class Leaving(Spring):
    def __call__(self, time, position, velocity, target):
        import sys
        sys.exit(0)


class Refusing(Spring):
    def __init__(self, seed):
        raise SystemExit


class Wrong(Spring):
    def __call__(self, time, position, velocity, target):
        return target[:1]


def leaving(times):
    raise SystemExit(0)


def still(times):
    return [[0.1, 0.2]] * len(times)


def millimetres(times):
    return [[50.0 * t, 100.0 * t] for t in times]


def jumping(times):
    return [[0.0 if t < 0.5005 else 0.1, 0.0] for t in times]


def one_axis(times):
    return times


def undefined(times):
    return [[float("nan"), 0.0]] * len(times)
"""


@pytest.fixture
def mine(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    def write(more: str) -> Path:
        (tmp_path / "mine.py").write_text(MINE, encoding="utf-8")
        return written(tmp_path, study_text(more=more))

    yield write
    assert "mine" not in sys.modules
    assert str(tmp_path) not in sys.path


def test_cross_an_agent_in_python_moves_as_the_laboratorys_own(
    mine: Callable[[str], Path], tmp_path: Path
) -> None:
    """A spring in Python and the laboratory's skilled agent are the same law, so the same motion."""
    found = ts.rehearse(mine(SPRING.format(name="Spring", options="{stiffness = 120.0}")), tmp_path / "out")
    own = ts.rehearse(ts.Study.from_toml(study_text()), tmp_path / "own")
    for kept in SIGNALS:
        # rounding to the resolution may fall on either side
        np.testing.assert_allclose(found[kept.name], own[kept.name], rtol=0, atol=2 * 2.0**-kept.bits)
    np.testing.assert_array_equal(found.seed, own.seed)
    programs = json.loads(found.attrs["programs"])
    assert programs["agent1"]["name"] == "mine:Spring"
    assert len(programs["agent1"]["sha256"]) == 64


def test_law_a_target_in_python_is_followed(mine: Callable[[str], Path], tmp_path: Path) -> None:
    found = ts.rehearse(mine(TARGET.format(name="still")), tmp_path / "out")
    np.testing.assert_allclose(found.target, np.tile([0.1, 0.2], (201, 1)), rtol=0, atol=2.0**-30)
    # the skilled agent of robot 1 is held at the target's place by nobody in the unconnected mode
    apart = found.position.sel(condition="UM", robot=1) - found.target
    np.testing.assert_allclose(apart, np.zeros(apart.shape), rtol=0, atol=2.0**-29)


@pytest.mark.parametrize(
    ("more", "field", "said"),
    [
        (
            SPRING.format(name="Late", options="{}"),
            "agent1.class",
            r"ZeroDivisionError: .* \(mine.py, line 13, in __call__\) at t = 1.001 s, in trial \d of \w+",
        ),
        (SPRING.format(name="Leaving", options="{}"), "agent1.class", r"raised SystemExit: 0 .* at t = 0 s"),
        (SPRING.format(name="Refusing", options="{}"), "agent1.class", "accept seed by name, .* SystemExit"),
        (TARGET.format(name="leaving"), "task.function", "must not raise exceptions, .* SystemExit: 0"),
        (SPRING.format(name="Wrong", options="{}"), "agent1.class", "two finite numbers .* at t = 0 s"),
        (
            SPRING.format(name="Spring", options="{weight = 1.0}"),
            "agent1.class",
            "accept seed, weight by name",
        ),
        (SPRING.format(name="Sprung", options="{}"), "agent1.class", "named Sprung"),
        (SPRING.format(name="still", options="{}"), "agent1.class", "a class is required"),
        (
            SPRING.format(name="x", options="{}").replace("mine", "nowhere"),
            "agent1.class",
            "in the folder of the study file .* or on Python's module path",
        ),
        # the call itself fails: no line of the user's file, and none of ours
        (
            TARGET.format(name="still") + "\noptions = {radius = 1.0}",
            "task.function",
            r"TypeError: .*radius'\. Correct it in mine\.py\. A target is called",
        ),
        (TARGET.format(name="millimetres"), "task.function", "within 10 m, .* millimetres"),
        (TARGET.format(name="jumping"), "task.function", "at 100 m/s at t = 0.5 s"),
        (
            TARGET.format(name="one_axis"),
            "task.function",
            r"shape \(2001, 2\), but it returned \(2001,\)",
        ),
        (TARGET.format(name="undefined"), "task.function", "must be finite"),
    ],
)
def test_law_what_a_program_does_wrong_is_told_with_its_place(
    mine: Callable[[str], Path], tmp_path: Path, more: str, field: str, said: str
) -> None:
    with pytest.raises(ts.InvalidInput, match=said) as refused:
        ts.rehearse(mine(more), tmp_path / "out")
    assert refused.value.field == field
    told = command(mine(more), "--out", tmp_path / "out")
    assert told.exit_code == 2
    assert "Traceback" not in told.output


def test_law_after_a_programs_failure_finished_trials_stay(tmp_path: Path) -> None:
    """The agent fails once four trials are kept, as by something outside of it, and later does not."""
    (tmp_path / "mine.py").write_text(
        MINE
        + """
import pathlib

class Moody(Spring):
    def __init__(self, seed):
        super().__init__(seed)
        kept = list((pathlib.Path(__file__).parent / "out" / "trials").glob("*.trial"))
        if len(kept) >= 4 and (pathlib.Path(__file__).parent / "mood").exists():
            raise OSError("no mood")
"""
    )
    (tmp_path / "mood").write_text("bad")
    study = written(tmp_path, study_text(more=SPRING.format(name="Moody", options="{}")))
    with pytest.raises(ts.InvalidInput, match="no mood") as refused:
        ts.rehearse(study, tmp_path / "out")
    assert "Finished trials are kept" in refused.value.remedy
    (tmp_path / "mood").unlink()
    assert run_protocol(study, tmp_path / "out").resumed >= 4


def test_law_trials_of_two_versions_of_a_program_are_not_mixed(
    mine: Callable[[str], Path], tmp_path: Path
) -> None:
    study = mine(SPRING.format(name="Spring", options="{}"))
    with pytest.raises(KeyboardInterrupt):
        ts.rehearse(study, tmp_path / "out", interrupted_after(4))
    (tmp_path / "mine.py").write_text(MINE.replace("120.0", "60.0"))
    with pytest.raises(ts.InvalidInput, match="another version of the Python file of agent1"):
        ts.rehearse(study, tmp_path / "out")
    ts.rehearse(study, tmp_path / "out", fresh=True)


def test_law_a_program_that_fails_at_once_may_be_mended(mine: Callable[[str], Path], tmp_path: Path) -> None:
    study = mine(SPRING.format(name="Wrong", options="{}"))
    with pytest.raises(ts.InvalidInput, match="two finite numbers"):
        ts.rehearse(study, tmp_path / "out")
    (tmp_path / "mine.py").write_text(MINE.replace("target[:1]", "target"))
    assert (ts.rehearse(study, tmp_path / "out").status[:2] == 0).all()


def test_law_a_robot_from_a_file_of_its_own_takes_part(tmp_path: Path) -> None:
    (tmp_path / "robot.toml").write_text("[robot]\nmass = [2.0, 3.0]\ndamping = [7.0, 8.0]\n")
    study = written(tmp_path, study_text(more=TARGET.format(name="still")))
    (tmp_path / "mine.py").write_text(MINE)
    done = command(study, "--out", tmp_path / "out", "--robot2", tmp_path / "robot.toml")
    assert done.exit_code == 0, done.output
    robots = json.loads(loaded(tmp_path / "out").attrs["robots"])
    assert [robot["mass"] for robot in robots] == [[0.8334, 1.0649], [2.0, 3.0]]


def test_law_the_example_with_agents_in_python_runs(root: Path, tmp_path: Path) -> None:
    done = command(root / "examples" / "tremor.toml", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    found = loaded(tmp_path)
    assert (found.status == 0).all()
    radius = np.hypot(found.target.sel(axis="x"), found.target.sel(axis="y"))
    np.testing.assert_allclose(radius, 0.08, rtol=0, atol=2.0**-29)
    # both hands tremble by themselves at 6 Hz only on robot 2, and its seeds differ from trial to trial
    force = found.agent_force.sel(condition="UM").isel(time=slice(400, None))
    power = np.abs(np.fft.rfft(force, axis=1)) ** 2
    frequency = np.fft.rfftfreq(force.sizes["time"], 1 / found.attrs["record_rate"])
    trembling = power[:, (frequency > 5) & (frequency < 7)].sum(axis=1)
    assert (trembling[:, 1] > 100 * trembling[:, 0]).all()
    assert len(np.unique(trembling[:, 1])) == trembling[:, 1].size


def test_law_a_module_that_leaves_is_told(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("raise SystemExit(0)")
    study = written(tmp_path, study_text(more=SPRING.format(name="Spring", options="{}")))
    told = command(study, "--out", tmp_path / "out")
    assert told.exit_code == 2
    assert "SystemExit" in told.output
