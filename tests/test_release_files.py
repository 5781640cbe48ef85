"""What a release is made of agrees with the project: versions, dependencies, tools, the workflow."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
from rattler_build import Stage0Recipe, VariantConfig


@pytest.fixture(scope="module")
def project(root: Path) -> dict[str, Any]:
    return tomllib.loads((root / "pyproject.toml").read_text("utf-8"))


def version(root: Path) -> str:
    found: str = tomllib.loads((root / "Cargo.toml").read_text("utf-8"))["workspace"]["package"]["version"]
    return found


def test_law_the_recipe_has_the_version_and_the_dependencies(root: Path, project: dict[str, Any]) -> None:
    [package] = rendered(root / "recipe" / "recipe.yaml")
    assert package["package"] == {"name": "telespring", "version": version(root)}
    depends = package["requirements"]
    assert [each.replace("matplotlib-base", "matplotlib") for each in depends["run"]] == [
        f"python {project['project']['requires-python']}",
        *(re.sub(r"(?=>=)", " ", each) for each in project["project"]["dependencies"]),
    ]
    [build] = project["build-system"]["requires"]
    assert build.replace("==", " ==") in depends["host"]
    rust = tomllib.loads((root / "Cargo.toml").read_text("utf-8"))["workspace"]["package"]["rust-version"]
    assert f"rust >={rust}" in depends["build"]
    [command] = project["project"]["scripts"].items()
    assert package["build"]["python"]["entry_points"] == [" = ".join(command)]


def rendered(recipe: Path) -> list[dict[str, Any]]:
    """Return what the builder of conda packages makes of a recipe; it refuses what it does not know."""
    variants = {
        "python": ["3.11.*"],
        "c_compiler": ["gcc"],
        "c_stdlib": ["sysroot"],
        "rust_compiler": ["rust"],
    }
    made = Stage0Recipe.from_file(recipe).render(VariantConfig(variants))
    return [each.recipe.to_dict() for each in made]


def test_law_a_recipe_with_a_slip_is_refused(root: Path, tmp_path: Path) -> None:
    recipe = (root / "recipe" / "recipe.yaml").read_text("utf-8")
    slip = tmp_path / "recipe.yaml"
    slip.write_text(recipe.replace("license_file:", "licence_file:"), encoding="utf-8")
    with pytest.raises(Exception, match="licence_file"):
        rendered(slip)


def test_law_the_newest_release_of_the_changelog_is_the_version(root: Path) -> None:
    released = re.findall(
        r"^## \[([0-9.]+)\] - \d{4}-\d\d-\d\d$", (root / "CHANGELOG.md").read_text("utf-8"), re.M
    )
    assert released[0] == version(root)


def test_law_the_workflow_pins_its_actions_and_calls_what_exists(root: Path) -> None:
    workflow = (root / ".github" / "workflows" / "release.yml").read_text("utf-8")
    used = re.findall(r"uses: (.+)", workflow)
    assert len(used) > 5
    # a tag can be moved, a commit cannot
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", each) for each in used), used
    makefile = (root / "Makefile").read_text("utf-8")
    for target in re.findall(r"run: make ([a-z-]+)", workflow):
        assert re.search(rf"^{target}:", makefile, re.M), target
    for tool in re.findall(r"(tools/[\w.-]+)", workflow):
        assert (root / tool).is_file(), tool
    # Only the jobs that publish may write, or prove who they are.
    assert workflow.count("id-token: write") == 1
    assert workflow.count("contents: write") == 1
    assert "secrets." not in workflow


def test_law_the_linter_of_workflows_finds_nothing(root: Path, tmp_path: Path) -> None:
    workflow = root / ".github" / "workflows" / "release.yml"
    assert lint(workflow) == 0
    # and it would: a tag's name put into a script is run as part of it
    loose = tmp_path / ".github" / "workflows" / "release.yml"
    loose.parent.mkdir(parents=True)
    text = workflow.read_text("utf-8")
    loose.write_text(text.replace('= "$TAG"', '= "${{ github.ref_name }}"'), encoding="utf-8")
    assert loose.read_text("utf-8") != text
    assert lint(loose) != 0


def lint(workflow: Path) -> int:
    folders = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    program = shutil.which("zizmor", path=folders)
    assert program is not None, "zizmor is of requirements/test.txt"
    return subprocess.run([program, "--offline", "--no-progress", str(workflow)], check=False).returncode


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
