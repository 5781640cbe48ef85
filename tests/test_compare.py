"""A comparison: numbers of plain rehearsals side by side, and a folder that is never torn."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import telespring as ts
from resuming import interrupted_after, killed_at, killed_until_it_comes_through, left_in, started, written
from telespring import cli
from telespring.analysis import measure
from telespring.comparison.schedule import schedule_comparison
from telespring.comparison.store import UNCONNECTED_FOLDER
from telespring.rehearsal.store import LOCK_FILE

# Short trials of the paper's robots. At 142.5 N/m over 84 ms the bare spring is unstable.
STUDY = """
name = "{name}"
robot1 = {{mass = [0.8334, 1.0649], damping = [7.7257, 10.1168]}}
robot2 = {{mass = [0.7776, 1.3407], damping = [7.4208, 9.3496]}}
{more}
[protocol]
stiffness = [71.2, 142.5]
delay = [0.0, 0.084]
trials = {trials}
duration = {duration}
discard = 1.0
seed = 3
"""
COMPARISON = """
[comparison]
architectures = [
    "spring", {strategy = "guard", predictor = "shared-target"}, {strategy = "guard", playout = "adaptive"},
]
networks = [{name = "quiet"}, {name = "5G, urban", delay = 0.05, jitter = 0.004, loss = 0.01}]
"""
RESULTS = ["compare.json", "comparison.nc", "recommended.toml"]


def study_text(name: str = "short", more: str = COMPARISON, trials: int = 2, duration: float = 5.0) -> str:
    return STUDY.format(name=name, more=more, trials=trials, duration=duration)


def command(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"}).invoke(
        cli.app, ["compare", *map(str, arguments)]
    )


@pytest.fixture(scope="module")
def short() -> ts.Study:
    return ts.Study.from_toml(study_text())


@pytest.fixture(scope="module")
def tiny(short: ts.Study) -> ts.Study:
    """Return a study for what needs many comparisons: one network, two architectures."""
    architectures = ["spring", {"strategy": "guard", "predictor": "shared-target"}]
    return short.replace(comparison={"architectures": architectures, "networks": None})


@pytest.fixture(scope="module")
def tiny_result(tiny: ts.Study, tmp_path_factory: pytest.TempPathFactory) -> ts.Comparison:
    return ts.compare(tiny, tmp_path_factory.mktemp("tiny"))


@pytest.fixture(scope="module")
def undisturbed(short: ts.Study, tmp_path_factory: pytest.TempPathFactory) -> ts.Comparison:
    return ts.compare(short, tmp_path_factory.mktemp("undisturbed"))


def test_law_networks_with_other_delays_stand_beside_each_other(undisturbed: ts.Comparison) -> None:
    data = undisturbed.dataset
    assert data.architecture.values.tolist() == ["spring", "guard + shared-target", "guard, adaptive"]
    assert data.strategy.values.tolist() == ["spring", "guard", "guard"]
    assert data.predictor.values.tolist() == ["hold", "shared-target", "hold"]
    assert data.playout.values.tolist() == ["fixed", "fixed", "adaptive"]
    assert data.network.values.tolist() == ["quiet", "5G, urban"]
    pairs = list(zip(data.stiffness.values.tolist(), data.delay.values.tolist(), strict=True))
    assert pairs == [(k, delay) for k in (71.2, 142.5) for delay in (0.0, 0.05, 0.084)]
    assert data.condition.values[1] == "CM-71-50"
    assert data.is_rehearsed.values.tolist() == [[True, False, True] * 2, [False, True, False] * 2]
    missing = ~data.is_rehearsed
    for name in ("tracking_error", "force_fidelity", "age_mean", "limited_share", "coupling_energy"):
        assert data[name].where(missing).isnull().all()
        assert data[name].where(data.is_rehearsed).notnull().any()
    assert (data.status.where(missing, -1) == -1).all()
    assert (data.verdict.where(missing, "") == "").all()
    assert not data.diverged.where(missing, False).any()
    assert len(undisturbed.conditions()) == 3 * 6


@pytest.mark.parametrize("architecture", [0, 1, 2])
def test_cross_the_numbers_are_those_of_plain_rehearsals(
    architecture: int, short: ts.Study, undisturbed: ts.Comparison, tmp_path: Path
) -> None:
    session = short.comparison.architectures[architecture].settings()
    networks: list[dict[str, object]] = [{}, {"jitter": 0.004, "loss": 0.01}]
    for n, network in enumerate(networks):
        protocol: dict[str, object] = {"unconnected": False}
        if n:
            protocol |= {"delay": [0.05]}
        alone = short.replace(comparison=None, session=session, network=network or None, protocol=protocol)
        rehearsal = ts.rehearse(alone, tmp_path / str(n))
        here = undisturbed.dataset.isel(architecture=architecture, network=n)
        here = here.isel(condition=np.flatnonzero(here.is_rehearsed.values))
        assert here.condition.values.tolist() == rehearsal.condition.values.tolist()
        measured = measure(rehearsal)
        assert here.tracking_error.values == pytest.approx(measured.tracking_error.values, rel=1e-12)
        for name in ("limited_share", "withheld_share", "given_out", "energy_sent", "held_share", "lost"):
            assert np.array_equal(here[name].values, rehearsal[name].values, equal_nan=True)
        assert np.array_equal(here.coupling_energy.values, rehearsal.coupling_energy.values)
        assert np.array_equal(here.age_low.values, rehearsal.age_low.min("trial").values)
        assert np.array_equal(here.age_high.values, rehearsal.age_high.max("trial").values)
        first = rehearsal.isel(trial=0)
        assert here.position.values == pytest.approx(first.position.values, abs=1e-7)
        assert here.coupling_force.values == pytest.approx(first.coupling_force.values, abs=1e-4)
        if "account" in rehearsal:
            assert here.account.values == pytest.approx(first.account.values, abs=1e-6)
        else:
            assert np.isnan(here.account.values).all()
        late = rehearsal.isel(time=rehearsal.time.values >= 1.0)
        stretch = late.position.sel(robot=[2, 1]).values - late.position.values
        intended = late.stiffness.values[:, None, None, None, None] * stretch
        missed = ((intended - late.coupling_force.values) ** 2).sum(axis=(2, 4))
        fidelity = 1.0 - missed / (intended**2).sum(axis=(2, 4))
        assert here.force_fidelity.values == pytest.approx(fidelity, rel=1e-9)


def test_cross_the_unconnected_trials_are_those_of_a_rehearsal(
    short: ts.Study, undisturbed: ts.Comparison, tmp_path: Path
) -> None:
    alone = short.replace(comparison=None, protocol={"conditions": []})
    rehearsal = ts.rehearse(alone, tmp_path)
    measured = measure(rehearsal).tracking_error.values[0]
    assert undisturbed.dataset.tracking_error_unconnected.values == pytest.approx(measured, rel=1e-12)


def test_law_the_verdict_is_what_decide_answers(short: ts.Study, undisturbed: ts.Comparison) -> None:
    one = undisturbed.dataset.sel(architecture="spring", network="quiet")
    for k, delay in ((71.2, 0.0), (71.2, 0.084), (142.5, 0.0), (142.5, 0.084)):
        here = one.isel(condition=np.flatnonzero((one.stiffness == k) & (one.delay == delay)))
        assert here.verdict.item() == ts.decide(short, k, delay).status
    assert one.verdict.sel(condition="CM-142-84").item() == "unstable"


def test_law_without_delay_and_loss_the_force_is_the_intended_one(undisturbed: ts.Comparison) -> None:
    here = undisturbed.dataset.sel(network="quiet", architecture="spring").isel(condition=[0, 3])
    assert here.delay.values.tolist() == [0.0, 0.0]
    assert here.force_fidelity.values == pytest.approx(1.0, abs=2e-3)
    felt = here.force_gain.where(here.force_coherence > 0.9)
    assert float(abs(felt - 1.0).max()) < 0.05


def test_law_the_guard_takes_the_cost_of_delay_away(undisturbed: ts.Comparison) -> None:
    best = undisturbed.recommended
    assert best is not None
    assert best.architecture == "guard + shared-target"
    assert best.grounds == "any network"


def test_law_the_recommended_study_can_be_rehearsed(undisturbed: ts.Comparison, tmp_path: Path) -> None:
    file = undisturbed.folder / "recommended.toml"
    study = ts.Study.read(file)
    best = undisturbed.recommended
    assert best is not None
    assert study.session.label == best.architecture
    assert study.stiffness == best.stiffness
    assert study.comparison.architectures == ts.Study.paper().comparison.architectures
    trials = ts.rehearse(file, tmp_path)
    assert set(trials.stiffness.values[1:].tolist()) == {best.stiffness}
    assert (trials.status == 0).all()


def test_law_compare_json_is_what_the_object_says(undisturbed: ts.Comparison) -> None:
    content = json.loads((undisturbed.folder / "compare.json").read_text(encoding="utf-8"))
    assert content == json.loads(json.dumps(undisturbed.to_dict()))
    assert content["conditions"] == json.loads(json.dumps(undisturbed.conditions()))
    needed = {"strategy", "predictor", "network", "stiffness", "delay", "te1_mean", "te2_mean", "diverged"}
    assert needed | {"limited_share", "force_fidelity"} <= set(content["conditions"][0])


def test_law_the_document_names_all_that_is_in_the_dataset(root: Path, undisturbed: ts.Comparison) -> None:
    document = (root / "docs" / "compare.md").read_text(encoding="utf-8")
    for name in undisturbed.dataset.variables:
        assert f"`{name}`" in document
    for name in undisturbed.conditions()[0]:
        assert f"`{name}`" in document
    for name in undisturbed.dataset.attrs:
        assert f"`{name}`" in document


def test_law_a_finished_folder_holds_the_results_only(undisturbed: ts.Comparison) -> None:
    assert left_in(undisturbed.folder) == RESULTS


def test_law_what_is_finished_is_not_run_again(tiny: ts.Study, tiny_result: ts.Comparison) -> None:
    told: list[tuple[int, int]] = []
    again = ts.compare(tiny, tiny_result.folder, progress=lambda *told_now: told.append(told_now))
    assert told == []
    assert again.dataset.identical(tiny_result.dataset)
    assert again.recommendation == tiny_result.recommendation


def test_law_progress_is_told_over_all_trials(tiny: ts.Study, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    ts.compare(tiny, tmp_path, workers=3, progress=lambda *told_now: told.append(told_now))
    total = 2 + 2 * 2 * 4
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert {done for done, _ in told} == set(range(total + 1))
    assert {trials for _, trials in told} == {total}


@pytest.mark.parametrize("trials", [1, 7, 18])
def test_law_interrupted_it_goes_on_and_ends_the_same(
    trials: int, tiny: ts.Study, tiny_result: ts.Comparison, tmp_path: Path
) -> None:
    with pytest.raises(KeyboardInterrupt):
        ts.compare(tiny, tmp_path, progress=interrupted_after(trials), workers=1)
    told: list[int] = []
    again = ts.compare(tiny, tmp_path, progress=lambda done, _: told.append(done), workers=2)
    # What was told as finished is kept, but for a trial that was not yet written.
    total = 2 + 2 * 2 * 4
    assert told[-1] == total
    assert sum(done > trials for done in set(told)) == total - trials
    assert len(set(told) - set(range(trials, total + 1))) <= 2
    assert again.dataset.identical(tiny_result.dataset)
    assert left_in(tmp_path) == RESULTS


@pytest.mark.parametrize(
    "place",
    [
        "telespring.comparison.store.write_whole",
        "telespring.comparison.run.measure_connected",
        "telespring.comparison.store.ComparisonStore.write_cell",
        "telespring.comparison.store.remove_rehearsal",
        "telespring.comparison.run.assemble_comparison",
        "telespring.comparison.run.recommended_study",
        "telespring.comparison.run._write_changed",
        "telespring.comparison.store.ComparisonStore.remove_cells",
    ],
)
def test_law_killed_at_a_delicate_moment_it_ends_the_same(
    place: str, tiny: ts.Study, tiny_result: ts.Comparison, tmp_path: Path
) -> None:
    killed_at(place, "compare", tiny.to_toml(), tmp_path)
    assert ts.compare(tiny, tmp_path).dataset.identical(tiny_result.dataset)
    assert left_in(tmp_path) == RESULTS


@pytest.mark.timeout(400)
def test_law_killed_at_any_moment_it_ends_the_same(
    tiny: ts.Study, tiny_result: ts.Comparison, tmp_path: Path
) -> None:
    """SIGKILL after random times until it comes through; each start goes on where the last was."""
    study, out = written(tmp_path, tiny.to_toml()), tmp_path / "out"
    killed_until_it_comes_through(
        lambda: started("compare", study, "--out", out, until=lambda _: out.exists()), out, mean=1.0, seed=5
    )
    assert ts.compare(tiny, out).dataset.identical(tiny_result.dataset)
    assert [name for name in left_in(out) if not name.endswith(".png")] == RESULTS


@pytest.fixture
def begun(tiny: ts.Study, tmp_path: Path) -> Path:
    """Return a folder in which a comparison was interrupted."""
    with pytest.raises(KeyboardInterrupt):
        ts.compare(tiny, tmp_path, progress=interrupted_after(9), workers=1)
    return tmp_path


def test_law_the_folder_of_another_comparison_is_refused_and_left_alone(tiny: ts.Study, begun: Path) -> None:
    before = left_in(begun)
    others = {
        "a comparison of another study, 'short'": tiny.replace(name="mine"),
        "with different contents": tiny.replace(protocol={"seed": 4}),
    }
    for words, other in others.items():
        with pytest.raises(ts.InvalidInput, match=words):
            ts.compare(other, begun)
    with pytest.raises(ts.InvalidInput, match="a comparison that is not quick"):
        ts.compare(tiny, begun, quick=True)
    assert left_in(begun) == before


def test_law_a_finished_comparison_of_another_study_is_refused(
    tiny: ts.Study, tiny_result: ts.Comparison
) -> None:
    with pytest.raises(ts.InvalidInput, match="with different contents"):
        ts.compare(tiny.replace(protocol={"seed": 4}), tiny_result.folder)
    assert left_in(tiny_result.folder) == RESULTS


def test_law_fresh_starts_anew_and_leaves_files_of_others_alone(tiny: ts.Study, begun: Path) -> None:
    mine = begun / UNCONNECTED_FOLDER / "mine.txt"
    mine.write_text("mine")
    (begun / "7-mine").mkdir()
    (begun / "7-mine" / LOCK_FILE).write_text("")
    (begun / "7-mine" / "rehearsal.nc").write_text("mine")
    guarded = {"architectures": [{"strategy": "guard", "predictor": "shared-target"}]}
    other = tiny.replace(name="other", protocol={"trials": 1}, comparison=guarded)
    again = ts.compare(other, begun, fresh=True)
    assert again.name == "other"
    kept = [UNCONNECTED_FOLDER, f"{UNCONNECTED_FOLDER}/mine.txt", "7-mine", "7-mine/rehearsal.nc"]
    assert left_in(begun) == sorted([*kept, *RESULTS])


def test_law_a_file_of_the_datasets_name_that_is_none_is_refused(tiny: ts.Study, tmp_path: Path) -> None:
    (tmp_path / "comparison.nc").write_text("mine")
    with pytest.raises(ts.InvalidInput, match="are not from one"):
        ts.compare(tiny, tmp_path)
    assert (tmp_path / "comparison.nc").read_text() == "mine"


def test_law_a_quick_comparison_is_of_the_spring_and_the_guard(short: ts.Study, tmp_path: Path) -> None:
    quick = ts.compare(short.replace(protocol={"trials": 30, "stiffness": [142.5]}), tmp_path, quick=True)
    assert quick.dataset.architecture.values.tolist() == ["spring", "guard", "guard + shared-target"]
    assert quick.dataset.sizes["trial"] == 4
    assert quick.dataset.network.values.tolist() == ["quiet", "5G, urban"]


def test_law_usual_architectures_without_a_place_for_a_damper_are_left_out_and_named() -> None:
    study = ts.Study.from_toml(study_text(more="[coupling]\nstiffness = 71.2\ndamping = 1.0"))
    schedule = schedule_comparison(study)
    usual = [architecture.label for architecture in ts.Study.paper().comparison.architectures]
    left_out = [each.architecture for each in schedule.left_out]
    assert left_out
    assert "wave-variables" in left_out
    assert sorted([*left_out, *schedule.labels]) == sorted(usual)
    for each in schedule.left_out:
        assert each.field in {"session.strategy", "coupling.damping"}
        assert each.value
        assert each.allowed
        assert "another strategy" in each.remedy


def test_law_an_architecture_that_the_study_names_and_cannot_have_is_refused(tmp_path: Path) -> None:
    # It needs a stiffness that is larger than any.
    more = '[comparison]\narchitectures = ["spring", "two-layer"]'
    study = ts.Study.from_toml(f"allow_unusual = true\n{study_text(more=more)}").replace(
        protocol={"stiffness": [1e7]}
    )
    with pytest.raises(ts.InvalidInput) as refused:
        ts.compare(study, tmp_path / "out")
    assert refused.value.field == "comparison.architectures[1]"
    assert "leave it out" in refused.value.remedy
    assert not (tmp_path / "out").exists()


def test_law_a_comparison_needs_a_spring(short: ts.Study, tmp_path: Path) -> None:
    with pytest.raises(ts.InvalidInput, match="at least one condition with a spring"):
        ts.compare(short.replace(protocol={"conditions": []}), tmp_path)


TRACED = """
[agent2]
kind = "python"
class = "pull:Pull"
[comparison]
architectures = [{strategy = "guard", predictor = "shared-target"}]
networks = [{name = "recorded", trace = "delays.csv", delay = 0.03}]
"""
PULL = """
class Pull:
    def __init__(self, seed):
        pass
    def __call__(self, time, position, velocity, target):
        return 120.0 * (target - position)
