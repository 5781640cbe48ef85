"""The survey of dyads: its counts are those of the criteria, and shares add up."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import telespring as ts


def test_cross_the_counts_are_those_of_dyads_drawn_otherwise() -> None:
    """Another generator, the array functions, one cell: shares agree within five standard errors."""
    survey = ts.survey_dyads(40_000, mass_ratio=(0.1, 10.0), damping_ratio=(0.1, 10.0), cells=(1, 1))
    random = np.random.default_rng(5)

    def log_uniform(low: float, high: float) -> np.ndarray:
        return np.exp(random.uniform(np.log(low), np.log(high), 40_000))

    m1, b1 = log_uniform(0.5, 5.0), log_uniform(1.0, 20.0)
    m2, b2 = m1 * log_uniform(0.1, 10.0), b1 * log_uniform(0.1, 10.0)
    exact = np.asarray(ts.critical_stiffness(m1, b1, m2, b2))
    paper = np.asarray(ts.critical_stiffness(m1, b1, m2, b2, method="paper"))
    share = float((paper > exact * (1.0 + 1e-9)).mean())
    assert 0.3 < share < 0.9
    assert float(survey.unsafe[0, 0] / survey.dyads[0, 0]) == pytest.approx(
        share, abs=5 * (0.5 / 40_000) ** 0.5
    )
    for quantile in (0.1, 0.5, 0.9, 0.99):
        found = float(ts.unsafe_quantile(survey, quantile)[0, 0])
        expected = np.quantile(np.maximum(paper / exact, 1.0), [quantile - 0.01, min(1.0, quantile + 0.01)])
        assert expected[0] / 1.02 <= found <= expected[1] * 1.02


def test_ref_the_quantiles_of_one_dyad_are_its_ratio() -> None:
    """Robots of one mass, one with ten times the damping: 25.25 N/m on paper, 9.4610953 N/m exactly."""
    survey = ts.survey_dyads(100, mass_ratio=(1.0, 1.0), damping_ratio=(10.0, 10.0), cells=(1, 1))
    ratio = 25.25 / 9.4610953
    assert float(survey.largest[0, 0]) == pytest.approx(ratio, rel=1e-7)
    for quantile in (0.0, 0.5, 1.0):
        assert float(ts.unsafe_quantile(survey, quantile)[0, 0]) == pytest.approx(ratio, rel=0.011)


@pytest.mark.parametrize("count", [1, 2, 7])
def test_law_shares_add_up(count: int) -> None:
    settings: dict[str, Any] = {"cells": (3, 2), "operator_mass": 0.5, "operator_damping": 2.0, "seed": 9}
    whole = ts.survey_dyads(10_001, **settings)
    shares = [ts.survey_dyads(10_001, shard=(index + 1, count), **settings) for index in range(count)]
    assert ts.merge_surveys(shares).identical(whole)
    assert int(whole.dyads.sum()) == 6 * 1667


def test_law_progress_reaches_the_end() -> None:
    told: list[tuple[int, int]] = []
    ts.survey_dyads(9_000_000, cells=(1, 1), progress=lambda done, total: told.append((done, total)))
    assert told[0] == (0, 9_000_000)
    assert [done for done, _ in told[1:]] == sorted({done for done, _ in told[1:]})
    assert told[-1] == (9_000_000, 9_000_000)


@pytest.mark.parametrize(
    ("changed", "field"),
    [
        ({"mass": (5.0, 0.5)}, "mass"),
        ({"damping": (0.0, 1.0)}, "damping"),
        ({"cells": (0, 2)}, "cells"),
        ({"mass_ratio": (1e-9, 1.0)}, "mass_ratio"),
        ({"operator_mass": -1.0}, "operator_mass"),
        ({"operator_mass": "x"}, "operator_mass"),
        ({"shard": (3, 2)}, "shard"),
        ({"dyads": 0}, "dyads"),
        ({"dyads": 1.5}, "dyads"),
        ({"dyads": 10**30}, "dyads"),
        ({"seed": -1}, "seed"),
        ({"cells": (1, 2, 3)}, "cells"),
        ({"cells": (1.5, 2)}, "cells"),
        ({"cells": (-1, 2)}, "cells"),
        ({"cells": 4}, "cells"),
        ({"cells": (10_000, 10_000)}, "cells"),
        ({"mass": 1.0}, "mass"),
    ],
)
def test_law_what_cannot_be_drawn_is_refused(changed: dict[str, Any], field: str) -> None:
    with pytest.raises(ts.InvalidInput) as refused:
        ts.survey_dyads(**({"dyads": 100} | changed))
    assert refused.value.field.startswith(field)


def test_law_surveys_of_other_populations_do_not_add_up() -> None:
    with pytest.raises(ts.InvalidInput, match="one population"):
        ts.merge_surveys([ts.survey_dyads(10, cells=(1, 1)), ts.survey_dyads(10, cells=(1, 1), seed=2)])


def test_law_shares_from_files_add_up(tmp_path: Path) -> None:
    files = [tmp_path / f"{index}.nc" for index in (1, 2)]
    for index, file in enumerate(files, start=1):
        ts.survey_dyads(100, cells=(2, 1), shard=(index, 2)).to_netcdf(file, engine="h5netcdf")
    merged = ts.merge_surveys([xr.load_dataset(file, engine="h5netcdf") for file in files])
    assert merged.identical(ts.survey_dyads(100, cells=(2, 1)))


@pytest.mark.parametrize(
    ("shares", "said"),
    [
        (["1/2"], "all 2 shares, each once"),
        (["1/2", "1/2"], "all 2 shares, each once"),
        (["1/2", "2/2", "2/2"], "all 2 shares, each once"),
        (["1/2", "2/3"], "all shares of one division"),
        ([None, None], "all shares of one division"),
    ],
)
def test_law_a_missing_or_repeated_share_is_refused(shares: list[str | None], said: str) -> None:
    with pytest.raises(ts.InvalidInput, match=said):
        ts.merge_surveys([ts.survey_dyads(12, cells=(1, 1), shard=share) for share in shares])


def test_law_shares_of_other_numbers_of_dyads_do_not_add_up() -> None:
    with pytest.raises(ts.InvalidInput, match="one population"):
        ts.merge_surveys(
            [ts.survey_dyads(total, cells=(1, 1), shard=(index, 2)) for index, total in ((1, 10), (2, 20))]
        )


def test_law_numbers_of_any_kind_are_read() -> None:
    found = ts.survey_dyads(1e2, cells=[2, np.int64(1)], mass=[0.5, 5.0])  # type: ignore[arg-type]
    assert found.identical(ts.survey_dyads(100, cells=(2, 1)))


def test_law_the_example_draws_the_map(root: Path, tmp_path: Path) -> None:
    file = tmp_path / "survey.png"
    call = [sys.executable, str(root / "examples" / "survey.py"), "4e5", str(file)]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "unsafe: " in done.stdout
    assert file.stat().st_size > 10_000
