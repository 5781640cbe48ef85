"""The command `telespring merge`: two recordings of a live session, or the shares of some long work."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from telespring._errors import InvalidInput
from telespring.cli.common import print_json
from telespring.cli.figure_file import check_not_an_input
from telespring.cli.resuming import resuming
from telespring.cli.terminal import screen_console, show

__all__ = ["merge_command"]


def merge_command(
    parts: Annotated[
        list[Path],
        typer.Argument(
            metavar="A.mcap B.mcap | FOLDER...",
            help="The recordings of both sites; or the folders of shares, or the folder that contains them.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            metavar="SESSION.mcap | FOLDER",
            help="Where to write the merged recording, or the result of the shares.",
            show_default="of shares, the folder that contains them",
        ),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(
            "--study",
            metavar="STUDY.toml",
            help="The study of the shares, if it has agents, targets or traces beside it and ran elsewhere.",
        ),
    ] = None,
    zarr: Annotated[bool, typer.Option("--zarr", help="Write the result of a sweep as sweep.zarr.")] = False,
    progress: Annotated[
        bool, typer.Option("--progress", help="Say how far each share is, and merge nothing.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print JSON in SI units instead of the sentences.")
    ] = False,
) -> None:
    """Put together both recordings of a live session, or the shares of long work.

    Recordings come on one time base. The clocks are compared by what each site knew of the other's; the rest
    is stated as the uncertainty of the common time.

    Shares, which `rehearse`, `compare` and `sweep` run with --shard, become the result that one machine
    makes.

    Example: telespring merge site1.mcap site2.mcap --out session.mcap

    Example: telespring merge out/sweep
    """
    if any(part.is_dir() for part in parts):
        if progress:
            _say_progress(parts, as_json=as_json)
        else:
            _merge_shares(parts, out, study, as_zarr=zarr, as_json=as_json)
        return
    _merge_recordings(parts, out, as_json=as_json)


def _merge_recordings(parts: list[Path], out: Path | None, *, as_json: bool) -> None:
    from telespring.analysis.sessions import recording_facts
    from telespring.recording import merge_recordings
    from telespring.show.screens.session import merge_screen

    if len(parts) != 2:
        raise InvalidInput(
            "A.mcap B.mcap",
            ", ".join(map(str, parts)),
            "merge needs two recordings, or folders of shares",
            "Name the recordings of both sites of one session, which telespring connect prints; or the "
            "folder that was given as --out with --shard.",
        )
    if out is None:
        raise InvalidInput("--out", "", "a file for the merged recording", "Write --out session.mcap.")
    check_not_an_input("--out", out, parts)
    found = recording_facts(merge_recordings(parts[0], parts[1], out))
    if as_json:
        print_json(found | {"out": str(out)})
    else:
        show(merge_screen(found, str(out)))


def _say_progress(parts: list[Path], *, as_json: bool) -> None:
    from telespring.show.screens.shards import missing_shares, share_progress_screen
    from telespring.sweeps.merging import share_progress

    shares = share_progress(parts)
    if as_json:
        begun = [
            {"shard": str(each.facts.shard), "finished": each.finished, "all": each.facts.trials}
            for each in shares
        ]
        not_begun = [{"shard": str(each), "finished": 0, "all": None} for each in missing_shares(shares)]
        print_json(begun + not_begun)
    else:
        show(share_progress_screen(shares, parts))


def _merge_shares(
    parts: list[Path], out: Path | None, study: Path | None, *, as_zarr: bool, as_json: bool
) -> None:
    from telespring.cli.compare import show_comparison
    from telespring.cli.sweep import show_sweep
    from telespring.comparison import Comparison
    from telespring.model import Study
    from telespring.sweeps.merging import merge_shares
    from telespring.sweeps.run import SweepOutcome

    console = screen_console(stderr=as_json)
    if study is not None and not study.is_file():
        raise InvalidInput(
            "--study", str(study), "a study file is required", "Name the study that the shares ran."
        )
    modules = None if study is None else study.parent
    with resuming(console, out or parts[0], "results") as progress:
        merged = merge_shares(parts, out, modules=modules, as_zarr=as_zarr, progress=progress)
    if isinstance(merged, Comparison):
        if as_json:
            print_json(merged.to_dict() | {"folder": str(merged.folder)})
        else:
            show_comparison(console, merged, Study.from_toml(str(merged.dataset.attrs["study"])).dyad)
        return
    if isinstance(merged, SweepOutcome):
        show_sweep(console, merged, None, as_zarr=as_zarr, as_json=as_json)
        return
    if as_json:
        print_json({"results": merged.trials, "dataset": str(merged.dataset)})
        return
    console.print(f"{merged.trials} results put together", markup=False)
    console.print(f"Dataset: {merged.dataset}", markup=False)
