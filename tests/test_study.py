"""The study of the paper, and of other robots: its numbers, its files, and what it refuses."""

import json
import math
import pickle
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import telespring as ts
from paper_study import HELD
from telespring.paper import PARTS, STEPS, Analysis, analyse, write
from telespring.paper.misprints import held_partner_growth
from telespring.paper.sections.summary.allowed import summarise
from telespring.rehearsal import run_protocol

# An unequal pair with one axis and an arm on one side, as far from the H-MANs as the file allows.
OTHER = """
name = "One axis <&>"
robot1 = {mass = 1.2, damping = 6.0, axes = ["lift"]}
robot2 = {mass = 0.7, damping = 9.0, axes = ["lift"]}
operator2 = {mass = 0.5, damping = 1.0, stiffness = 40.0}
coupling.stiffness = 30.0
network.delay = {forward = 0.05, backward = 0.07}
"""


def sampled_at_1_khz() -> ts.Study:
    return ts.Study.from_toml(
        ts.Study.paper().to_toml().replace("sample_period = 0.0", "sample_period = 0.001")
    )


#: What the page begins with, and the experiment.
EXPERIMENT = [section for section in PARTS if section.name in ("summary", "experiment")]

#: All but what is the same for every study.
OWN = [section for section in PARTS if section.name not in ("model", "examples", "misprints")]


def leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, dict):
        for each in value.values():
            yield from leaves(each)
    elif isinstance(value, list):
        for each in value:
            yield from leaves(each)
    else:
        yield value


def test_ref_table_iii_and_what_follows(analysis: Analysis) -> None:
    """Du, Kulkarni, Kager and Campolo, Table III; unrounded values from their Eqs. 5 and 6."""
    table = analysis.numbers["table3"]
    # 1e-8: the eight digits given; K of two robots alike is B²/(2M), Δ at 2K is πM/(2B)
    assert table["K"]["ours"] == pytest.approx(7.7257**2 / (2 * 0.8334), rel=1e-10)
    assert table["Delta"]["ours"] == pytest.approx(math.pi * 0.8334 / (2 * 7.7257), rel=1e-8)
    assert table["K_xy"]["ours"] == pytest.approx(35.615988, rel=1e-8)
    assert table["Delta_xy"]["ours"] == pytest.approx(0.16718632424, rel=1e-8)
    assert table["K_xy"]["axis"] == table["Delta_xy"]["axis"] == "x"
    assert round(table["K"]["ours"]) == table["K"]["printed"]
    assert round(1e3 * table["Delta"]["ours"]) == round(1e3 * table["Delta"]["printed"])


def test_ref_figure_3_only_panel_i_is_unstable(analysis: Analysis) -> None:
    """Section III: "only Fig. 3(i) exhibits system instability", 3(h) is marginal."""
    verdicts = {each["panel"]: each["verdict"] for each in analysis.numbers["nyquist"]["panels"]}
    assert verdicts == {**dict.fromkeys("abcdefg", "stable"), "h": "marginal", "i": "unstable"}
    turns = {each["panel"]: each["encirclements"] for each in analysis.numbers["nyquist"]["panels"]}
    assert turns == {**dict.fromkeys("abcdefg", 0), "h": None, "i": 2}


def test_ref_figure_5_captions(analysis: Analysis) -> None:
    """Fig. 5 and its caption, with (j) corrected: y is still stable there."""
    found = {
        (each["panel"], each["axis"]): each["verdict"] for each in analysis.numbers["responses"]["panels"]
    }
    for panel in "abcdefg":
        assert found[panel, "x"] == found[panel, "y"] == "stable"
    assert (found["h", "x"], found["h", "y"]) == ("marginal", "stable")
    assert found["i", "x"] == found["i", "y"] == "unstable"
    assert (found["j", "x"], found["j", "y"]) == ("unstable", "stable")


def test_law_verdict_has_the_sign_of_the_rightmost_root(analysis: Analysis) -> None:
    rows = [*analysis.numbers["responses"]["panels"], *analysis.numbers["nyquist"]["panels"]]
    for row in rows:
        if row["verdict"] == "marginal":
            # the root moves by its speed (some 1/s²) times the rounding of the delay
            assert abs(row["spectral_abscissa"]) < 1e-7
        else:
            assert (row["spectral_abscissa"] < 0) == (row["verdict"] == "stable")


