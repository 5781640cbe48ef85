"""The page of all commands and options, written from what the commands themselves say."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import typer

__all__ = ["commands", "options", "text", "write"]

_INTRODUCTION = """# Commands

`telespring --help` lists the commands, `telespring COMMAND --help` the options of one. This page is written
from the same source.

Values are in SI units unless you write another unit: `--delay 80ms`, `--stiffness "71 N/m"`. The exit status
is 0 if the question was answered, whatever the answer; 1 if a check asked for a stable dyad and it is not;
2 for input that was refused or a file that could not be read or written; 130 after Ctrl-C.
"""


def commands() -> dict[str, Any]:
    """Return the commands that the help lists, by name."""
    from telespring.cli import app

    group: Any = typer.main.get_command(app)
    return {name: command for name, command in group.commands.items() if not command.hidden}


def options(command: Any) -> list[Any]:
    """Return the options and arguments of a command that its help lists."""
    return [each for each in command.params if not each.hidden]


def _plain(markup: str) -> str:
    """Write a text of the help as Markdown: what would be markup there is text here."""
    lines = " ".join(markup.split())
    return re.sub(r"([*_<|\[\]])", r"\\\1", lines)


def _name(option: Any) -> str:
    if option.param_type_name == "argument":
        return f"`{option.metavar or option.name.upper()}`"
    names = ", ".join(f"`{name}`" for name in [*option.opts, *option.secondary_opts])
    return f"{names} {_plain(option.metavar)}" if option.metavar else names


def _default(option: Any) -> str:
    default = option.default
    if default is None or default is False or default == [] or default == () or not option.show_default:
        return ""
    if callable(default) or "[default:" in (option.help or ""):
        return ""
    shown = "yes" if default is True else getattr(default, "value", default)
    return f" *Default:* `{shown}`."


def _paragraph(markup: str) -> str:
    """Write a paragraph of the help as Markdown; an example is a command line."""
    lead, said, example = markup.strip().partition("Example: ")
    return _plain(markup) if lead or not said else f"Example: `{' '.join(example.split())}`"


def _section(name: str, command: Any) -> str:
    paragraphs = [_paragraph(part) for part in command.help.split("\n\n")]
    rows = [
        f"{_name(each)}\n: {_plain(each.help or '')}{_default(each)}\n"
        for each in options(command)
        if each.name != "help"
    ]
    return f"\n## telespring {name}\n\n" + "\n\n".join(paragraphs) + "\n\n" + "\n".join(rows)


def text() -> str:
    """Return the page in Markdown."""
    return _INTRODUCTION + "".join(_section(name, command) for name, command in commands().items())


def write(target: Path) -> None:
    """Write the page, if it would change."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists() or target.read_text(encoding="utf-8") != text():
        target.write_text(text(), encoding="utf-8")