"""


@pytest.fixture
def traced(tmp_path: Path) -> Path:
    """Write a study with an agent in Python and a recorded trace, every tenth packet of which is late."""
    study = written(tmp_path / "study", study_text(more=TRACED, duration=3.0))
    (study.parent / "pull.py").write_text(PULL)
    rows = [f"{0.01 * i:.3f},{45.0 if i % 10 == 0 else 22.0 + i % 3}" for i in range(100)]
    (study.parent / "delays.csv").write_text("\n".join(["time_s,delay_ms", *rows]))
    return study


def test_law_traces_and_agents_go_where_the_recommended_study_goes(traced: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    comparison = ts.compare(traced, out)
    assert comparison.dataset.network.values.tolist() == ["recorded"]
    assert comparison.dataset.delay.values.tolist() == [0.03, 0.03]
    # Late packets are held for, so the ages vary.
    high, low = comparison.dataset.age_high, comparison.dataset.age_low
    assert float(high.min()) > 0.03 >= float(low.max()) - 1e-9
    assert ((comparison.dataset.within_age_range >= 0.0) & (comparison.dataset.within_age_range <= 1.0)).all()
    assert left_in(out) == sorted([*RESULTS, "delays.csv", "pull.py"])
    moved = tmp_path / "moved"
    out.rename(moved)
    trials = ts.rehearse(moved / "recommended.toml", tmp_path / "again")
    assert (trials.status == 0).all()
    assert trials.delay.values.tolist()[1:] == [0.03]


def test_law_another_file_of_a_copied_ones_name_is_refused(traced: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "pull.py").write_text("mine")
    with pytest.raises(ts.InvalidInput, match=r"pull\.py of the study is copied there"):
        ts.compare(traced, tmp_path / "out")
    assert left_in(tmp_path / "out") == ["pull.py"]


def test_law_a_trace_that_changed_is_another_comparison(traced: Path, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        ts.compare(traced, tmp_path / "out", progress=interrupted_after(3))
    (traced.parent / "delays.csv").write_text("time_s,delay_ms\n0,20\n0.01,21\n")
    with pytest.raises(ts.InvalidInput, match="another version of a Python file or a recorded trace"):
        ts.compare(traced, tmp_path / "out")


def test_law_the_command_says_what_it_recommends_and_how_to_go_on(tiny: ts.Study, tmp_path: Path) -> None:
    study, out = written(tmp_path, tiny.to_toml()), tmp_path / "out"
    done = command(study, "--out", out, "--workers", "2")
    assert done.exit_code == 0, done.output
    assert "RECOMMENDED: guard + shared target" in done.stdout
    assert f"telespring rehearse {out / 'recommended.toml'}" in "".join(done.stdout.split("\n"))
    figures = sorted(path.name for path in out.glob("*.png"))
    assert figures == ["account.png", "delays.png", "plane.png"]
    refused = command(out / "recommended.toml", "--out", out)
    assert refused.exit_code == 2
    assert "is an input of the command" in " ".join(refused.output.split())


def test_law_ctrl_c_keeps_what_is_finished_and_says_how_to_go_on(
    tiny: ts.Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study, out = written(tmp_path, tiny.to_toml()), tmp_path / "out"

    def interrupt(*_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("telespring.comparison.run.measure_connected", interrupt)
    stopped = command(study, "--out", out)
    assert stopped.exit_code == 130
    assert "10 of 18 trials are kept; run the same command again to resume." in stopped.output
