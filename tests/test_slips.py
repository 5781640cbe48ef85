"""What people type by mistake: another file, another mark, another way to write a unit, a truth value."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts
from questions import MINE, answered, flat, run

LOG = "time,position_x,force_x\n0,0,1\n0.01,0.1,2\n"
FILES = {
    "log.csv": LOG,
    "robot.toml": "[robot]\nmass = 1\ndamping = 5\n",
    "study.toml": "[robot1]\nmass = 1\ndamping = 5\n[robot2]\nmass = 1\ndamping = 5\n",
    "01.csv": "time_s,position_robot1_x_m,position_robot2_x_m\n0,0,0\n",
}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("decide", "log.csv"), "telespring identify"),
        (("decide", "--robot", "log.csv", "--robot", "hman1"), "telespring identify"),
        (("simulate", "log.csv"), "telespring identify"),
        (("rehearse", "log.csv"), "telespring identify"),
        (("decide", "robot.toml"), "--robot"),
        (("rehearse", "robot.toml"), "--robot"),
        (("decide", "--robot", "study.toml", "--robot", "hman1"), "without --robot"),
        (("identify", "01.csv"), "telespring analyse"),
        (("identify", "robot.toml"), "telespring decide --robot"),
        (("identify", "study.toml"), "telespring decide"),
        (("identify", "."), "telespring analyse"),
        (("analyse", "log.csv"), "telespring identify"),
        (("analyse", "01.csv"), "trials.csv"),
        (("analyse", "study.toml"), "telespring rehearse"),
        (("analyse", "robot.toml"), "telespring decide --robot"),
    ],
)
def test_law_a_file_of_another_kind_is_told_its_command(
    arguments: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    found = run(*arguments)
    assert found.exit_code == 2
    assert words in flat(found.stderr)
    assert "Correct line" not in found.stderr


@pytest.mark.parametrize("grip", ["50,300", "50-300", "50..300", "50 to 300", "50 300"])
def test_law_a_range_with_another_mark_is_asked_back(grip: str) -> None:
    found = run("decide", *MINE, "--ping", "80ms", "--grip", grip)
    assert found.exit_code == 2
    assert "Did you mean 50:300" in flat(found.stderr)


def test_law_a_hands_damping_is_read_where_it_is_meant() -> None:
    for grip in ("120,5", "0,5", "50:300,0:5"):
        answered(*MINE, "--ping", "80ms", "--grip", grip)
    assert run("decide", *MINE, "--grip", "300,200").exit_code == 2  # no hand has 200 N·s/m
    assert run("decide", *MINE, "--grip", "50,300", "--allow-unusual").exit_code == 0


@pytest.mark.parametrize(
    "unit", ["Ns/m", "N s/m", "N.s/m", "N*s/m", "N·s/m", "N-s/m", "N s m^-1", "N s m-1", "N·s·m⁻¹", "kg/s"]
)
def test_ref_newton_seconds_per_metre_as_people_write_them(unit: str) -> None:
    plain = answered("--robot", "1.2,9", "--robot", "2,9", "--ping", "80ms")
    for space in ("", " "):
        assert answered("--robot", f"1.2,9{space}{unit}", "--robot", "2,9", "--ping", "80ms") == plain


@pytest.mark.parametrize("columns", [40, 60, 79, 80, 100])
@pytest.mark.parametrize("command", ["decide", "simulate", "identify", "rehearse", "analyse", "reproduce"])
def test_law_the_help_cuts_no_option(command: str, columns: int) -> None:
    import typer

    from telespring import cli

    text = run(command, "--help", columns=columns).stdout
    of_command: Any = typer.main.get_command(cli.app)
    for parameter in of_command.commands[command].params:
        for name in (*parameter.opts, *parameter.secondary_opts):
            assert not name.startswith("--") or name in text, (name, columns)
    assert columns == 40 or "…" not in text


FORCES = [[1.0, 1.0], [0.0, 0.0]]
NUMBERS: list[tuple[Callable[..., Any], tuple[Any, ...]]] = [
    (ts.Network, (0.1, 0.0, 0.0, 0.001, 0.0)),
    (ts.Robot, (1.0, 5.0)),
    (ts.Operator, (1.0, 5.0, 10.0)),
    (ts.Coupling, (20.0, 0.0)),
    (ts.critical_stiffness, (1.0, 1.0, 5.0, 5.0)),
    (lambda k, delay: ts.verdicts(ts.hman(), k, delay), (20.0, 0.1)),
    (lambda k, delay: ts.decide(ts.hman(), k, delay), (20.0, 0.1)),
    (lambda k, delay: ts.stability_map(ts.hman(), k, delay), (20.0, 0.1)),
    (
        lambda duration, rate: ts.simulate(ts.hman(), 20.0, 0.1, FORCES, duration, rate=rate),
        (1.0, 100.0),
    ),
    (lambda y: ts.solve_dde(lambda _t, y, _d: -y, 1.0, [y], (0.0, 1.0)), (1.0,)),
    (lambda most: ts.solve_dde(lambda _t, y, _d: -y, 1.0, [1.0], (0.0, 1.0), max_steps=most), (1000,)),
    (lambda k: ts.Study.paper().replace(coupling={"stiffness": k}), (20.0,)),
]


@pytest.mark.parametrize(("call", "valid"), NUMBERS)
@pytest.mark.parametrize("wrong", [True, np.True_, [True], np.array([True])], ids=repr)
def test_law_a_truth_value_is_no_number(call: Callable[..., Any], valid: tuple[Any, ...], wrong: Any) -> None:
    call(*valid)
    for i in range(len(valid)):
        with pytest.raises(ts.InvalidInput):
            call(*valid[:i], wrong, *valid[i + 1 :])


def test_law_one_axis_needs_one_name() -> None:
    log = Path(__file__).parents[1] / "examples" / "log.csv"
    of_y = run("identify", str(log), "--position", "position_y")
    assert of_y.exit_code == 0, of_y.output
    assert of_y.stdout == run("identify", str(log), "--force", "force_y").stdout
    both = ("--position", "position_y", "--force", "force_y", "--axis", "y")
    assert of_y.stdout == run("identify", str(log), *both).stdout
    refused = run("identify", str(log), "--position", "2")
    assert refused.exit_code == 2
    assert "Give --force too" in flat(refused.stderr)
