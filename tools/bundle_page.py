"""Bundle the page: its modules, style and WebAssembly core as one HTML file that needs no server.

    tools/bundle_page.py CORE.wasm OUT.html

The modules of `page/` are joined in the order of their imports. They share one scope, so no name may be
defined in two of them; that is checked. The licences of what is inside stand in a comment, since the page
is handed on alone.
"""

from __future__ import annotations

import base64
import gzip
import re
import sys
from pathlib import Path

from gather_licences import licences

PAGE = Path(__file__).resolve().parent.parent / "page"
_IMPORT = re.compile(r'^import \{[^}]*\} from "\./(?P<name>[a-z]+\.js)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:const|function|class|async|let) )", re.MULTILINE)
_NAME = re.compile(r"^(?:export )?(?:async )?(?:const|let|function|class) (\w+|\{[^}]*\})", re.MULTILINE)


def modules(first: str = "main.js") -> dict[str, str]:
    """Return the modules that one needs, and itself, by name: each after those that it imports."""
    found: dict[str, str] = {}

    def add(name: str, path: tuple[str, ...]) -> None:
        if name in path:
            raise SystemExit(f"page: {' imports '.join([*path, name])}")
        if name in found:
            return
        source = (PAGE / name).read_text(encoding="utf-8")
        for match in _IMPORT.finditer(source):
            add(match["name"], (*path, name))
        found[name] = source

    add(first, ())
    return found


def script(sources: dict[str, str]) -> str:
    """Join modules into one script, which keeps its names to itself."""
    owners: dict[str, str] = {}
    for module, source in sources.items():
        for name in _NAME.findall(source):
            if name in owners:
                raise SystemExit(f"page: {module} and {owners[name]} both define {name}")
            owners[name] = module
    parts = [_EXPORT.sub("", _IMPORT.sub("", source)) for source in sources.values()]
    for module, part in zip(sources, parts, strict=True):
        if re.search(r"^(?:import|export)\b", part, re.MULTILINE):
            raise SystemExit(f"page: {module} has an import or export of a form that is not bundled")
    joined = "\n".join(parts)
    if "</script" in joined.lower():
        raise SystemExit("page: a module contains </script")
    return f'(() => {{\n"use strict";\n{joined}}})();'


def own_licence() -> str:
    """Return the licence of the page itself."""
    return f"telespring\n\n{(PAGE.parent / 'LICENSE').read_text(encoding='utf-8')}\n"


def comment(text: str) -> str:
    """Return a text as it may stand in a comment of HTML."""
    if re.search("-->|--!>", text):
        raise SystemExit("page: a licence contains the end of a comment")
    return text.strip()


def bundle(core: bytes) -> str:
    """Return the page as one text."""
    page = (PAGE / "page.html").read_text(encoding="utf-8")
    parts = {
        "/* STYLE */": (PAGE / "style.css").read_text(encoding="utf-8").strip(),
        "/* CORE */": base64.b64encode(gzip.compress(core, 9, mtime=0)).decode("ascii"),
        "/* SCRIPT */": script(modules()),
        "/* LICENCES */": comment(own_licence() + licences("telespring-wasm", "wasm32-unknown-unknown")),
    }
    for mark, part in parts.items():
        if page.count(mark) != 1:
            raise SystemExit(f"page: page.html must contain {mark} once")
        page = page.replace(mark, part)
    return page


def main() -> None:
    """Write the page; the arguments are the core and the file to write."""
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    core, out = map(Path, sys.argv[1:])
    out.parent.mkdir(parents=True, exist_ok=True)
    text = bundle(core.read_bytes())
    out.write_text(text, encoding="utf-8")
    print(f"{out}: {len(text.encode()) / 1000:.0f} kB")


if __name__ == "__main__":
    main()
