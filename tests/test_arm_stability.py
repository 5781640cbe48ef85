"""Verdicts in a study's own arms: against collocation in NumPy, the exact criteria and the simulated rig."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from typer.testing import CliRunner, Result

import oracle_collocation as oracle
import telespring as ts
from jointed_arms import ARM, OTHER
from telespring import cli
from telespring._types import FloatArray
from telespring.decision.arm_stability import arm_stability
from telespring.decision.equivalent_operators import equivalent_operators
from telespring.decision.target_positions import target_positions
from telespring.paper.page import render
from telespring.paper.scene import Scene
from telespring.paper.sections.arms.section import find_arms
from telespring.paper.sections.laboratory.section import find_laboratory
from telespring.show import figures
from telespring.show.screens.arms import describe_unavailable_arms
from telespring.theory.poses import pose_stability

LUMPED: dict[str, Any] = {
    "arm1": {"kind": "lumped", "mass": [0.8, 0.5], "damping": [1.0, 0.3]},
    "arm2": {"kind": "lumped", "mass": 0.4, "damping": 0.6},
    "agent1": {"kind": "skilled", "stiffness": 90.0, "damping": 2.0},
}
CONDITIONS = [(35.6, 0.167), (71.2, 0.05), (142.0, 0.09), (142.0, 0.2)]


def jointed(**more: Any) -> ts.Study:
    return ts.Study.paper().replace(**{"arm1": ARM, "arm2": OTHER, **more})


def command(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"}).invoke(cli.app, list(map(str, arguments)))


def written(folder: Path, study: ts.Study, more: str = "") -> Path:
    path = folder / "study.toml"
    path.write_text(study.to_toml() + more, encoding="utf-8")
    return path


# Arms that are alike in every pose


def test_cross_collocation_has_the_abscissa_in_lumped_arms() -> None:
    study = ts.Study.paper().replace(**LUMPED)
    found = arm_stability(study, CONDITIONS)
    k, delay = np.array(CONDITIONS).T
    one, two = ts.hman().robots
    abscissae = []
    for axis in range(2):
        columns = [
            one.mass[axis] + LUMPED["arm1"]["mass"][axis],
            one.damping[axis] + LUMPED["arm1"]["damping"][axis] + 2.0,
            two.mass[axis] + 0.4,
            two.damping[axis] + 0.6,
            90.0,
            120.0,
            0.0,
        ]
        axes = oracle.Axes(*np.full((7, len(k)), np.array(columns)[:, None]))
        verdict = oracle.spectral_abscissa(axes, k, delay)
        assert verdict.resolved.all()
        abscissae.append(verdict.abscissa)
    expected = np.array(abscissae)
    for i, each in enumerate(found.conditions):
        # 1e-8: what the oracle's refinement and ours leave
        assert each.spectral_abscissa == pytest.approx(expected[:, i].max(), abs=1e-8)
        assert each.unstable_axes == tuple(
            name for name, a in zip("xy", expected[:, i], strict=True) if a > 0
        )
    assert {each.stable for each in found.conditions} == {True, False}


def test_law_lumped_arms_are_operators_in_the_papers_criterion() -> None:
    study = ts.Study.paper().replace(**LUMPED)
    found = arm_stability(study, CONDITIONS)
    operators = (ts.Operator([0.8, 0.5], [3.0, 2.3], 90.0), ts.Operator(0.4, 0.6, 120.0))
    dyad = ts.Dyad(*ts.hman().robots, operators)
    for each in found.conditions:
        worst = max(ts.spectral_abscissa(dyad, each.stiffness, each.delay, axis) for axis in dyad.axes)
        assert each.spectral_abscissa == pytest.approx(worst, abs=1e-12)  # rounding of the sums
    # the report's boundary says the same of the same conditions
    conditions = [{"stiffness": k, "delay": d} for k, d in CONDITIONS]
    study = study.replace(protocol={"conditions": conditions})
    numbers = find_arms(Scene.of(study)).numbers["arms"]
    assert [each["in_arms"] == "stable" for each in numbers["conditions"]] == [
        c.stable for c in found.conditions
    ]
    assert numbers["arm_mass"] == [[0.8, 0.5], [0.4, 0.4]]
    assert numbers["agent_damping"] == [2.0, 0.0]
    for axis, mass in zip(numbers["axes"], (0.8, 0.5), strict=True):
        i = "xy".index(axis["axis"])
        assert mass == LUMPED["arm1"]["mass"][i]
        m1, m2 = (
            dyad.robots[side].mass[i] + np.broadcast_to(operators[side].mass, 2)[i] for side in range(2)
        )
        b1, b2 = (
            dyad.robots[side].damping[i] + np.broadcast_to(operators[side].damping, 2)[i] for side in range(2)
        )
        expected = ts.critical_stiffness(m1, b1, m2, b2, kh1=90.0, kh2=120.0)
        assert axis["critical_stiffness_in_arms"] == pytest.approx(float(expected), rel=1e-12)


def test_law_arms_take_the_place_of_the_operators() -> None:
    plain = arm_stability(ts.Study.paper(), CONDITIONS)
    held = ts.Study.paper().replace(operator1={"mass": 1.0, "damping": 3.0, "stiffness": 50.0})
    assert arm_stability(held, CONDITIONS).conditions == plain.conditions


# Two-link arms


def handle_matrices(arm: dict[str, Any], position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return mass and damping at the handle of a two-link arm, from the textbook's joint inertia."""
    (l1, l2), (m1, m2), (c1, c2), (i1, i2) = (
        arm[key] for key in ("link_length", "link_mass", "link_centre", "link_inertia")
    )
    x, y = position - arm["base"]
    sign = 1 if arm["elbow"] == "right" else -1
    bend = sign * np.arccos((x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2))
    turn = np.arctan2(y, x) - np.arctan2(l2 * np.sin(bend), l1 + l2 * np.cos(bend))
    both = turn + bend
    jacobian = np.array(
        [
            [-l1 * np.sin(turn) - l2 * np.sin(both), -l2 * np.sin(both)],
            [l1 * np.cos(turn) + l2 * np.cos(both), l2 * np.cos(both)],
        ]
    )
    shared = i2 + m2 * (c2 * c2 + l1 * c2 * np.cos(bend))
    first = i1 + i2 + m1 * c1 * c1 + m2 * (l1 * l1 + c2 * c2 + 2 * l1 * c2 * np.cos(bend))
    inertia = np.array([[first, shared], [shared, i2 + m2 * c2 * c2]]) + np.diag(arm["rotor_inertia"])
    back = np.linalg.inv(jacobian)
    return back.T @ inertia @ back, back.T @ np.diag(arm["joint_damping"]) @ back


