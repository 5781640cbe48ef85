"""Report modules of the package that import the package itself instead of the room that they need.

`telespring/__init__.py` imports everything, so importing it creates a cycle. import-linter
cannot detect this: it treats an import of the compiled `telespring._core` as one of `telespring`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "python" / "telespring"


def imports_of_the_package(source: str, package: Path = PACKAGE) -> Iterator[int]:
    """List the lines of a module that import `telespring` itself, at any depth."""
    submodules = {entry.name.split(".")[0] for entry in package.iterdir()} | {"_core"}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            if any(alias.name == package.name for alias in node.names):
                yield node.lineno
        elif isinstance(node, ast.ImportFrom):
            from_package = node.module == package.name and any(
                alias.name not in submodules for alias in node.names
            )
            # A relative import could refer to the package without naming it.
            if from_package or node.level > 0:
                yield node.lineno


def main() -> int:
    """Print every such line, and return 1 if there is one."""
    lines = [
        f"{path.relative_to(PACKAGE.parent.parent)}:{line}: import the room, not the whole package"
        for path in sorted(PACKAGE.rglob("*.py"))
        if path != PACKAGE / "__init__.py"
        for line in imports_of_the_package(path.read_text(encoding="utf-8"))
    ]
    print("\n".join(lines), end="\n" if lines else "")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