def test_law_robots_that_settle_rest_one_over_k_apart() -> None:
    study = ts.Study.paper()
    for stiffness in (18.0, 36.0):
        found = ts.simulate(study.dyad, stiffness, 0.084, [[1.0, 1.0], [-1.0, -1.0]], 20.0, rate=50.0)
        apart = np.asarray(found["position"])[-1, 0] - np.asarray(found["position"])[-1, 1]
        # after 20 s the slowest motion (some 2 1/s) has decayed by e^-40
        assert apart == pytest.approx([1 / stiffness] * 2, rel=1e-6)


def test_law_more_delay_never_allows_more(analysis: Analysis) -> None:
    rows = analysis.numbers["summary"]["rows"]
    assert [row["delay"] for row in rows] == [0.01, 0.02, 0.05, 0.1, 0.167, 0.2, 0.334]
    for key in ("constant_delay", "bounded_varying_delay"):
        allowed = [row[key]["stiffness"] for row in rows]
        assert allowed == sorted(allowed, reverse=True)
    for row in rows:
        assert row["constant_delay"]["stiffness"] >= row["any_constant_delay"]["stiffness"]
        assert row["constant_delay"]["stiffness"] >= row["bounded_varying_delay"]["stiffness"]


def test_law_the_summary_is_what_the_verdicts_say_of_the_whole_network(held: Analysis) -> None:
    study = ts.Study.from_toml(HELD)
    network = study.network
    assert held.numbers["study"]["operator_ranges"] is True
    for row in held.numbers["summary"]["rows"]:
        judged = ts.verdicts(
            study.dyad,
            study.stiffness,
            row["delay"],
            jitter=network.jitter,
            max_gap=network.max_gap,
            sample_period=network.sample_period,
            computing_time=network.computing_time,
            operator_range=study.operator_ranges,
        )
        bears = min(axis.sampled_stiffness_bound or math.nan for axis in judged.axes)
        for tier in judged.tiers:
            entry = row[tier.tier.replace(" ", "_")]
            bound = tier.stiffness_bound
            if bound is None:
                # A computing time, and hands that may be free.
                assert (tier.tier, tier.unavailable) == ("any network", "not proven over the range")
                assert entry["stiffness"] is None
                assert not entry["unbounded"]
                continue
            if tier.tier in {"constant delay", "any constant delay"}:
                bound = min(bound, bears)
            assert entry["stiffness"] == bound
            assert not entry["unbounded"]
        # the delay, the jitter, the longest gap, and for the age the sample period and computing time
        assert row["constant_delay_in_use"] == pytest.approx(row["delay"] + 0.014, rel=1e-12)
        assert row["oldest_sample"] == pytest.approx(row["delay"] + 0.0165, rel=1e-12)


def test_law_each_part_of_the_network_lowers_what_the_summary_allows() -> None:
    def allowed(old: str, new: str, key: str) -> float:
        # With a computing time nothing is proven on any network for hands that may be free.
        study = HELD.replace("computing_time = 0.0005", "") if key == "any_network" else HELD
        text = study.replace(old, new)
        assert (text != study) == (old != new)
        return float(summarise(ts.Study.from_toml(text))["rows"][3][key]["stiffness"])

    for old, new, key in (
        ("jitter = 0.01", "jitter = 0.0", "bounded_varying_delay"),
        ("jitter = 0.01", "jitter = 0.0", "constant_delay"),
        ("max_gap = 0.004", "max_gap = 0.0", "bounded_varying_delay"),
        ("max_gap = 0.004", "max_gap = 0.0", "constant_delay"),
        ("sample_period = 0.002", "sample_period = 0.001", "bounded_varying_delay"),
        ("sample_period = 0.002", "sample_period = 0.001", "any_network"),
        ("computing_time = 0.0005", "computing_time = 0.0", "bounded_varying_delay"),
        ("{min = 0.0, max = 300.0}", "300.0", "constant_delay"),
    ):
        assert allowed(old, new, key) > allowed(old, old, key), (old, key)


def test_law_sampling_lowers_what_a_constant_delay_allows() -> None:
    """H-MANs at 1 kHz and 100 ms: the rule allows 100.92 N/m, the sampled dyad 99.71."""
    study = sampled_at_1_khz()
    [row] = [each for each in summarise(study)["rows"] if each["delay"] == 0.1]
    entry = row["constant_delay"]
    assert entry["stiffness"] == pytest.approx(99.71, abs=5e-3)  # half of the last digit
    assert (entry["axis"], entry["limited_by"]) == ("x", "sampling")
    judged = ts.verdicts(study.dyad, 71.2, 0.1, sample_period=0.001)
    assert judged.stiffness_allowed is not None
    assert judged.stiffness_allowed.stiffness == entry["stiffness"]
    # just above it the sampled dyad is unstable, just below it is not
    for factor, stable in ((1 - 1e-6, True), (1 + 1e-6, False)):
        found = ts.verdicts(study.dyad, factor * entry["stiffness"], 0.1, sample_period=0.001)
        assert found.sampled_stable is stable
    # the rule for any constant delay asks for less than that anyway
    assert row["any_constant_delay"]["limited_by"] == "rule"