def collocated_abscissa(sides: list[tuple[FloatArray, FloatArray, float]], k: float, delay: float) -> float:
    """Return the largest real part by Chebyshev collocation (Breda, Maset, Vermiglio 2005), in NumPy."""
    now, late = np.zeros((8, 8)), np.zeros((8, 8))
    for i, (mass, damping, ground) in enumerate(sides):
        inverse, at, other = np.linalg.inv(mass), 4 * i, 4 - 4 * i
        now[at : at + 2, at + 2 : at + 4] = np.eye(2)
        now[at + 2 : at + 4, at : at + 2] = -(ground + k) * inverse
        now[at + 2 : at + 4, at + 2 : at + 4] = -inverse @ damping
        late[at + 2 : at + 4, other : other + 2] = k * inverse
    nodes = 24
    grid = np.arange(nodes + 1)
    points = np.cos(np.pi * grid / nodes)
    weights = np.where((grid == 0) | (grid == nodes), 2.0, 1.0) * (-1.0) ** grid
    derivative = weights[:, None] / weights / (points[:, None] - points + np.eye(nodes + 1))
    derivative -= np.diag(derivative.sum(axis=1))
    whole = np.kron(2.0 / delay * derivative, np.eye(8))
    whole[:8] = 0.0
    whole[:8, :8], whole[:8, -8:] = now, late
    return float(np.linalg.eigvals(whole).real.max())


def test_cross_collocation_has_the_abscissa_of_the_worst_pose_and_of_no_worse() -> None:
    found = arm_stability(jointed(), [(142.0, 0.15)])
    (each,) = found.conditions
    assert found.poses is not None
    abscissae = []
    for place in found.poses.positions:
        sides = []
        for arm, robot in zip((ARM, OTHER), ts.hman().robots, strict=True):
            mass, damping = handle_matrices(arm, place)
            sides.append((mass + np.diag(robot.mass), damping + np.diag(robot.damping), 120.0))
        abscissae.append(collocated_abscissa(sides, 142.0, 0.15))
    # 1e-7: what 24 nodes resolve of roots near 10 rad/s over 0.15 s, eigenvalues of 200 rows rounded
    assert each.spectral_abscissa == pytest.approx(max(abscissae), abs=1e-7)
    assert each.least_abscissa == pytest.approx(min(abscissae), abs=1e-7)
    assert each.unstable_poses == np.count_nonzero(np.array(abscissae) > 0)
    assert each.worst_position == tuple(found.poses.positions[int(np.argmax(abscissae))])


