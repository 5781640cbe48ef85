"""Published numbers, one TOML file per source, named by its citation key; values with unit and place."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

__all__ = ["read_reference"]


@cache
def read_reference(citation_key: str) -> dict[str, Any]:
    """Read the numbers of one source, such as "du2025".

    Examples
    --------
    >>> read_reference("du2025")["table3"]["base"]["M"]["value"]
    0.8334
    """
    return tomllib.loads(files(__name__).joinpath(f"{citation_key}.toml").read_text(encoding="utf-8"))
