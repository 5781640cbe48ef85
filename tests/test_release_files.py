"""What a release is made of agrees with the project: versions, dependencies, tools, the workflow."""

from __future__ import annotations

import base64
import hashlib
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="module")
def project(root: Path) -> dict[str, Any]:
    return tomllib.loads((root / "pyproject.toml").read_text("utf-8"))


def version(root: Path) -> str:
    found: str = tomllib.loads((root / "Cargo.toml").read_text("utf-8"))["workspace"]["package"]["version"]
    return found


def test_law_the_recipe_has_the_version_and_the_dependencies(root: Path, project: dict[str, Any]) -> None:
    recipe = (root / "recipe" / "meta.yaml").read_text("utf-8")
    assert f'set version = "{version(root)}"' in recipe
    listed = recipe.split("  run:\n", 1)[1].split("\n\n", 1)[0]
    lines = [line.strip("- ").replace("matplotlib-base", "matplotlib") for line in listed.splitlines()]
    wanted = [
        f"python {project['project']['requires-python']}",
        *(re.sub(r"(?=>=)", " ", each) for each in project["project"]["dependencies"]),
    ]
    assert [line.split("    - ")[-1] for line in lines] == wanted
    [build] = project["build-system"]["requires"]
    assert f"- {build.replace('==', ' ==')}" in recipe


def test_law_the_newest_release_of_the_changelog_is_the_version(root: Path) -> None:
    released = re.findall(
        r"^## \[([0-9.]+)\] - \d{4}-\d\d-\d\d$", (root / "CHANGELOG.md").read_text("utf-8"), re.M
    )
    assert released[0] == version(root)


def test_law_the_workflow_pins_its_actions_and_calls_what_exists(root: Path) -> None:
    workflow = (root / ".github" / "workflows" / "release.yml").read_text("utf-8")
    used = re.findall(r"uses: (\S+)", workflow)
    assert len(used) > 5
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@v\d+\.\d+\.\d+", each) for each in used), used
    makefile = (root / "Makefile").read_text("utf-8")
    for target in re.findall(r"run: make ([a-z-]+)", workflow):
        assert re.search(rf"^{target}:", makefile, re.M), target
    for tool in re.findall(r"(tools/[\w.-]+)", workflow):
        assert (root / tool).is_file(), tool
    # Only the jobs that publish may write, or prove who they are.
    assert workflow.count("id-token: write") == 1
    assert workflow.count("contents: write") == 1
    assert "secrets." not in workflow


def made_wheel(path: Path, folder: str) -> Path:
    files = {
        "telespring/__init__.py": b"",
        "telespring-1.dist-info/sboms/a.cyclonedx.json": f'{{"ref": "path+file://{folder}/crates/a#1"}}'.encode(),
    }
    lines = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        lines.append(f"{name},sha256={digest},{len(content)}")
    files["telespring-1.dist-info/RECORD"] = (
        "\n".join([*lines, "telespring-1.dist-info/RECORD,,"]) + "\n"
    ).encode()
    with zipfile.ZipFile(path, "w") as wheel:
        for name, content in files.items():
            wheel.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), content)
    return path


def test_law_a_wheel_forgets_where_it_was_built(root: Path, tmp_path: Path) -> None:
    wheels: list[Path] = []
    for folder in ("/one/place", "/another place/of/mine"):
        path = made_wheel(tmp_path / f"{len(wheels)}.whl", folder.replace(" ", "%20"))
        subprocess.run([sys.executable, root / "tools" / "settle_wheel.py", path, folder], check=True)
        wheels.append(path)
    assert wheels[0].read_bytes() == wheels[1].read_bytes()
    with zipfile.ZipFile(wheels[0]) as wheel:
        record = wheel.read("telespring-1.dist-info/RECORD").decode().splitlines()
        for line in record[:-1]:
            name, digest, size = line.split(",")
            content = wheel.read(name)
            assert int(size) == len(content)
            stated = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            assert digest == f"sha256={stated}"
            assert b"place" not in content