def test_law_more_poses_find_no_pose_much_worse() -> None:
    study = jointed()
    (coarse,) = arm_stability(study, [(142.0, 0.15)]).conditions
    assert study.experiment is not None
    angle = np.linspace(0.0, 2 * np.pi, 500, endpoint=False)
    operators = equivalent_operators(study, study.experiment)
    path = np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])
    fine = pose_stability(operators.held, operators.jointed, 142.0, 0.15, path)
    # 0.01 1/s: of an abscissa that spans several tenths over the path
    assert fine.worst_abscissa - coarse.spectral_abscissa < 0.01


def test_law_a_two_link_arm_without_mass_is_no_arm() -> None:
    nothing = {**ARM, "link_mass": 0.0, "link_inertia": 0.0, "joint_damping": 0.0, "rotor_inertia": 0.0}
    found = arm_stability(jointed(arm1=nothing, arm2=nothing), CONDITIONS)
    plain = arm_stability(ts.Study.paper(), CONDITIONS)
    assert found.poses is not None
    assert found.poses.axes_are_independent
    for one, other in zip(found.conditions, plain.conditions, strict=True):
        assert one.stable == other.stable
        # 1e-9: eight states by collocation and Newton, beside the exact roots of one axis
        assert one.spectral_abscissa == pytest.approx(other.spectral_abscissa, abs=1e-9)


