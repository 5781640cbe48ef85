"""A clean log of two axes, as a table and as a file, and the command `identify`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from typer.testing import CliRunner, Result

from telespring import cli
from telespring.identification import paper_excitation

TRUTH = {"x": (0.8334, 7.7257), "y": (1.0649, 10.1168)}


def frame(seconds: float = 12.0, seed: int = 1) -> pd.DataFrame:
    """Make a clean log of two axes, y a quarter of a period after x."""
    time = np.arange(round(1000 * seconds)) / 1000.0
    random = np.random.default_rng(seed)
    command = paper_excitation()
    columns = {"time": time}
    for lag, (axis, (mass, damping)) in zip((0.0, 1.25), TRUTH.items(), strict=True):
        t = time - lag
        force = mass * command.acceleration(t) + damping * command.velocity(t)
        columns[f"position_{axis}"] = np.round(command.position(t) / 2e-5) * 2e-5
        columns[f"force_{axis}"] = force + random.normal(0.0, 0.1, time.size)
    return pd.DataFrame(columns)


def run(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "160", "NO_COLOR": "1"}).invoke(
        cli.app, ["identify", *map(str, arguments)]
    )


def written(table: pd.DataFrame, path: Path) -> Path:
    if path.suffix == ".csv":
        table.to_csv(path, index=False)
    elif path.suffix == ".parquet":
        table.to_parquet(path)
    else:
        from scipy import io

        io.savemat(path, {str(name): table[name].to_numpy()[:, None] for name in table})
    return path
