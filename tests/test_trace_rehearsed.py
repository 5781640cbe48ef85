"""The ages that `telespring trace` finds, against those that a rehearsal over the same trace uses."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import telespring as ts

#: Recorded round trips of 5G (docs/traces.md), which are not part of the repository.
RECORDED = Path(__file__).parents[2] / "shared" / "data" / "net" / "cicv5g"


def realised(
    trace: ts.Trace, study: ts.Study, folder: Path, duration: float, trials: int
) -> list[tuple[float, float]]:
    """Rehearse over a trace, and return the smallest and the largest age of each trial and side."""
    folder.mkdir()
    (folder / "trace.csv").write_text(trace.to_csv())
    rehearsed = study.replace(
        coupling={"stiffness": 1.0},
        protocol={
            "unconnected": False,
            "conditions": [{"stiffness": 1.0, "delay": study.session.playout_delay}],
            "trials": trials,
            "duration": duration,
            "discard": 0.5,
        },
    )
    (folder / "study.toml").write_text(rehearsed.to_toml())
    found = ts.rehearse(folder / "study.toml", folder / "out")
    assert (found.status == 0).all()
    low, high = (found[name].values.ravel().tolist() for name in ("age_low", "age_high"))
    return list(zip(low, high, strict=True))


def irregular(seed: int) -> ts.Trace:
    """Draw a trace of 12 s whose packets are not sent on the grid of the ticks, with losses in a row."""
    random = np.random.default_rng(seed)
    time = np.cumsum(random.uniform(0.004, 0.0163, 1200))
    delay = 0.02 + random.gamma(2.0, 0.004, 1200)
    lost = np.repeat(random.random(300) < 0.08, 4)
    delay[lost] = math.nan
    return ts.Trace(time, delay)


@pytest.mark.parametrize("seed", range(3))
def test_cross_a_rehearsal_uses_the_ages_that_were_found(seed: int, tmp_path: Path) -> None:
    trace = irregular(seed)
    found = ts.assess_trace(trace)
    (low, high), _ = found.recommended.ages
    # longer than once round the circle: it meets all of the trace, at ticks that fall anywhere
    ages = realised(trace, found.recommended_study("trace.csv"), tmp_path / "a", trace.duration + 2.0, 3)
    assert all(low - 1e-9 <= young and old <= high + 1e-9 for young, old in ages)
    # and not by more than the tick that the places of the ticks are worth, on both sides
    assert min(young for young, _ in ages) <= low + 0.002 + 1e-9
    assert max(old for _, old in ages) >= high - 0.002 - 1e-9


@pytest.mark.parametrize("name", ["urban_100Hz_n78_v30_run01.txt", "rural_20Hz_n8_v10_01.txt"])
def test_cross_a_rehearsal_over_a_recorded_network_uses_the_ages_that_were_found(
    name: str, tmp_path: Path
) -> None:
    file = RECORDED / name
    if not file.exists():
        pytest.skip(f"THE RECORDING {name} IS NOT THERE: the ages of a rehearsal over it are untested")
    found = ts.assess_trace(ts.read_trace(file, round_trip=True))
    trace = found.ways[0].trace
    (low, high), _ = found.recommended.ages
    ages = realised(trace, found.recommended_study("trace.csv"), tmp_path / "a", trace.duration + 8.0, 1)
    assert all(low - 1e-9 <= young and old <= high + 1e-9 for young, old in ages)
    if not found.needs_guard:
        # but for the tick that the places of the ticks between packets are worth
        assert min(young for young, _ in ages) == pytest.approx(low, abs=0.001 + 1e-9)
        assert max(old for _, old in ages) == pytest.approx(high, abs=0.001 + 1e-9)