def growth(study: ts.Study, stiffness: float, delay: float, duration: float) -> float:
    """Return how fast the distance between the handles grows in a simulated trial, 1/s."""
    assert study.experiment is not None
    run = study.experiment.laboratory.run(stiffness, delay, 5, duration, 100.0)
    apart = np.linalg.norm(run.position[:, 0] - run.position[:, 1], axis=1)
    # the envelope: the largest in windows longer than any swing here
    windows = apart[: len(apart) // 100 * 100].reshape(-1, 100).max(axis=1)
    late = slice(len(windows) // 2, None)
    return float(np.polyfit(run.time[50::100][: len(windows)][late], np.log(windows[late]), 1)[0])


@pytest.mark.parametrize(("stiffness", "delay"), [(142.0, 0.15), (200.0, 0.12), (180.0, 0.3)])
def test_cross_the_rig_grows_in_one_pose_as_its_abscissa_says(stiffness: float, delay: float) -> None:
    # A target that stands still is one pose; a cloud of hardly moving spots wakes the motion up.
    study = jointed(
        task={"amplitude": [0.0, 0.0]},
        agent2={"kind": "blurred", "spot_velocity": 1e-9},
        protocol={"trials": 1, "duration": 12.0, "discard": 1.0},
    )
    (each,) = arm_stability(study, [(stiffness, delay)]).conditions
    assert each.spectral_abscissa > 0.2
    # until the growth, a millionfold, has left the spots behind
    measured = growth(study, stiffness, delay, 14.0 / each.spectral_abscissa)
    # Held forces act half a period of 1 ms late, on the own spring as well: 0.03 1/s faster.
    assert measured == pytest.approx(each.spectral_abscissa, abs=0.04)


def test_cross_along_the_figure_the_rig_grows_where_every_pose_is_unstable_and_only_there() -> None:
    study = jointed(agent2={"kind": "blurred", "spot_velocity": 1e-6})
    unstable, stable = arm_stability(study, [(200.0, 0.15), (71.2, 0.05)]).conditions
    assert unstable.least_abscissa > 0
    assert stable.spectral_abscissa < 0
    assert growth(study, 200.0, 0.15, 12.0) > 0.2
    # the path repeats: nothing is left that grows
    assert abs(growth(study, 71.2, 0.05, 24.0)) < 0.02


def test_law_places_lie_on_the_targets_path_and_cover_it(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(
        "import numpy as np\n"
        "def circle(times):\n"
        "    return np.column_stack([0.1 * np.cos(3 * times), 0.1 * np.sin(3 * times)])\n"
    )
    study = jointed(task={"kind": "python", "function": "mine:circle"}, protocol={"duration": 6.0})
    assert study.experiment is not None
    places, section = target_positions(study.experiment, tmp_path)
    assert section == "whole trial"
    assert len(places) == 32
    np.testing.assert_allclose(np.hypot(*places.T), 0.1, rtol=1e-12)  # rounding of sine and cosine
    angles = np.sort(np.arctan2(places[:, 1], places[:, 0]))
    # 32 points spread one after the other leave no gap of a sixteenth of the circle
    assert np.diff(angles, append=angles[0] + 2 * np.pi).max() < 2 * np.pi / 16 + 1e-3
    figure, section = target_positions(jointed().experiment)  # type: ignore[arg-type]  # has two axes
    assert section == "period"
    assert len({tuple(place) for place in figure}) == len(figure) == 31
    still, _ = target_positions(jointed(task={"amplitude": [0.0, 0.0]}).experiment)  # type: ignore[arg-type]
    assert still.tolist() == [[0.0, 0.0]]


# What is not known


def reason(study: ts.Study, folder: Path | None = None) -> str:
    found = arm_stability(study, CONDITIONS, folder)
    assert found.operators is None
    assert not found.conditions
    assert found.unavailable
    return describe_unavailable_arms(found) or ""


def test_law_nobody_knows_the_stiffness_of_a_program(root: Path) -> None:
    study = ts.Study.read(root / "examples" / "tremor.toml")
    assert "agent 2 is the program tremor_agents:Tremor" in reason(study)
    found = find_arms(Scene.of(study))
    assert not found.numbers["arms"]["known"]
    assert not found.drawings


def test_law_a_target_out_of_reach_or_unusable_is_told_and_not_judged(tmp_path: Path) -> None:
    far = jointed(arm1={**ARM, "base": [0.0, -0.6]})
    assert "reach" in reason(far)
    missing = jointed(task={"kind": "python", "function": "nowhere:target"})
    assert "nowhere" in reason(missing, tmp_path)


def test_law_robots_of_one_axis_have_no_arms() -> None:
    lonely = ts.Study.from_toml(
        "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\n"
        "coupling.stiffness = 20\nnetwork.delay = 0.05"
    )
    with pytest.raises(ts.InvalidInput, match="two axes"):
        arm_stability(lonely, CONDITIONS)


# Commands and report


def test_law_decide_tells_of_arms_only_where_the_file_names_them(root: Path, tmp_path: Path) -> None:
    path = written(tmp_path, ts.Study.paper())
    assert not ts.Study.read(path).names_arms_or_agents
    plain = command("decide", path)
    assert "arms" not in plain.stdout
    assert json.loads(command("decide", path, "--json").stdout)["in_arms"] is None
    written(tmp_path, ts.Study.paper(), '\n[agent1]\nkind = "skilled"\n')
    named = command("decide", path, "--stiffness", "142", "--delay", "0.084")
    assert named.exit_code == 0
    assert "With them the dyad is unstable on x (doubling every 8.32 s)" in named.stdout
    told = json.loads(command("decide", path, "--stiffness", "142", "--delay", "0.084", "--json").stdout)
    assert told["in_arms"]["unstable_axes"] == ["x"]
    assert not told["in_arms"]["stable"]
    # all but this line is what a study without arms is told
    before = command("decide", path).stdout.splitlines()
    assert [line for line in plain.stdout.splitlines() if line.strip() and line not in before] == []
    example = root / "examples" / "two-link.toml"
    assert "With them the dyad is stable with continuous controllers (worst at (0, 120) mm" in " ".join(
        command("decide", example).stdout.split()
    )
    arms = json.loads(command("decide", example, "--json").stdout)["in_arms"]
    assert arms["depends_on_pose"]
    assert arms["unstable_axes"] is None
    assert not arms["axes_independent"]
    tremor = command("decide", root / "examples" / "tremor.toml")
    assert "stability with them is unknown: agent 2 is the program" in " ".join(tremor.stdout.split())


def test_law_decide_judges_the_delay_behind_the_buffer(tmp_path: Path) -> None:
    path = written(tmp_path, ts.Study.paper(), '\n[agent1]\nkind = "skilled"\n')
    (expected,) = arm_stability(ts.Study.paper(), [(142.0, 0.09)]).conditions
    arguments = ("decide", path, "--stiffness", "142", "--delay", "0.05", "--jitter", "0.04", "--json")
    told = json.loads(command(*arguments).stdout)["in_arms"]
    assert told["spectral_abscissa"] == pytest.approx(expected.spectral_abscissa, abs=1e-12)  # 0.05 + 0.04
    assert not told["stable"]


def test_law_rehearse_ends_with_the_verdict_beside_how_trials_ended(tmp_path: Path) -> None:
    study = jointed(
        protocol={
            "conditions": [{"stiffness": 35.6, "delay": 0.05}, {"stiffness": 1500.0, "delay": 0.1}],
            "trials": 2,
            "duration": 3.0,
            "discard": 1.0,
        }
    )
    told = command("rehearse", written(tmp_path, study), "--out", tmp_path / "out", "--workers", "1").stdout
    lines = {line.split()[0]: line for line in told.splitlines() if line.startswith(("UM", "CM"))}
    assert list(lines) == ["UM", "CM-36-50", "CM-1500-100"]
    assert lines["UM"].split() == ["UM", "–", "2", "–"]
    assert "stable, worst at (" in lines["CM-36-50"]
    assert lines["CM-36-50"].split()[-2:] == ["2", "–"]
    assert "unstable, worst at (" in lines["CM-1500-100"]
    # none completed, both ended early
    ended = r" 0  2 (out of reach of arm [12]|diverged), the first at \d\.\d+ s *$"
    assert re.search(ended, lines["CM-1500-100"])
    assert "x and y are not independent" in told


def page(study: ts.Study) -> tuple[dict[str, Any], str]:
    """Return the arms' section of `study.json` and the page without any other section."""
    scene = Scene.of(study)
    findings = find_arms(scene)
    json.dumps(findings.numbers, allow_nan=False)
    return findings.numbers["arms"], render(scene.describe_study(), {"arms": findings})


def test_law_the_report_has_the_arms_that_the_study_has() -> None:
    arms, html = page(jointed(protocol={"conditions": [{"stiffness": 142.0, "delay": 0.167}]}))
    (condition,) = arms["conditions"]
    assert condition["in_arms"] == "unstable"
    assert condition["unstable_axes_in_arms"] is None
    assert condition["unstable_poses"] == 31
    assert condition["independent_abscissa"] > condition["spectral_abscissa"] > 0
    assert not arms["axes_independent"]
    assert "The axes are not independent" in html
    assert 'id="figure-arms"' in html
    _, html = page(ts.Study.paper().replace(**LUMPED))
    assert "which are the same in every pose" in html
    arms, html = page(ts.Study.paper().replace(agent2={"kind": "python", "class": "mine:Spring"}))
    assert not arms["known"]
    assert "Unknown: agent 2 is the program mine:Spring" in html
    arms, html = page(ts.Study.paper())
    assert arms["massless"]
    assert "massless and undamped here" in html
    # nothing but the unconnected mode: nothing to judge, nothing that fails
    for study in (ts.Study.paper(), jointed()):
        arms, _ = page(study.replace(protocol={"conditions": []}))
        assert arms["conditions"] == []


def test_law_a_torque_without_limit_is_told_as_such() -> None:
    numbers = find_laboratory(Scene.of(jointed())).numbers["laboratory"]
    json.dumps(numbers, allow_nan=False)
    limits = [row["value"] for row in numbers["parameters"] if "torque" in row["name"]]
    assert limits == [None] * 4


@pytest.mark.parametrize("count", [0, 1, 16])
def test_law_the_figure_of_the_poses_is_whole_and_the_same_every_time(count: int) -> None:
    def drawn() -> Figure:
        angle = np.linspace(0.0, 2 * np.pi, 31, endpoint=False)
        places = np.column_stack([0.05 * np.sin(2 * angle), 0.1 * np.sin(angle)])
        ranges = [
            figures.PoseRange(f"{10 * i} N/m, {20 * i} ms", i - 9.0, i - 8.0, i - 8.5, (0.05, 0.07))
            for i in range(count)
        ]
        return figures.poses_figure(ranges, places, np.abs(places) * 4.0)

    figure = drawn()
    text = figures.to_svg(figure, "arms", "title", "description")
    assert text == figures.to_svg(drawn(), "arms", "title", "description")
    with figures.style.figure_style():
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib gives it no types
        box = figure.get_tightbbox(canvas.get_renderer())  # type: ignore[no-untyped-call]
    width, height = figure.get_size_inches()
    # a hundredth of an inch: half of a line's width may stand over the edge
    assert min(box.x0, box.y0) > -0.01
    assert box.x1 < width + 0.01
    assert box.y1 < height + 0.01
