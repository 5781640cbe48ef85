"""Table I, the whole analysis, and the command that prints it."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import telespring as ts
from made_trials import offsets, small
from telespring import cli
from telespring.analysis import analyse_trials, compare, condition_label, holm, kruskal_wallis, write_recorded
from telespring.cli import analyse

CONDITIONS = [(math.nan, 0.0), (36.0, 0.0), (36.0, 0.167), (142.0, 0.0), (142.0, 0.167)]


def run(*arguments: object, columns: int = 80) -> Result:
    words = [str(each) for each in arguments]
    return CliRunner(env={"COLUMNS": str(columns), "NO_COLOR": "1"}).invoke(cli.app, words)


def errors(trials: int = 20, seed: int = 2) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Tracking errors, m: in order much as, below, barely above, below and far above TE2 unconnected."""
    rng = np.random.default_rng(seed)
    means = np.array([[34.8, 38.7], [33.0, 38.7], [33.0, 39.9], [34.0, 36.0], [39.0, 45.0]]) * 1e-3
    return np.asarray(means[:, None, :] + 1.5e-3 * rng.normal(size=(5, trials, 2)))


@pytest.fixture(scope="module")
def made() -> xr.Dataset:
    return offsets(errors(), CONDITIONS)


@pytest.fixture(scope="module")
def found(made: xr.Dataset) -> dict[str, Any]:
    return analyse_trials(made)


def test_ref_table_one_is_the_paper_s_by_its_own_definitions(found: dict[str, Any]) -> None:
    values = 1e3 * errors()
    rows = found["table1"]
    assert [row["condition"] for row in rows] == ["UM", "CM-36-0", "CM-36-167", "CM-142-0", "CM-142-167"]
    assert [row["stiffness"] for row in rows] == [None, 36.0, 36.0, 142.0, 142.0]
    assert [row["delay"] for row in rows] == [0.0, 0.0, 0.167, 0.0, 0.167]
    baseline = values[0, :, 1]
    p_values = []
    for i, row in enumerate(rows):
        for robot in (1, 2):
            group, key = values[i, :, robot - 1], f"te{robot}"
            assert row[f"{key}_mean"] == pytest.approx(sum(group) / 20.0, rel=1e-12)
            spread = math.sqrt(sum((group - sum(group) / 20.0) ** 2) / 19.0)
            assert row[f"{key}_sd"] == pytest.approx(spread, rel=1e-9)
            assert row[f"{key}_median"] == pytest.approx(sum(sorted(group)[9:11]) / 2.0, rel=1e-12)
            assert row[f"{key}_n"] == 20
            if (i, robot) == (0, 2):
                assert row[f"{key}_arrow"] == row[f"{key}_arrow_holm"] == ""
                assert row[f"{key}_p"] is None
                continue
            p_values.append(compare(group, baseline).p_value)
            assert row[f"{key}_p"] == p_values[-1]
            larger = sum(one > other for one in group for other in baseline) / 400.0
            assert row[f"{key}_superiority"] == pytest.approx(larger, abs=1e-12)
            assert row[f"{key}_superiority_low"] < larger or larger == 0.0
    corrected = iter(holm(p_values))
    for i, row in enumerate(rows):
        for robot in (1, 2):
            if (i, robot) != (0, 2):
                assert row[f"te{robot}_p_holm"] == next(corrected)
    assert [row["te1_arrow"] for row in rows] == ["↓", "↓", "↓", "↓", ""]
    assert [row["te2_arrow"] for row in rows] == ["", "", "↑", "↓", "↑"]


def test_law_holm_takes_away_arrows_and_gives_none(found: dict[str, Any]) -> None:
    pairs = [(row[f"te{i}_arrow"], row[f"te{i}_arrow_holm"]) for row in found["table1"] for i in (1, 2)]
    assert all(holm_arrow in ("", raw) for raw, holm_arrow in pairs)
    assert any(raw and not holm_arrow for raw, holm_arrow in pairs)
    # barely above: 1.2 mm at a standard deviation of 1.5 mm
    barely = found["table1"][2]
    assert barely["te2_p"] < 0.05
    assert barely["te2_p_holm"] > barely["te2_p"]


