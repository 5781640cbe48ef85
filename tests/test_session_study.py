"""The sections [session] and [comparison] of a study, and rehearsals of every control architecture."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import telespring as ts
from telespring.cli import app
from telespring.paper.scene import Scene
from telespring.paper.sections.laboratory.section import find_laboratory
from telespring.rehearsal.preflight import LateWarning, preflight_warnings
from telespring.show.screens.questions import session_notes
from telespring.show.screens.rehearsal import preflight_sentence
from telespring.show.strategies import describe_strategy

STRATEGIES = (
    "spring",
    "guard",
    "injected-damping",
    "wave-variables",
    "time-domain-passivity",
    "two-layer",
    "set-position-modulation",
)
PREDICTORS = ("hold", "linear", "kalman", "shared-target")
SETTINGS: dict[str, dict[str, float]] = {
    "guard": {"share": 0.5, "capacity": 0.02, "intake": 0.1},
    "wave-variables": {"impedance": 12.5, "filter": 0.01},
    "time-domain-passivity": {"largest_damping": 50.0},
    "two-layer": {
        "level": 0.1,
        "transfer_rate": 5.0,
        "filling": 200.0,
        "largest_damping": 10.0,
        "saturation": 2.0,
    },
    "set-position-modulation": {"damping": 7.0, "ceiling": 0.1},
}


def brief(**protocol: object) -> ts.Study:
    return ts.Study.paper().replace(protocol={"trials": 2, "duration": 6.0, "discard": 1.0, **protocol})


def run(study: ts.Study, folder: Path) -> xr.Dataset:
    return ts.rehearse(study, folder, workers=2)


def random_settings(random: np.random.Generator) -> dict[str, object]:
    """Any strategy, predictor and play-out, with the usual settings or with others."""
    strategy: object = random.choice(STRATEGIES).item()
    if isinstance(strategy, str) and strategy in SETTINGS and random.random() < 0.5:
        names = [name for name in SETTINGS[strategy] if random.random() < 0.7]
        strategy = {"kind": strategy} | {name: float(random.uniform(0.01, 0.9)) for name in names}
    predictor: object = random.choice(PREDICTORS).item()
    if predictor == "kalman" and random.random() < 0.7:
        model = random.choice(["constant-velocity", "constant-acceleration"]).item()
        noise = {"process": float(random.uniform(0.1, 1e4)), "position": float(random.uniform(1e-6, 1e-3))}
        predictor = {"kind": "kalman", "model": model, **noise}
    playout: object = ["fixed", "adaptive", {"kind": "fixed", "delay": float(random.uniform(0.0, 1.9))}][
        random.integers(3)
    ]
    return {"strategy": strategy, "predictor": predictor, "playout": playout}


@pytest.mark.parametrize("seed", range(40))
def test_law_a_session_reads_back_as_it_is_written(seed: int) -> None:
    random = np.random.default_rng(seed)
    session = ts.Architecture(**random_settings(random))
    study = ts.Study.paper().replace(session=session)
    assert study.session == session
    assert hash(study.session) == hash(session)
    assert ts.Study.from_toml(study.to_toml()) == study
    assert ts.Architecture(**session.settings()) == session
    for rebuilt in (pickle.loads(pickle.dumps(session)), copy.deepcopy(session)):
        assert rebuilt == session
    assert eval(repr(session), vars(ts)) == session
    # a session replaces the whole section, a mapping only what it names
    assert study.replace(session=ts.Architecture()).session == ts.Architecture()
    assert study.replace(session={"playout": "fixed"}).session.strategy == session.strategy
    assert study.replace(session=None) == ts.Study.paper()


def test_ref_a_comparison_says_what_it_runs() -> None:
    study = ts.Study.read(Path(__file__).parent.parent / "examples" / "guard.toml")
    plan = study.comparison
    assert plan.labels == ["spring", "guard", "guard + shared-target"]
    assert [each.label for each in plan.architectures] == plan.labels
    (first, constant, delays), (second, bursts, other) = plan.networks
    assert (first, delays, second, other) == ("constant", None, "bursts", [0.084])
    # nothing of the study's own network stays but its delay
    lossy = study.replace(network={"loss": 0.3, "max_gap": 0.1})
    assert lossy.replace(network=constant) == study
    changed = lossy.replace(network=bursts)
    assert changed == study.replace(network=bursts)
    assert changed.network.jitter == 0.02
    assert changed.delay == study.delay
    assert pickle.loads(pickle.dumps(plan)) == plan
    assert ts.Study.from_toml(study.to_toml()).comparison == plan
    numbered = study.replace(
        comparison={"architectures": ["guard", {"strategy": {"kind": "guard", "share": 0.5}}]}
    )
    assert numbered.comparison.labels == ["guard", "guard (2)"]


@pytest.mark.parametrize(
    ("sections", "field", "mended"),
    [
        ({"session": {"strategy": "gard"}}, "session.strategy", {"session": {"strategy": "guard"}}),
        (
            {"session": {"strategy": {"kind": "guard", "share": 1.0}}},
            "session.strategy.share",
            {"session": {"strategy": {"kind": "guard", "share": 0.8}}},
        ),
        (
            {"session": {"strategy": {"kind": "guard", "capacity": 50.0}}},
            "session.strategy.capacity",
            {"session": {"strategy": {"kind": "guard", "capacity": 0.05}}},
        ),
        (
            {"coupling": {"damping": 1.0}, "session": {"strategy": "injected-damping"}},
            "session.strategy",
            {"coupling": {"damping": 0.0}, "session": {"strategy": "injected-damping"}},
        ),
        (
            {"session": {"playout": {"kind": "adaptive", "smallest": 0.6}}},
            "session.playout.largest",
            {"session": {"playout": {"kind": "adaptive", "smallest": 0.6, "largest": 0.8}}},
        ),
        (
            {"comparison": {"networks": [{"name": "a", "jitter": 20.0}]}},
            "comparison.networks[0].jitter",
            {"comparison": {"networks": [{"name": "a", "jitter": 0.02}]}},
        ),
    ],
)
def test_ref_what_is_wrong_is_refused_and_its_remedy_works(
    sections: dict[str, dict[str, object]], field: str, mended: dict[str, dict[str, object]]
) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Study.paper().replace(**sections)
    assert refused.value.field == field
    assert refused.value.remedy
    ts.Study.paper().replace(**mended)


def test_ref_robots_of_one_axis_have_no_session() -> None:
    study = "robot1 = {mass = 1, damping = 5}\nrobot2 = {mass = 1, damping = 5}\n"
    with pytest.raises(ts.InvalidInput, match="two axes") as refused:
        ts.Study.from_toml(study + 'session.strategy = "guard"')
    assert refused.value.field == "session"


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_law_every_strategy_is_rehearsed(strategy: str, tmp_path: Path) -> None:
    study = brief(stiffness=[100.0], delay=[0.05]).replace(session={"strategy": strategy})
    trials = run(study, tmp_path)
    assert (trials.status == 0).all()
    coupled = trials.sel(condition="CM-100-50")
    alone = trials.sel(condition="UM")
    for name in ("limited_share", "given_out", "energy_sent", "age_mean", "held_share", "lost"):
        assert trials[name].dims == ("condition", "trial", "robot")
        assert np.isnan(alone[name]).all()
        assert np.isfinite(coupled[name]).all()
    assert (alone.coupling_energy_minimum == 0.0).all()
    for name in ("age_low", "age_mean", "age_high"):
        assert np.abs(coupled[name] - 0.05).max() < 1e-12
    assert (coupled.held_share == 0.0).all()
    if strategy == "spring":
        assert (coupled.limited_share == 0.0).all()
    if study.session.has_account:
        assert trials.account.dims == ("condition", "trial", "time", "robot")
        assert trials.account.attrs["units"] == "J"
        assert np.isnan(trials.account.sel(condition="UM")).all()
        assert np.isfinite(coupled.account).all()
    else:
        assert "account" not in trials
    # the observer counts the same energy as both sides together, but for the last tick
    given_out = coupled.given_out.sum("robot")
    assert np.abs(given_out + coupled.coupling_energy).max() < 0.02


def test_pin_the_bare_spring_is_the_default_bit_by_bit(tmp_path: Path) -> None:
    study = brief(stiffness=[71.2], delay=[0.0836])
    plain = run(study, tmp_path / "plain")
    named = run(study.replace(session={"strategy": "spring", "playout": "fixed"}), tmp_path / "named")
    for name in ("position", "velocity", "coupling_force", "agent_force"):
        assert (plain[name] == named[name]).all()
    assert (plain.limited_share.sel(condition="CM-71-84") == 0.0).all()


def test_law_recordings_say_what_rehearsals_keep() -> None:
    study = brief().replace(session={"strategy": "guard", "predictor": "shared-target"})
    assert study.experiment is not None
    laboratory = study.experiment.laboratory
    one = laboratory.run(142.0, 0.084, 3, 4.0, 100.0)
    many = laboratory.run_many([142.0, np.nan], [0.084, 0.0], [3, 3], 4.0, 100.0)
    for name in ("account", "limited_share", "given_out", "age_high", "lost", "coupling_energy"):
        assert np.array_equal(getattr(many, name)[0], getattr(one, name))
    assert np.isnan(many.account[1]).all()
    assert np.isnan(many.limited_share[1]).all()
    assert one.account[0].tolist() == [0.05, 0.05]
    assert (one.age_low == 0.084).all()
    assert pickle.loads(pickle.dumps(many)) == many
    assert laboratory != ts.Study.paper().replace(protocol={"trials": 2}).experiment.laboratory  # type: ignore[union-attr]


def test_law_the_guard_counts_on_the_lower_end_of_the_damping() -> None:
    """A tenth of each damping as its error is the same to the account as so much less of a share."""
    paper = ts.Study.paper()
    found = []
    for sd, share in ((0.0, 0.5), (0.1, 0.5), (0.0, 0.5 * (1.0 - 0.1 * 1.959963984540054))):
        robots = {
            f"robot{i + 1}": {"damping_sd": sd * robot.damping, "mass_sd": 0.01 * robot.mass}
            for i, robot in enumerate(paper.dyad.robots)
        }
        study = paper.replace(session={"strategy": {"kind": "guard", "share": share}}, **robots)
        assert study.experiment is not None
        found.append(study.experiment.laboratory.run(142.0, 0.084, 1, 12.0, 100.0).account)
    certain, uncertain, less = found
    assert np.abs(uncertain - less).max() < 1e-7
    assert np.abs(uncertain - certain).max() > 1e-3


def test_ref_a_playout_of_its_own_that_is_too_short_has_a_warning() -> None:
    study = brief(stiffness=[71.2], delay=[0.0, 0.0836])
    short = study.replace(session={"playout": {"kind": "fixed", "delay": 0.05}})
    [warning] = preflight_warnings(short)
    assert warning == LateWarning(0.05, 0.0836)
    assert "the latest one is held" in preflight_sentence(warning)
    long = study.replace(session={"playout": {"kind": "fixed", "delay": 0.1}})
    assert preflight_warnings(long) == preflight_warnings(study) == []


def test_ref_a_guarded_rehearsal_says_whose_verdict_it_prints(root: Path, tmp_path: Path) -> None:
    study = ts.Study.read(root / "examples" / "guard.toml").replace(protocol={"trials": 1, "duration": 8.0})
    file = tmp_path / "study.toml"
    file.write_text(study.to_toml(), encoding="utf-8")
    shown = CliRunner().invoke(app, ["rehearse", str(file), "--out", str(tmp_path / "out")])
    assert shown.exit_code == 0, shown.output
    words = " ".join(shown.output.split())
    assert "bare spring with arms limited completed" in words
    assert f"This study runs guard + shared target: {describe_strategy(study.session)}." in words
    assert "Warning" not in words


@pytest.mark.parametrize("rate", [30.0, 50.0, 100.0])
def test_law_robots_with_slow_controllers_rehearse_every_architecture(rate: float) -> None:
    slow = ts.Study.paper().replace(
        laboratory={"sample_period": 1.0 / rate},
        protocol={"stiffness": [20.0], "delay": [0.1], "duration": 3.0, "discard": 1.0, "record_rate": rate},
    )
    for architecture in slow.comparison.architectures:
        # the study is refused if a condition cannot run its session
        experiment = slow.replace(session=architecture).experiment
        assert experiment is not None
        laboratory = experiment.laboratory_on((None, None))
        trial = laboratory.run(20.0, 0.1, seed=1, duration=3.0, record_rate=rate)
        assert trial.status == "completed", architecture.label
        assert np.abs(trial.coupling_force).max() > 0.1, architecture.label


def test_law_the_guard_of_slow_controllers_is_proven_for_soft_springs_only() -> None:
    slow = brief().replace(laboratory={"sample_period": 0.01, "computing_tick": True, "actuator_lag": 0.005})
    reaction, lightest = 0.01 + 0.01 + 0.005, 0.7776
    overdraft = slow.guard_overdraft(100.0)
    assert overdraft.ratio == pytest.approx(100.0 * reaction**2 / lightest)
    assert overdraft.proven_stiffness == pytest.approx(0.1 * lightest / reaction**2)
    assert overdraft.is_proven
    assert not slow.guard_overdraft(1.01 * overdraft.proven_stiffness).is_proven
    assert overdraft.largest_energy(2.0) == pytest.approx(2.0 / (1.0 - overdraft.ratio))
    assert slow.guard_overdraft(10.0 * overdraft.proven_stiffness).largest_energy(1.0) == np.inf
    # an uncertain mass counts with the lower end of its interval, a computing time as a computing tick
    unsure = ts.Study.from_toml(
        "robot1 = {mass = 2, mass_sd = 0.5, damping = 5}\nrobot2 = {mass = 2, damping = 5}\n"
        "[controller]\nsample_period = 0.002\ncomputing_time = 0.0005"
    )
    assert unsure.guard_overdraft(50.0).ratio == pytest.approx(50.0 * 0.004**2 / (2.0 - 1.959964 * 0.5))
    # it is run all the same, and what it is not worth is known
    with pytest.raises(ts.InvalidInput, match="stiffness"):
        slow.guard_overdraft(-1.0)


def test_ref_a_verdict_says_when_the_session_is_not_what_it_judges() -> None:
    assert session_notes(ts.Architecture()) == ()
    for session, words in (
        (ts.Architecture(strategy="guard"), "Above its limits the guard weakens the force"),
        (ts.Architecture(predictor="linear"), "not of the study's session (spring + linear)"),
        (ts.Architecture(playout={"kind": "fixed", "delay": 0.1}), "when it is 100 ms old"),
    ):
        [note] = session_notes(session)
        assert words in note
    [note] = session_notes(ts.Architecture(strategy="guard"), 208.35)
    assert note.endswith("(proven up to 208.3 N/m with these controllers).")


def test_ref_the_report_lists_the_session_and_does_not_take_it_for_the_papers(root: Path) -> None:
    study = ts.Study.read(root / "examples" / "guard.toml").replace(
        session={"strategy": {"kind": "guard", "capacity": 0.02}}
    )
    assert not Scene.of(study).of_the_papers_experiment
    assert Scene.of(study.replace(session=None)).of_the_papers_experiment
    rows = find_laboratory(Scene.of(study)).numbers["laboratory"]["parameters"]
    listed = {row["name"]: (row["value"], row["unit"]) for row in rows if row["part"] == "session"}
    assert listed == {
        "strategy": ("guard", ""),
        "strategy, share": (0.7, "1"),
        "strategy, capacity": (0.02, "J"),
        "strategy, intake": (0.3, "W"),
        "predictor": ("shared-target", ""),
        "play-out": ("fixed", ""),
    }
