"""The paper's whole experiment: 17 conditions of 20 trials of 29.1 s, to the finished netCDF file."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator

from harness import Effort, Row
from rustside import RustSide

import telespring as ts
from telespring.rehearsal import run_protocol

ALL = "rehearsal: 340 trials of 29.1 s, 1 kHz, file included"
SHORT = "[protocol]\ntrials = 1\nduration = 1.0\ndiscard = 0.5\n"


def rows(effort: Effort, rust: RustSide | None) -> Iterator[Row]:
    del rust  # it knows nothing of files
    study = ts.Study.paper()
    if effort.quick:
        study = ts.Study.from_toml(study.to_toml() + SHORT)
    for name, workers, base in (("all cores", None, True), ("one core", 1, False)):

        def rehearse(workers: int | None = workers) -> None:
            with tempfile.TemporaryDirectory() as folder:
                run_protocol(study, folder, workers=workers)

        target = 10.0 if base else None
        yield Row(
            ALL, f"ours: Python, {name}", effort.time(rehearse), ours=True, base=base, target_seconds=target
        )
