"""On a real axis: what others published from the same data (Janot, Gautier and Brunot 2019)."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from telespring import cli
from telespring._types import FloatArray
from telespring.identification import identify, paper_reweightings, read_log
from telespring.identification.results import Method
from telespring.references import read_reference

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT.parent / "shared" / "data" / "emps" / "DATA_EMPS.mat"

pytestmark = pytest.mark.skipif(
    not FILE.exists(), reason=f"the measured data of Janot et al. are not at {FILE.relative_to(ROOT.parent)}"
)


@pytest.fixture(scope="module")
def janot2019() -> dict[str, Any]:
    return read_reference("janot2019")


#: The published model: friction and an offset; no spring, force and position at the same time.
PUBLISHED: dict[str, Any] = {"stiffness": False, "stiction": False, "drag": False, "force_delay": 0.0}


def columns(gtau: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    log = read_log(FILE, time="t", position=["qm"], force=["vir"], force_scale=gtau)
    return log.time, log.position, log.force


@pytest.mark.parametrize("method", ["robust", "ols"])
def test_ref_janot2019_estimates_are_reached(janot2019: dict[str, Any], method: Method) -> None:
    """Within 1 %, the offset within 3 %: three to fifteen published standard deviations."""
    gtau = janot2019["data"]["gtau"]["value"]
    found = identify(*columns(gtau), method=method, **PUBLISHED)
    [axis] = found.axes
    published = janot2019["estimate"]
    for name, estimate in axis.estimates.items():
        value = published[name]["value"]
        assert estimate.value == pytest.approx(value, rel=0.03 if name == "offset" else 0.01), name
        # ours are wider than the published ones, which take residuals as independent; they hold the value
        low, high = estimate.interval
        assert low < value < high, name
    # the same model on the same data leaves as much of the force and is conditioned alike; the filters differ
    assert 100.0 * axis.relative_force_error == pytest.approx(
        published["relative_force_error"]["value"], rel=0.1
    )
    assert axis.condition_number == pytest.approx(published["condition_number"]["value"], rel=0.01)
    assert found.warnings == ()


def test_ref_janot2019_is_within_the_intervals_of_the_fuller_model(janot2019: dict[str, Any]) -> None:
    """With a spring and a lag in the model too. A voltage acts until the next sample: half a sample early."""
    gtau = janot2019["data"]["gtau"]["value"]
    found = identify(*columns(gtau))
    [axis] = found.axes
    for name in ("mass", "damping"):
        low, high = axis.estimates[name].interval
        assert low < janot2019["estimate"][name]["value"] < high, name
    assert axis.stiffness is not None
    # there is none
    assert axis.stiffness.interval[0] < 0.0 < axis.stiffness.interval[1]
    assert axis.time_shift is not None
    assert -1.0e-3 < axis.time_shift.value < -0.3e-3
    # damping that depends on the speed, as the residuals of this axis show
    late, told = found.warnings
    assert "The position lags the force by 0." in late
    assert "the force also depends on the cube of the velocity" in told


@pytest.mark.parametrize("cutoff", [15.0, 30.0, 60.0, 120.0])
def test_law_the_estimates_do_not_hang_on_the_cutoff(janot2019: dict[str, Any], cutoff: float) -> None:
    gtau = janot2019["data"]["gtau"]["value"]
    [axis] = identify(*columns(gtau), cutoff=cutoff, **PUBLISHED).axes
    for name, estimate in axis.estimates.items():
        value = janot2019["estimate"][name]["value"]
        assert estimate.value == pytest.approx(value, rel=0.03 if name == "offset" else 0.01), name


def test_law_the_papers_weights_collapse_and_their_intervals_mean_nothing(janot2019: dict[str, Any]) -> None:
    gtau = janot2019["data"]["gtau"]["value"]
    found = identify(*columns(gtau), **PUBLISHED)
    signals, [axis] = found.signals, found.axes
    regressor = np.column_stack(
        [signals.acceleration[0], signals.velocity[0], signals.direction[0], np.ones(signals.time.size)]
    )
    steps = paper_reweightings(regressor, signals.force[0])
    losses = [step.log_loss for step in steps]
    # each step makes Σ log(r² + ε) smaller or leaves it; 1e-6: rounding of sums of thousands of logarithms
    assert all(later <= earlier + 1e-6 for earlier, later in itertools.pairwise(losses))
    # in the end all weight is on as many samples as there are parameters
    assert steps[-1].effective_samples == pytest.approx(4.0, abs=0.1)
    assert signals.time.size > 1000
    widths = np.array([estimate.interval[1] - estimate.value for estimate in axis.estimates.values()])
    assert (steps[-1].half_width < 1e-5 * widths).all()
    # already the one step that is printed gives intervals that miss the published values
    paper = identify(*columns(gtau), coulomb=True, offset=True, method="paper")
    assert paper.iterations == 1
    for name, estimate in paper.axes[0].estimates.items():
        low, high = estimate.interval
        assert not low < janot2019["estimate"][name]["value"] < high, name


def test_law_the_command_reads_the_file_and_beware_of_volts(janot2019: dict[str, Any]) -> None:
    asked = [
        "identify",
        str(FILE),
        "--time",
        "t",
        "--position",
        "qm",
        "--force",
        "vir",
        "--no-stiffness",
        "--no-stiction",
        "--no-drag",
        "--force-delay",
        "0",
        "--json",
    ]
    runner = CliRunner(env={"COLUMNS": "100", "NO_COLOR": "1"})
    volts = json.loads(runner.invoke(cli.app, asked).stdout)
    [warning] = volts["warnings"]
    assert "--force-scale" in warning
    assert "gtau" in warning
    scale = str(janot2019["data"]["gtau"]["value"])
    newtons = json.loads(runner.invoke(cli.app, [*asked, "--force-scale", scale]).stdout)
    assert newtons["warnings"] == []
    [axis] = newtons["axes"]
    assert axis["mass"] == pytest.approx(janot2019["estimate"]["mass"]["value"], rel=0.01)
    assert axis["mass_interval"][0] < axis["mass"] < axis["mass_interval"][1]
