"""Files of another kind that a command is given by mistake: which command takes them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from telespring._errors import InvalidInput

__all__ = ["naming_the_file", "pointing_elsewhere"]

_Kind = Literal["robot file", "study", "trial", "list of trials", "folder", "log"]
_TABLES = {".csv", ".txt", ".tsv", ".dat"}

#: What to do with a file of a kind that a command does not take.
_REMEDIES: dict[tuple[str, _Kind], str] = {
    (
        "identify",
        "robot file",
    ): "This is a robot file, which identify has written already: give it to telespring "
    "decide --robot {file}.",
    ("identify", "study"): "This is a study, which has no measurements: give it to telespring decide {file}.",
    (
        "identify",
        "trial",
    ): "This is a recorded trial of two robots: telespring analyse {folder} compares trials.",
    ("identify", "list of trials"): "This is a list of trials: telespring analyse {folder} compares them.",
    ("identify", "folder"): "Name the logs in it, such as {file}/log.csv. Trials are for telespring analyse.",
    ("analyse", "robot file"): "This is a robot file: give it to telespring decide --robot {file}.",
    (
        "analyse",
        "study",
    ): "This is a study: telespring rehearse {file} makes trials of it; recorded trials without "
    "a target take it as --study {file}.",
    ("analyse", "trial"): "This is one trial. List all of them in trials.csv beside it and name the folder: "
    "telespring analyse {folder}.",
    (
        "analyse",
        "log",
    ): "If this is a log of one robot, make a robot file of it: telespring identify {file} --out "
    "robot.toml. If these are trials, telespring analyse --template DIR writes an example of the layout.",
}


@contextmanager
def pointing_elsewhere(command: Literal["identify", "analyse"], files: Iterable[Path]) -> Iterator[None]:
    """Say which command takes a file that this one has refused, if it is of another kind."""
    try:
        yield
    except InvalidInput as refused:
        is_about_the_file = command == "analyse" or refused.field in {"log", "--position", "--time"}
        for file in files if is_about_the_file else ():
            kind = _kind(file)
            remedy = None if kind is None else _REMEDIES.get((command, kind))
            if remedy is not None:
                pointed = refused.at(refused.field)
                pointed.remedy = remedy.format(file=file, folder=file.parent)
                raise pointed from None
        raise


def naming_the_file(refused: InvalidInput, study: Path | None) -> InvalidInput:
    """Write the name of the file into a remedy that speaks of FILE or LOG."""
    file = str(study) if refused.field == "study" and study is not None else refused.field
    if not Path(file).is_file():
        return refused
    named = refused.at(refused.field)
    named.remedy = re.sub(r"\b(?:FILE|LOG)\b", lambda _: file, refused.remedy)
    return named


def _kind(file: Path) -> _Kind | None:
    """Recognise a file by its first line or its sections."""
    if file.is_dir():
        return "folder"
    suffix = file.suffix.lower()
    if suffix in {".mat", ".parquet"}:
        return "log"
    try:
        with file.open(encoding="utf-8-sig", errors="replace") as text:
            lines = [line.strip().lower() for line in text.readlines(1 << 16)]
    except OSError:
        return None
    if suffix == ".toml":
        if "[robot]" in lines:
            return "robot file"
        return (
            "study" if any(re.match(r"\[?(robot[12]|coupling|network)\b", line) for line in lines) else None
        )
    if suffix not in _TABLES:
        return None
    first = next((line for line in lines if line and line[0] not in "#%"), "")
    names = [name.strip(" \"'") for name in re.split("[,;\t]", first)]
    if any(name.startswith("position_robot") for name in names):
        return "trial"
    return "list of trials" if "file" in names else "log"
