"""The blocks of code in the documents, and how they are run."""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from typer.testing import CliRunner

from telespring.cli import app

__all__ = [
    "WIDTH",
    "Block",
    "blocks_of",
    "command_lines",
    "documents",
    "run_console",
    "run_python",
    "same_output",
]

#: Columns of the terminal in which the documents' consoles were recorded.
WIDTH = 100

_NOT_RUN = re.compile(r"<!-- not run: (.+?) -->\s*")

_IS_SAME = doctest.OutputChecker().check_output


@dataclass(frozen=True)
class Block:
    """One block of code.

    `language` is what its fence says, or "indented"; `reason` says why it cannot be run here, and `output`
    what a block of text right behind it shows.
    """

    document: str
    line: int
    language: str
    text: str
    reason: str | None = None
    output: str | None = None

    def __str__(self) -> str:
        return f"{self.document}, line {self.line}"


def documents(root: Path) -> list[str]:
    """Return the paths of all documents, from the repository's folder."""
    written = [
        path.relative_to(root).as_posix()
        for pattern in ("*.md", "docs/**/*.md", "examples/*.md", "drivers/*/*.md")
        for path in sorted(root.glob(pattern))
    ]
    return [name for name in written if not name.startswith(("docs/node_modules/", "docs/_generated/"))]


def blocks_of(root: Path, document: str) -> list[Block]:
    """Return the blocks of a document, in their order."""
    tokens = MarkdownIt().parse((root / document).read_text(encoding="utf-8"))
    found: list[Block] = []
    for number, token in enumerate(tokens):
        if token.type not in ("fence", "code_block"):
            continue
        before = tokens[number - 1] if number else None
        marked = (
            _NOT_RUN.fullmatch(before.content) if before is not None and before.type == "html_block" else None
        )
        language = token.info.split()[0] if token.type == "fence" and token.info.strip() else ""
        if language.startswith("{"):
            continue  # a directive of the site, such as its table of contents
        after = tokens[number + 1] if number + 1 < len(tokens) else None
        shown = after.content if language == "python" and after is not None and after.info == "text" else None
        assert token.map is not None
        found.append(
            Block(
                document,
                token.map[0] + 1,
                language if token.type == "fence" else "indented",
                token.content,
                marked[1] if marked else None,
                shown,
            )
        )
    return found


def same_output(shown: str, printed: str) -> bool:
    """Return whether a program printed what is shown; dots stand for anything, blanks count as one."""
    options = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    # "..." at the start of an expected output would be a prompt
    return _IS_SAME("-\n" + shown, "-\n" + printed, options)


def run_python(block: Block, names: dict[str, Any]) -> str:
    """Run a block among the names of those before it, and return what it prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        # line numbers of a failure are those of the document
        source = "\n" * block.line + block.text
        exec(compile(source, block.document, "exec"), names)
    return printed.getvalue()


def _conversations(text: str) -> Iterator[tuple[str, str]]:
    """Split a console into commands and what each shows."""
    command, shown = "", list[str]()
    for line in text.splitlines():
        if line.startswith("$ "):
            if command:
                yield command, "\n".join(shown)
            command, shown = line[2:], []
        elif command.endswith("\\"):
            command = command[:-1] + line.strip()
        else:
            shown.append(line)
    if command:
        yield command, "\n".join(shown)


def run_console(block: Block) -> list[str]:
    """Run the commands of a console in the current folder, and return what differs from what it shows."""
    differences = []
    for command, shown in _conversations(block.text):
        words = shlex.split(command, comments=True)
        words = [each for word in words for each in (sorted(map(str, Path().glob(word))) or [word])]
        if words[0] == "cat":
            printed, status = "".join(Path(word).read_text(encoding="utf-8") for word in words[1:]), 0
        else:
            assert words[0] == "telespring", f"{block}: only telespring and cat are run, not {words[0]}"
            result = CliRunner(env={**os.environ, "COLUMNS": str(WIDTH)}).invoke(app, words[1:])
            printed, status = result.output, result.exit_code
        if shown.strip() and not same_output(shown + "\n", printed):
            differences.append(f"{block}: {command}\nshown:\n{shown}\nprinted:\n{printed}")
        elif status not in (0, 1) and "rc" not in shown:
            differences.append(f"{block}: {command} ended with {status}:\n{printed}")
    return differences


def command_lines(block: Block) -> Iterator[list[str]]:
    """Return the words of each line of a block that calls telespring."""
    for line in block.text.splitlines():
        called = re.match(r"(?:\$ )?(telespring [a-z].*)", line.strip())
        if called:
            yield called[1].split()
