"""Takes the folder in which a wheel was built out of its bill of materials:  settle_wheel.py WHEEL FOLDER.

Maturin names the crates of the workspace there by their paths. Every other byte and date stays.
"""

from __future__ import annotations

import base64
import hashlib
import sys
import zipfile
from pathlib import Path

SETTLED = "/telespring"


def settle(wheel: Path, folder: str) -> None:
    """Rewrite the bills of materials, and their lines in RECORD."""
    with zipfile.ZipFile(wheel) as old:
        entries = [(entry, old.read(entry)) for entry in old.infolist()]
    beside = wheel.with_suffix(".settled")
    lines: dict[str, str] = {}
    with zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED) as new:
        for entry, content in entries:
            if "/sboms/" in entry.filename:
                text = content.decode().replace(f"file://{folder}/", f"file://{SETTLED}/")
                content = text.replace(f"file://{folder.replace(' ', '%20')}/", f"file://{SETTLED}/").encode()
                digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                lines[entry.filename] = f"{entry.filename},sha256={digest},{len(content)}"
            elif entry.filename.endswith(".dist-info/RECORD"):
                # The last file of a wheel: its lines are of those before.
                record = [lines.get(line.split(",", 1)[0], line) for line in content.decode().splitlines()]
                content = ("\n".join(record) + "\n").encode()
            new.writestr(entry, content)
    beside.replace(wheel)


if __name__ == "__main__":
    settle(Path(sys.argv[1]), sys.argv[2])
