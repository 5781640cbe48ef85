"""Adversaries on a study's network: read and written, rehearsed, and what no verdict says about them."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app

#: Mass (kg) and damping (N·s/m) of the H-MAN's x, and b²/m, N/m, as in docs/networks.md.
MASS, DAMPING = 0.8334, 7.7257
SCALE = DAMPING**2 / MASS

#: Both handles are held apart, at rest, for so long, s, and then let go.
HELD = 6.0

AGENTS = '''
import numpy as np


class Held:
    """Holds a handle at a place on x, and lets it go."""

    def __init__(self, seed, place, until):
        self.place, self.until = np.array([place, 0.0]), until

    def __call__(self, time, position, velocity, target):
        if time > self.until - 5e-4:
            return np.zeros(2)
        return 400.0 * (self.place - position) - 40.0 * velocity
'''

EACH: list[dict[str, str | float]] = [
    {"kind": "oldest-sample", "memory": 1.0},
    {"kind": "most-harmful-sample", "memory": 1.0},
    {"kind": "stretch-timed", "longest": 1.0},
    {"kind": "lying-peer", "position": 0.05, "stamp": -0.1, "power": 0.0},
]


def let_go(
    folder: Path, adversary: str, stiffness: float, seconds: float, *, delay: float = 0.0, session: str = ""
) -> NDArray[np.float64]:
    """Rehearse two H-MANs that are let go; return the positions (time, robot) on x from there on, m."""
    folder.mkdir()
    (folder / "hands.py").write_text(AGENTS)
    robot = f"{{mass = [{MASS}, {MASS}], damping = {DAMPING}}}"
    (folder / "study.toml").write_text(
        f"""
