"""Where the live program is."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from telespring._core import __version__
from telespring._errors import InvalidInput

__all__ = ["find_program"]

_NAME = "telespring-link"
_VARIABLE = "TELESPRING_LINK"
#: How long the program may take to say its version, s.
_PATIENCE = 20.0


def find_program() -> Path:
    """Find the live program: where ``$TELESPRING_LINK`` says, in this checkout, or on the path.

    Raises
    ------
    InvalidInput
        If this is not Linux, or there is no program that runs and has the version of the package.
    """
    if sys.platform != "linux":
        raise InvalidInput(
            "the system", sys.platform, "a live session needs the clocks of Linux", "Run it on Linux."
        )
    program = _candidate()
    found = _version(program)
    if found != __version__:
        raise InvalidInput(
            _NAME,
            str(program),
            f"it has version {found or 'unknown'}, and this package {__version__}",
            f"Run `make link` in the sources of telespring {__version__}.",
        )
    return program


def _candidate() -> Path:
    named = os.environ.get(_VARIABLE)
    if named:
        program = Path(named)
        if not (program.is_file() and os.access(program, os.X_OK)):
            raise InvalidInput(
                f"${_VARIABLE}", named, "the live program, a file that can be run", "Correct or unset it."
            )
        return program
    # The package of a checkout is in python/telespring.
    built = Path(__file__).parents[3] / "target" / "release" / _NAME
    on_path = shutil.which(_NAME)
    if built.is_file():
        return built
    if on_path is not None:
        return Path(on_path)
    raise InvalidInput(
        _NAME,
        "",
        f"the live program, which is no part of a wheel; not in ${_VARIABLE}, {built.parent} or the PATH",
        "`make link` builds it in the folder of telespring's sources; `make link-static` makes one file "
        "for other machines. Put it on the PATH.",
    )


def _version(program: Path) -> str:
    try:
        said = subprocess.run(
            [program, "--version"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PATIENCE,
            check=True,
            text=True,
        ).stdout
    except (OSError, subprocess.SubprocessError, UnicodeDecodeError) as error:
        raise InvalidInput(
            _NAME, str(program), f"it does not run ({error})", "Build it anew with `make link`."
        ) from None
    name, _, version = said.strip().partition(" ")
    return version if name == _NAME else ""