def test_law_families_hold_what_they_say(found: dict[str, Any]) -> None:
    wilcoxon = found["wilcoxon"]
    sizes = {name: family["size"] for name, family in wilcoxon.items()}
    assert sizes == {"baseline": 9, "robots": 5, "te1_pairs": 10, "te2_pairs": 10}
    for family in wilcoxon.values():
        assert len(family["comparisons"]) == family["size"]
        raw = [each["p"] for each in family["comparisons"]]
        assert [each["p_holm"] for each in family["comparisons"]] == holm(raw)
    assert {each["second"] for each in wilcoxon["baseline"]["comparisons"]} == {"TE2 UM"}
    tests = found["kruskal_wallis"]
    per_stiffness = ("36 N/m and UM", "36 N/m", "142 N/m and UM", "142 N/m")
    assert [(each["over"], each["robot"]) for each in tests] == [
        ("all conditions", 1),
        ("all conditions", 2),
        *((over, robot) for robot in (1, 2) for over in per_stiffness),
    ]
    values = errors()
    for each in tests:
        places = [[row["condition"] for row in found["table1"]].index(name[4:]) for name in each["groups"]]
        direct = kruskal_wallis({str(i): values[i, :, each["robot"] - 1] for i in places})
        assert each["h"] == pytest.approx(direct.statistic, rel=1e-9)
        members = [other["p"] for other in tests if other["family"] == each["family"]]
        assert each["p_holm"] == holm(members)[members.index(each["p"])]


def test_law_numbers_survive_json(found: dict[str, Any]) -> None:
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_law_another_baseline_or_none(made: xr.Dataset) -> None:
    other = analyse_trials(made, baseline="CM-36-0")
    assert other["baseline"]["condition"] == "CM-36-0"
    assert other["table1"][1]["te2_p"] is None
    assert other["table1"][0]["te2_p"] is not None
    none = analyse_trials(made.isel(condition=slice(1, None)))
    assert none["baseline"] == {"condition": None, "te2_median": None}
    assert {row["te1_arrow"] + row["te2_arrow"] for row in none["table1"]} == {""}
    with pytest.raises(ts.InvalidInput, match="one of UM, CM-36-0"):
        analyse_trials(made, baseline="CM-36")


def test_law_early_ends_are_counted_and_leave_gaps() -> None:
    found = analyse_trials(small())
    assert [row["trials"] for row in found["table1"]] == [3, 2, 3]
    assert [row["ended_early"] for row in found["table1"]] == [0, 0, 1]
    assert [row["te1_n"] for row in found["table1"]] == [3, 2, 2]
    last = found["conditions"][2]
    assert last["status"] == {"completed": 2, "diverged": 1}
    assert last["measures"]["tracking_error"]["robot1"]["values"][1] is None
    json.dumps(found, allow_nan=False)
    everything = small()
    everything["status"][:] = "diverged"
    nothing = analyse_trials(everything)
    assert {row["te1_mean"] for row in nothing["table1"]} == {None}
    assert {each["h"] for each in nothing["kruskal_wallis"]} == {None}


def test_ref_conditions_are_named_as_in_the_paper(du2025: dict[str, Any]) -> None:
    for row in du2025["table1"]["row"]:
        stiffness, delay = row.get("stiffness", math.nan), 1e-3 * row.get("delay", 0.0)
        assert condition_label(stiffness, delay) == row["task"]
    arrows = {"less": "↓", "greater": "↑", "": ""}
    printed = [arrows[row["TE2"]["against_baseline"]] for row in du2025["table1"]["row"]]
    assert printed.count("↑") == 5
    assert printed.count("↓") == 1