name = "let go"
robot1 = {robot}
robot2 = {robot}
agent1 = {{kind = "python", class = "hands:Held", options = {{place = 0.05, until = {HELD}}}}}
agent2 = {{kind = "python", class = "hands:Held", options = {{place = -0.05, until = {HELD}}}}}
{session}
[network]
adversary = {adversary}
[protocol]
unconnected = false
conditions = [{{stiffness = {stiffness!r}, delay = {delay}}}]
trials = 1
duration = {HELD + seconds}
discard = 1.0
record_rate = 1000.0
"""
    )
    rehearsal = ts.rehearse(folder / "study.toml", folder / "out")
    course = rehearsal.position.isel(condition=0, trial=0).sel(axis="x").transpose("time", "robot").values
    course = course[round(HELD * 1000) :]
    return np.asarray(course[np.isfinite(course).all(axis=1)])


def windows(course: NDArray[np.float64], seconds: float) -> NDArray[np.float64]:
    """Return the largest distance from the middle in each window, m."""
    ticks = round(seconds * 1000)
    whole = np.abs(course[: len(course) // ticks * ticks]).max(axis=1)
    return np.asarray(whole.reshape(-1, ticks).max(axis=1))


@pytest.mark.parametrize(("share", "seconds", "times"), [(0.5, 30.0, 19), (0.4, 60.0, 9)])
def test_ref_the_most_harmful_sample_grows_as_documented(
    tmp_path: Path, share: float, seconds: float, times: int
) -> None:
    adversary = '{kind = "most-harmful-sample", memory = 2.0}'
    sizes = windows(let_go(tmp_path / "study", adversary, share * SCALE, seconds), 4.0)
    # docs/networks.md gives whole numbers
    assert sizes.max() / sizes[0] == pytest.approx(times, abs=0.6)


def test_law_at_a_quarter_of_b2_over_m_nobody_leaves_the_place_where_it_was_let_go(tmp_path: Path) -> None:
    for n, adversary in enumerate(
        [
            '{kind = "oldest-sample", memory = 2.0}',
            '{kind = "most-harmful-sample", memory = 2.0}',
            '{kind = "stretch-timed", longest = 2.0}',
        ]
    ):
        course = np.abs(let_go(tmp_path / str(n), adversary, 0.25 * SCALE, 8.0))
        # positions are recorded to about 1 nm
        assert course.max() <= course[0].max() + 2e-9, adversary


def test_ref_a_stretch_timed_network_makes_swings_grow_by_the_closed_form(tmp_path: Path) -> None:
    k = 0.5 * SCALE
    turning = math.sqrt(4 * MASS * k - DAMPING**2)
    longest = 2 * MASS * math.pi / turning + 0.1
    course = let_go(tmp_path / "both", f'{{kind = "stretch-timed", longest = {longest}}}', k, 30.0)[:, 0]
    step = np.diff(course)
    turns = np.abs(course[1:-1][step[:-1] * step[1:] < 0.0])
    # the Rust test of the same has the same tolerance: ticks of 1 ms
    assert turns[-1] / turns[-2] - 1.0 == pytest.approx(2 * math.exp(-math.pi * DAMPING / turning), rel=0.05)


def test_law_an_adversary_on_one_way_harms_less_than_on_both(tmp_path: Path) -> None:
    adversary = '{kind = "oldest-sample", memory = 2.0}'
    none, one, both = (
        windows(let_go(tmp_path / str(n), each, 0.7 * SCALE, 40.0), 4.0)
        for n, each in enumerate(
            ('{forward = {kind = "stretch-timed", longest = 0.0}}', f"{{backward = {adversary}}}", adversary)
        )
    )
    # a constant delay of 2 s on both ways is unstable there; half the round trip is not
    assert none[-1] < 1e-6
    assert both[9] > 1.2 * both[4]
    assert one[9] < both[9]


@pytest.mark.parametrize("stiffness", [142.0, 2000.0])
@pytest.mark.parametrize("adversary", EACH, ids=lambda each: str(each["kind"]))
def test_law_the_guard_stays_bounded_and_comes_to_rest(
    tmp_path: Path, adversary: dict[str, str | float], stiffness: float
) -> None:
    written = (
        "{"
        + ", ".join(f"{key} = {value if key != 'kind' else repr(value)}" for key, value in adversary.items())
        + "}"
    )
    guarded = let_go(
        tmp_path / "guard", written, stiffness, 14.0, delay=0.05, session='session = {strategy = "guard"}'
    )
    assert len(guarded) == 14_001
    assert np.abs(guarded).max() < 0.5
    assert np.abs(np.diff(guarded[-1000:], axis=0)).max() * 1000 < 1e-3  # m/s
    bare = let_go(tmp_path / "bare", written, stiffness, 14.0, delay=0.05)
    is_lost = len(bare) < 14_001  # a handle was more than 10 m away
    assert is_lost or np.abs(np.diff(bare[-1000:], axis=0)).max() * 1000 > 0.1


def test_law_an_adversary_is_read_written_and_given_to_python() -> None:
    study = ts.Study.paper()
    assert study.adversaries == (None, None)
    for keys in EACH:
        adversary = ts.Adversary(**keys)
        assert adversary.to_dict() == keys
        assert adversary == ts.Adversary(**keys)
        assert hash(adversary) == hash(ts.Adversary(**keys))
        assert pickle.loads(pickle.dumps(adversary)) == adversary
        assert eval(repr(adversary), {"Adversary": ts.Adversary}) == adversary
        assert {key: getattr(adversary, key) for key in keys} == keys
        for given, expected in (
            (keys, (adversary, adversary)),
            (adversary, (adversary, adversary)),
            ({"backward": adversary}, (None, adversary)),
        ):
            changed = study.replace(network={"adversary": given})
            assert changed.adversaries == expected
            assert ts.Study.from_toml(changed.to_toml()) == changed
            assert changed.replace(network={"adversary": None}) == study
    assert ts.Adversary(kind="stretch-timed", longest=0.5).memory is None
    refused_keys: list[tuple[dict[str, object], str]] = [
        ({}, "adversary.kind"),
        ({"kind": "worst"}, "adversary.kind"),
        ({"kind": "oldest-sample"}, "adversary.memory"),
        ({"kind": "oldest-sample", "memory": 1.0, "longest": 1.0}, "adversary.longest"),
        ({"kind": "oldest-sample", "memory": -1.0}, "adversary.memory"),
    ]
    for wrong, field in refused_keys:
        with pytest.raises(ts.InvalidInput) as refused:
            ts.Adversary(**wrong)
        assert refused.value.field == field


def test_law_no_verdict_is_about_an_adversary(tmp_path: Path) -> None:
    robots = "robot1 = {mass = [0.8, 1.0], damping = 7.7}\nrobot2 = {mass = [0.8, 1.0], damping = 7.7}\n"
    plain = ts.Study.from_toml(f"{robots}coupling.stiffness = 40\nnetwork.delay = 0.05\n")
    assert ts.decide(plain).status == "stable"
    study = plain.replace(network={"adversary": {"forward": EACH[0]}})
    assert ts.decide(study).status == "not proven"
    # what holds on any network holds behind it, unless the partner lies about its motion
    soft = study.replace(coupling={"stiffness": 10.0})
    assert ts.decide(soft).status == "stable"
    for keys in EACH:
        expected = "not proven" if keys["kind"] == "lying-peer" else "stable"
        assert ts.decide(soft.replace(network={"adversary": keys})).status == expected
    file = tmp_path / "study.toml"
    file.write_text(study.to_toml())
    run = CliRunner().invoke(app, ["decide", str(file), "--check"])
    assert run.exit_code == 1
    assert "adversary" in run.output
    run = CliRunner().invoke(
        app, ["simulate", str(file), "--duration", "0.1", "--out", str(tmp_path / "a.csv")]
    )
    assert run.exit_code == 0
    assert "Not simulated, since the delay is constant here: an adversary." in " ".join(run.output.split())


def test_law_a_comparison_proves_nothing_behind_an_adversary(tmp_path: Path) -> None:
    # at 40 N/m over 50 ms the spring is stable; the ages that the adversary's stamps claim are those of 50 ms
    study = ts.Study.from_toml(
        """