def test_law_every_misprint_carries_numbers_that_are_finite(analysis: Analysis) -> None:
    found = analysis.numbers["misprints"]
    assert len(found) == len({each["key"] for each in found}) >= 14
    for each in found:
        assert each["evidence"], each["key"]
        assert f'id="misprint-{each["key"]}"' in analysis.html
    assert all(math.isfinite(leaf) for leaf in leaves(found) if isinstance(leaf, float))


def test_law_same_study_same_bytes(held: Analysis) -> None:
    # With the experiment and the identification; `calibrate` has such a test of its own.
    again = analyse(ts.Study.from_toml(HELD))
    assert {"table1", "identification"} <= set(held.numbers)
    assert again.html == held.html
    assert json.dumps(again.numbers) == json.dumps(held.numbers)


def test_law_the_trials_of_a_study_are_kept_and_gone_on_with(tmp_path: Path) -> None:
    def table1(text: str) -> Any:
        found = analyse(ts.Study.from_toml(text), rehearsal=tmp_path, parts=EXPERIMENT)
        return found.numbers["table1"]

    def stopped(done: int, _total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    whole = analyse(ts.Study.from_toml(HELD), parts=EXPERIMENT).numbers["table1"]
    study = ts.Study.from_toml(HELD)
    with pytest.raises(KeyboardInterrupt):
        run_protocol(study, tmp_path, stopped)
    assert run_protocol(study, tmp_path, replace_others=True).resumed >= 2
    written = (tmp_path / "rehearsal.nc").stat().st_mtime_ns
    assert table1(HELD) == whole
    assert (tmp_path / "rehearsal.nc").stat().st_mtime_ns == written
    # the folder is the study's own: another study's trials make room
    other = HELD.replace("trials = 3", "trials = 2")
    assert [row["trials"] for row in table1(other)] == [2, 2]
    with pytest.raises(KeyboardInterrupt):
        run_protocol(ts.Study.from_toml(HELD), tmp_path, stopped, fresh=True)
    assert [row["trials"] for row in table1(other)] == [2, 2]
    assert sorted(each.name for each in tmp_path.iterdir()) == [".rehearsal.lock", "rehearsal.nc"]
    analyse(ts.Study.from_toml(OTHER), rehearsal=tmp_path, parts=EXPERIMENT)
    assert [each.name for each in tmp_path.iterdir()] == [".rehearsal.lock"]


def test_law_a_part_alone_finds_what_it_finds_among_all(held: Analysis) -> None:
    found = analyse(ts.Study.from_toml(HELD), parts=EXPERIMENT)
    assert set(found.numbers) == {"schema", "study", "summary", "table1", "experiment"}
    assert all(found.numbers[key] == held.numbers[key] for key in found.numbers)


def test_law_a_study_of_other_robots_is_told_as_well(tmp_path: Path) -> None:
    file = tmp_path / "other.toml"
    file.write_text(OTHER, encoding="utf-8")
    steps: list[str] = []
    found = analyse(ts.Study.read(file), steps.append)
    assert tuple(steps) == STEPS
    report, numbers = write(found, tmp_path / "out")
    assert sorted(each.name for each in (tmp_path / "out").iterdir()) == ["report.html", "study.json"]
    assert json.loads(numbers.read_text(encoding="utf-8"))["study"]["axes"][0]["axis"] == "lift"
    assert "One axis &lt;&amp;&gt;" in report.read_text(encoding="utf-8")
    assert found.numbers["stability_map"]["conditions"] == []


def test_law_robots_without_damping_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "undamped.toml"
    file.write_text(OTHER.replace("damping = 6.0", "damping = 0.0"), encoding="utf-8")
    with pytest.raises(ts.InvalidInput, match=r"robot1\.damping\[0\]"):
        analyse(ts.Study.read(file))


@pytest.mark.parametrize(
    ("mass", "damping", "field"),
    [
        (20.0, 0.5, r"robot1\.damping\[0\].*62\.8"),
        (1.0, 1e6, r"robot1\.damping\[0\]"),
        (1.0, 4e5, r"robot1\.damping\[0\]"),
        (1.0, 1e4, r"robot1\.damping\[0\]"),
        (0.01, 0.001, r"robot1\.damping\[0\]"),
        (5000.0, 500.0, r"robot1\.mass\[0\]"),
        (1e-4, 1.0, r"robot1\.mass\[0\]"),
    ],
)
def test_law_what_the_study_cannot_draw_is_refused_by_what_was_written(
    mass: float, damping: float, field: str
) -> None:
    robot = f"{{mass = {mass}, damping = {damping}}}"
    text = (
        f"allow_unusual = true\nrobot1 = {robot}\nrobot2 = {robot}\n"
        "coupling.stiffness = 1.0\nnetwork.delay = 0.05\n"
    )
    with pytest.raises(ts.InvalidInput, match=field) as refused:
        analyse(ts.Study.from_toml(text))
    assert float(refused.value.value) in (mass, damping)
    assert "telespring decide" in refused.value.remedy


@pytest.mark.parametrize(
    ("mass", "damping"),
    [(20.0, 0.7), (2400.0, 500.0), (0.0003, 0.5), (1.0, 2000.0), (0.01, 0.002)],
)
def test_law_robots_within_the_ranges_are_drawn(mass: float, damping: float) -> None:
    robot = f"{{mass = {mass}, damping = {damping}}}"
    text = (
        f"allow_unusual = true\nrobot1 = {robot}\nrobot2 = {robot}\n"
        "coupling.stiffness = 1.0\nnetwork.delay = 0.05\n"
    )
    found = analyse(ts.Study.from_toml(text), parts=OWN)
    json.dumps(found.numbers, allow_nan=False)
    assert found.numbers["table3"]["Delta"]["ours"] == pytest.approx(math.pi * mass / (2 * damping), rel=1e-8)


@pytest.mark.parametrize("room", [20_000, 120_000, 160_000])
def test_law_a_full_disk_leaves_neither_file(analysis: Analysis, tmp_path: Path, room: int) -> None:
    """A limit on the file size simulates a full disk: room for one of the files, or for neither."""
    program = (
        "import resource, signal, sys, pickle\n"
        "from telespring.paper import write\n"
        "analysis = pickle.load(open(sys.argv[1], 'rb'))\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room}))\n"
        "try:\n"
        "    write(analysis, sys.argv[2])\n"
        "except OSError:\n"
        "    sys.exit(7)\n"
    )
    stored = tmp_path / "analysis.pickle"
    stored.write_bytes(pickle.dumps(analysis))
    out = tmp_path / "out"
    done = subprocess.run(
        [sys.executable, "-c", program, str(stored), str(out)], capture_output=True, text=True, check=False
    )
    sizes = (len(analysis.html.encode()), len(json.dumps(analysis.numbers, indent=1, ensure_ascii=False)))
    assert max(sizes) > room
    assert done.returncode == 7, done.stderr
    assert list(out.iterdir()) == []


def test_cross_growth_under_a_held_partner_against_stepping_in_time() -> None:
    """Closed form of the held partner's growth against a Runge-Kutta run of both robots' equations."""
    mass, damping, stiffness = 0.8334, 7.7257, 35.0
    hold, growth = held_partner_growth(mass, damping, stiffness)
    steps = 4000
    h = hold / steps
    x, v = np.array([1.0, -1.0]), np.zeros(2)
    distances = []
    for _ in range(5):
        partner = x[::-1].copy()

        def slope(x: Any, v: Any, partner: Any = partner) -> Any:
            return v, (stiffness * (partner - x) - damping * v) / mass

        for _ in range(steps):
            k1 = slope(x, v)
            k2 = slope(x + h / 2 * k1[0], v + h / 2 * k1[1])
            k3 = slope(x + h / 2 * k2[0], v + h / 2 * k2[1])
            k4 = slope(x + h * k3[0], v + h * k3[1])
            x = x + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
            v = v + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        distances.append(abs(x[0] - x[1]))
    # 1e-9: the error of the Runge-Kutta run, (h/hold)^4 and rounding over 20,000 steps
    assert np.array(distances[1:]) / distances[:-1] == pytest.approx([growth] * 4, rel=1e-9)
    assert growth > 1.0


def test_law_every_top_key_of_study_json_is_documented(analysis: Analysis, root: Path) -> None:
    text = (root / "docs" / "study-json.md").read_text(encoding="utf-8")
    text = text[: text.index("# `telespring decide")]
    documented = {
        name for row in re.findall(r"^\| (`.*?) \|", text, re.M) for name in re.findall(r"`(\w+)", row)
    }
    assert set(analysis.numbers) <= documented