def test_law_the_command_prints_table_one_and_writes_everything(made: xr.Dataset, tmp_path: Path) -> None:
    made.to_netcdf(tmp_path / "rehearsal.nc", engine="h5netcdf")
    shown = run("analyse", tmp_path, "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    lines = shown.stdout.splitlines()
    row = analyse_trials(made)["table1"][4]
    [line] = [each for each in lines if each.startswith("CM-142-167")]
    assert f"{row['te2_mean']:.2f} ± {row['te2_sd']:.2f} ↑*" in line
    assert line.split()[-1] == "20"
    assert max(len(each) for each in lines) <= 80
    assert "correction over all 9 comparisons" in " ".join(shown.stdout.split())
    numbers = json.loads((tmp_path / "out" / "analysis.json").read_text(encoding="utf-8"))
    assert numbers == analyse_trials(made)
    with (tmp_path / "out" / "table1.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [each["condition"] for each in rows] == [each["condition"] for each in numbers["table1"]]
    assert float(rows[4]["te2_mean"]) == row["te2_mean"]
    assert rows[0]["stiffness"] == ""
    names = {each.name for each in (tmp_path / "out").iterdir()}
    assert names == {
        "analysis.json", "table1.csv", "trajectories.svg", "trajectories.png", "tracking-errors.svg",
        "tracking-errors.png",
    }  # fmt: skip


def test_law_recorded_trials_give_the_same_table(made: xr.Dataset, tmp_path: Path) -> None:
    made.isel(trial=slice(0, 4)).to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    common = ("--json", "--no-figures", "--out", tmp_path / "out")
    first = run("analyse", tmp_path / "run.nc", "--export", tmp_path / "lab", *common)
    assert first.exit_code == 0, first.output
    second = run("analyse", tmp_path / "lab", *common)
    third = run("analyse", tmp_path / "lab" / "trials.csv", *common)
    # CSV keeps every bit
    assert json.loads(first.stdout) == json.loads(second.stdout) == json.loads(third.stdout)


def test_law_a_study_gives_the_target_and_what_to_discard(
    made: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trials = made.isel(trial=slice(0, 4)).copy()
    del trials.attrs["discard"]
    write_recorded(trials, tmp_path / "lab")
    for file in (tmp_path / "lab").glob("*M-*.csv"):
        lines = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
        file.write_text("\n".join(",".join(line[:1] + line[3:]) for line in lines), encoding="utf-8")
    arguments = ("analyse", tmp_path / "lab", "--out", tmp_path / "out", "--json", "--no-figures")
    refused = run(*arguments)
    assert refused.exit_code == 2
    assert "Add them, or name the study: --study as an option" in refused.stderr
    task = {"kind": "figure-eight", "amplitude": [0.05, 0.1], "angular_frequency": 2.59}
    study = SimpleNamespace(experiment=SimpleNamespace(task=task, discard=0.5))
    monkeypatch.setattr(analyse, "Study", SimpleNamespace(read=lambda _: study))
    found = run(*arguments, "--study", "paper.toml")
    assert found.exit_code == 0, found.output
    numbers = json.loads(found.stdout)
    assert numbers["analysed"]["discard"] == 0.5
    # a tracking error that is the same at every time does not change with what is discarded
    assert numbers["table1"][2]["te2_mean"] == pytest.approx(analyse_trials(trials)["table1"][2]["te2_mean"])


def test_law_the_example_can_be_analysed_as_it_is(tmp_path: Path) -> None:
    assert run("analyse", "--template", tmp_path / "lab").exit_code == 0
    shown = run("analyse", tmp_path / "lab", "--out", tmp_path / "out", "--no-figures")
    assert shown.exit_code == 0, shown.output
    assert "64|124" in shown.stdout


def test_law_trials_that_look_cut_off_or_stuck_are_reported(made: xr.Dataset, tmp_path: Path) -> None:
    assert analyse_trials(made)["warnings"] == []
    odd = made.isel(trial=slice(0, 6)).copy(deep=True)
    size = odd.sizes["time"]
    samples = np.full((odd.sizes["condition"], 6), size)
    samples[0, 1] = round(0.85 * size)
    odd["samples"] = ("condition", "trial"), samples
    odd["position"][1, 2, :, 0] = 0.01
    odd["position"][2, 3, size // 2 :, 1] = odd["position"][2, 3, size // 2, 1]
    warnings = analyse_trials(odd)["warnings"]
    labels = odd["condition"].values.tolist()
    assert len(warnings) == 3
    assert warnings[0].startswith(f"Trial 2 of {labels[0]} counts as completed after ")
    assert warnings[1].startswith(f"Trial 3 of {labels[1]}: the handle of robot 1 does not move throughout")
    assert warnings[1].endswith("Then set the trial's status to stopped, which leaves it out.")
    mended = odd.copy(deep=True)
    status = np.full((odd.sizes["condition"], 6), "completed", dtype=object)
    status[0, 1] = status[1, 2] = status[2, 3] = "stopped"
    mended["status"] = ("condition", "trial"), status.astype(str)
    assert analyse_trials(mended)["warnings"] == []
    assert warnings[2].startswith(f"Trial 4 of {labels[2]}: the handle of robot 2 does not move from ")
    odd.to_netcdf(tmp_path / "rehearsal.nc", engine="h5netcdf")
    shown = run("analyse", tmp_path, "--out", tmp_path / "out", "--no-figures")
    assert shown.exit_code == 0, shown.output
    assert all(each in " ".join(shown.stdout.split()) for each in warnings)


def refused(*arguments: object) -> str:
    found = run("analyse", *arguments)
    assert found.exit_code == 2, found.output
    return " ".join(found.stderr.split())


def test_law_what_holds_no_trials_is_refused(tmp_path: Path) -> None:
    assert "a rehearsal or recorded trials are required" in refused()
    assert "No such file or directory" in refused(tmp_path / "absent.nc")
    assert "rehearsal.nc (from `telespring rehearse`) or trials.csv" in refused(tmp_path)
    other = tmp_path / "notes.txt"
    other.write_text("x", encoding="utf-8")
    assert "a rehearsal's .nc file, trials.csv, or a folder" in refused(other)
    broken = tmp_path / "rehearsal.nc"
    broken.write_bytes(b"\x89HDF\r\n\x1a\n and then nothing")
    assert "a whole netCDF file is required" in refused(broken)
    found = ts.simulate(ts.hman(), 20.0, 0.05, [[1.0, 0.0], [-1.0, 0.0]], duration=0.1)
    found.to_netcdf(broken, engine="h5netcdf")
    assert "target over time, axis is required" in refused(broken)


def test_law_a_trial_that_ended_early_is_reported(tmp_path: Path) -> None:
    small().to_netcdf(tmp_path / "rehearsal.nc", engine="h5netcdf")
    shown = run("analyse", tmp_path, "--out", tmp_path / "out", "--no-figures")
    assert shown.exit_code == 0, shown.output
    assert "2/3" in shown.stdout
    assert "1 trial ended early: it has no tracking error" in shown.stdout
    assert not list((tmp_path / "out").glob("*.svg"))


def shown(dataset: xr.Dataset, tmp_path: Path, columns: int = 80) -> tuple[list[str], str]:
    """Analyse a dataset; return the lines of the screen, and its words in one line."""
    dataset.to_netcdf(tmp_path / "rehearsal.nc", engine="h5netcdf")
    found = run("analyse", tmp_path, "--out", tmp_path / "out", "--no-figures", columns=columns)
    assert found.exit_code == 0, found.output
    return found.stdout.splitlines(), " ".join(found.stdout.split())


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_law_the_screen_fits_the_terminal_and_cuts_nothing(columns: int, tmp_path: Path) -> None:
    dataset = small(trials=4)
    dataset["position"][0, 2, :, 0] = dataset["position"][0, 1, :, 0]
    lines, words = shown(dataset, tmp_path, columns)
    assert max(len(line) for line in lines) <= columns
    assert "…" not in words
    table = analyse_trials(dataset)
    for row, condition in zip(table["table1"], table["conditions"], strict=True):
        cells = " ".join(line for line in lines if line.startswith(f"{row['condition']} "))
        for robot in (1, 2):
            assert f"{row[f'te{robot}_mean']:.2f} ± {row[f'te{robot}_sd']:.2f}" in cells
        forces = condition["measures"]["effort_rms"]
        assert "|".join(f"{forces[f'robot{robot}']['mean']:.2f}" for robot in (1, 2)) in cells
    # one table, or errors and other measures below each other
    headings = [line for line in lines if line.startswith("Condition")]
    assert len(headings) == (1 if columns == 120 else 2)
    lines, _ = shown(small(trials=4), tmp_path, columns)
    # without the column of distinct trials
    assert sum(line.startswith("Condition") for line in lines) == (2 if columns == 60 else 1)


def test_law_the_screen_says_what_few_trials_cannot_show(made: xr.Dataset, tmp_path: Path) -> None:
    _, words = shown(made.isel(trial=slice(0, 3)), tmp_path)
    assert "With so few distinct trials p cannot be below 0.1, so no arrow can appear" in words
    assert "4 in each condition are the fewest." in words
    assert "it cannot be below" not in words
    _, words = shown(made.isel(trial=slice(0, 2), condition=slice(0, 3)), tmp_path)
    # 6 of the 90 ways to share out six trials to three conditions
    assert "exact (it cannot be below 0.0667)" in words
    _, words = shown(made.isel(trial=slice(0, 4)), tmp_path)
    # 2 of C(8, 4) assignments, and 9 comparisons; 2/C(12, 6) is the first below 0.05/9
    assert (
        "no * can appear: the least p is 0.0286, and Holm's correction asks for 0.00556 at first; 6 in"
        in words
    )
    _, words = shown(made, tmp_path)
    assert "cannot" not in words
    assert "no * can" not in words


def test_law_the_screen_says_what_copies_simulations_and_dyads_mean(made: xr.Dataset, tmp_path: Path) -> None:
    few = made.isel(trial=slice(0, 8)).copy(deep=True)
    few["position"][1] = np.asarray(few["position"])[1, :1]
    lines, words = shown(few, tmp_path)
    assert (
        "TE1 CM-36-0, TE2 CM-36-0: 7 of 8 trials repeat another one to the nanometre, so they do not" in words
    )
    assert "TE1 CM-36-0, TE2 CM-36-0: too few distinct trials for an arrow; p cannot be below 0.222." in words
    [line] = [line for line in lines if line.startswith("CM-36-0 ")]
    assert line.split()[-2:] == ["8", "1"]
    assert "All trials count as independent. If several dyads or people took part" in words
    assert "simulated" not in words
    seeds = np.arange(40, dtype=np.uint64).reshape(5, 8)
    _, words = shown(few.assign(seed=(("condition", "trial"), seeds)), tmp_path)
    assert "The trials are simulated: p also depends on how many were run" in words
    assert "with enough of them, where trials differ, any difference is significant" in words
    assert "nothing in them is random; more trials do not help" in words
    assert "independent" not in words
    # of nothing random it does not say that more trials make a difference significant
    still = few.copy(deep=True)
    still["position"][:] = np.asarray(still["position"])[:, :1]
    _, words = shown(still.assign(seed=(("condition", "trial"), seeds)), tmp_path)
    assert "The trials are simulated and nothing in them is random, so p says nothing." in words
    assert "is significant." not in words
    # two that differ among eight are random
    twice = few.copy(deep=True)
    twice["position"][1, 7] = np.asarray(made["position"])[1, 7]
    _, words = shown(twice.assign(seed=(("condition", "trial"), seeds)), tmp_path)
    assert "6 of 8 trials repeat another one to the nanometre, so they do not count." in words
    dyads = np.tile([f"D{i}" for i in range(8)], (5, 1))
    _, words = shown(few.assign(dyad=(("condition", "trial"), dyads)), tmp_path)
    assert "8 dyads: every dyad counts once" in words
    assert "TE: tracking error, mean ± standard deviation over the dyads, each with the mean of its" in words
    assert "Wilcoxon signed-rank test within dyads, p < 0.05" in words
    dyads[:] = "D1"
    _, words = shown(few.assign(dyad=(("condition", "trial"), dyads)), tmp_path)
    assert "All trials are of one dyad: p holds for this dyad only." in words
