"""The table of speed and accuracy: ours beside the programs that others use, in one run.

    python benches/run.py                 prints the table and writes out/bench.json
    python benches/run.py --quick         tiny sizes: shows that everything runs, measures nothing

Times are medians with quartiles on the machine at hand, which should do nothing else meanwhile.
Nothing here fails for being slow.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

import criteria
import rehearsal
import roots
import rustside
import session
import simulation
import stability_map
from harness import Effort, Row
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
PEERS = ("numba", "jitcdde", "scipy", "ddeint", "tdcpy", "qpmr", "control", "yaltapy", "numpy", "mpmath")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="tiny sizes, no measurement")
    parser.add_argument(
        "--no-build",
        action="store_true",
        help="take the Rust program as it is, or do without where it is not built",
    )
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "bench.json", help="where to write")
    options = parser.parse_args()

    # peers warn of many things; what matters is whether their results are right
    warnings.simplefilter("ignore")
    # a file or a pipe has no width of its own, and the default breaks the table's words
    console = Console(width=None if sys.stdout.isatty() else 150)
    start = time.perf_counter()
    rows = measure(Effort(options.quick), not options.no_build, console)
    spent = time.perf_counter() - start
    write(options.output, rows, spent, options.quick)
    show(rows, console, options.quick)
    if options.quick:
        console.print("--quick: tiny sizes; no time here is a measurement.")
    console.print(f"{spent:.0f} s in all; written to {options.output}")


def measure(effort: Effort, build: bool, console: Console) -> list[Row]:
    rows: list[Row] = []
    with Progress(console=console, transient=True) as progress, tempfile.TemporaryDirectory() as folder:
        task = progress.add_task("", total=7)

        def step(what: str) -> None:
            progress.update(task, description=what, advance=1)

        rust = None
        step("building and running the Rust program")
        if build:
            rustside.build()
        if rustside.PROGRAM.exists():
            rust = rustside.measure(Path(folder), effort.quick)
        groups: list[tuple[str, Callable[..., Iterator[Row]]]] = [
            ("simulations", simulation.rows),
            ("roots", roots.rows),
            ("criteria", criteria.rows),
            ("stability maps", stability_map.rows),
            ("a session", session.rows),
            ("a rehearsal", rehearsal.rows),
        ]
        for what, group in groups:
            step(what)
            rows.extend(group(effort, rust))
        rows += list(simulation.scaled_grid(rows))
    return rows


def show(rows: list[Row], console: Console, quick: bool) -> None:
    for group in dict.fromkeys(row.group for row in rows):
        here = [row for row in rows if row.group == group]
        base = next((row.timing.median for row in here if row.base and row.timing), None)
        table = Table(title=group, title_justify="left", title_style="bold", expand=False)
        for heading, justify in (
            ("", "left"),
            ("median", "right"),
            ("quartiles", "right"),
            ("ratio", "right"),
            ("rel. error", "right"),
            ("target", "right"),
            ("", "left"),
        ):
            table.add_column(heading, justify=justify)  # type: ignore[arg-type]
        for row in here:
            timing = row.timing
            median = quartiles = ratio = ""
            if timing is not None:
                median = duration(timing.median)
                if timing.repetitions > 1:
                    quartiles = f"{duration(timing.lower)} - {duration(timing.upper)}"
                if base is not None and not row.base:
                    ratio = f"{timing.median / base:.3g}"
            goals = [duration(row.target_seconds)] if row.target_seconds is not None else []
            goals += [f"{row.target_error:.0e}"] if row.target_error is not None else []
            remark = "; ".join(text for text in ("" if quick else row.verdict, row.note) if text)
            table.add_row(
                row.name,
                median,
                quartiles,
                ratio,
                "" if row.error is None else f"{row.error:.1e}",
                ", ".join(goals),
                remark,
                style="bold" if row.base else "",
            )
        console.print(table)
        console.print()
    console.print("ratio: how many times as long as the line in bold. A target is a time, a relative error.")


def duration(seconds: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def write(path: Path, rows: list[Row], spent: float, quick: bool) -> None:
    """Write beside and rename, so that no half-written file is left behind."""
    content: dict[str, Any] = {
        "quick": quick,
        "seconds": spent,
        "machine": {
            "system": platform.platform(),
            "processor": processor(),
            "cores": os.cpu_count(),
            "load": os.getloadavg() if hasattr(os, "getloadavg") else None,
            "python": platform.python_version(),
        },
        "versions": {name: version(name) for name in ("telespring", *PEERS)},
        "rows": [asdict(row) | {"verdict": row.verdict} for row in rows],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(path.name + ".partial")
    beside.write_text(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=True), encoding="utf-8")
    beside.replace(path)


def version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "")


if __name__ == "__main__":
    main()