robot1 = {mass = [0.8, 1.0], damping = 7.7}
robot2 = {mass = [0.8, 1.0], damping = 7.7}
[protocol]
unconnected = false
conditions = [{stiffness = 40.0, delay = 0.05}]
trials = 1
duration = 4.0
discard = 1.0
[comparison]
architectures = ["spring", "guard"]
networks = [{name = "plain"}, {name = "attacked", adversary = {kind = "oldest-sample", memory = 0.2}}]
"""
    )
    comparison = ts.compare(study, tmp_path / "out")
    verdicts = comparison.dataset.verdict.isel(condition=0)
    assert (verdicts.sel(network="plain") == "stable").all()
    assert (verdicts.sel(network="attacked") == "not proven").all()
    ages = comparison.dataset.isel(condition=0).sel(network="attacked")
    assert float(ages.age_high.max()) < 0.052
    assert ages.within_age_range.isnull().all()
    # safe, be it worse than no partner
    chosen = comparison.recommendation.candidate
    assert chosen is not None
    assert (chosen.strategy, chosen.grounds) == ("guard", "any network")
    spring = next(each for each in comparison.recommendation.alternatives if each.architecture == "spring")
    assert spring.candidate is None
    assert [each.objection for each in spring.rejections] == ["not proven"]


def test_law_a_recording_behind_an_adversary_proves_nothing_either(tmp_path: Path) -> None:
    # the recording has 20 ms, and so the stamps claim 50 ms; the oldest sample is 0.2 s older
    (tmp_path / "ping.csv").write_text("time_s,delay_ms\n0,20\n1,20\n")
    (tmp_path / "study.toml").write_text(
        """
robot1 = {mass = [0.8, 1.0], damping = 7.7}
robot2 = {mass = [0.8, 1.0], damping = 7.7}
[protocol]
unconnected = false
conditions = [{stiffness = 40.0, delay = 0.05}]
trials = 1
duration = 3.0
discard = 1.0
[comparison]
architectures = ["spring"]
networks = [
    {name = "recorded", trace = "ping.csv"},
    {name = "attacked", trace = "ping.csv", adversary = {kind = "oldest-sample", memory = 0.2}},
    {name = "withheld", trace = "ping.csv", adversary = {kind = "stretch-timed", longest = 0.2}},
]
"""
    )
    comparison = ts.compare(tmp_path / "study.toml", tmp_path / "out")
    verdicts = comparison.dataset.verdict.isel(condition=0, architecture=0)
    assert verdicts.values.tolist() == ["stable", "not proven", "not proven"]
    assert comparison.recommended is None
