#!/bin/sh
# Checks the wheel as a new user has it:  check-wheel.sh FOLDER [--twice]
#
# FOLDER is where build-wheel.sh put it. It is installed into a fresh environment, without Rust on the PATH, and used. With
# --twice it is first built once more, from the source distribution in another folder: both wheels must be equal.
# WITHOUT_PAGE, if set, is content with a wheel without the page.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
folder=$(cd "$1" && pwd)
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml" | head -n 1)
wheel=$(ls "$folder"/telespring-"$version"-cp311-abi3-manylinux*2_17*.whl)
sdist=$(ls "$folder"/telespring-"$version".tar.gz)

fail() {
    echo "check-wheel: $1" >&2
    exit 1
}

# Size: 5 MB with the page.
bytes=$(wc -c <"$wheel")
echo "wheel: $bytes bytes"
[ "$bytes" -le 5000000 ] || fail "$wheel has $bytes bytes, more than 5 MB"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

if [ "${2-}" = --twice ]; then
    BUILD=$work/elsewhere sh "$root/tools/build-wheel.sh" "$work/again" "$sdist"
    cmp "$wheel" "$work"/again/*.whl || fail "two builds in two folders differ"
    echo "two builds: equal, $(sha256sum "$wheel" | cut -d ' ' -f 1)"
fi

# What must be in it, and what must not.
python=$("$root"/tools/check-toolchain.sh --python)
"$python" - "$wheel" "$sdist" "$root" <<'PYTHON'
import json, os, pathlib, re, sys, tarfile, zipfile
wheel, sdist, root = sys.argv[1:]
inside = zipfile.ZipFile(wheel)
names = inside.namelist()
page = () if os.environ.get("WITHOUT_PAGE") else ("telespring/assets/telespring.html",)
for wanted in ("telespring/_core.abi3.so", "telespring/py.typed", "telespring/references/du2025.toml", *page):
    assert wanted in names, f"{wanted} is not in the wheel"
information = f"{pathlib.Path(wheel).name.split('-cp311')[0]}.dist-info"
for wanted in ("LICENSE", "LICENSE-linked-crates.txt", "LICENSE-rust-library.html"):
    assert f"{information}/licenses/{wanted}" in names, f"{wanted} is not in the wheel"
    assert f"License-File: {wanted}\n" in inside.read(f"{information}/METADATA").decode(), f"METADATA does not name {wanted}"
# What was built is what the licences are of.
[bill] = [json.loads(inside.read(name)) for name in names if name.startswith(f"{information}/sboms/")]
crates = {f"{each['name']} {each['version']}" for each in bill["components"]}
licences = inside.read(f"{information}/licenses/LICENSE-linked-crates.txt").decode()
linked = set(re.findall(r"^[\w-]+ \d+\.\d+\.\d+\S*$", licences, re.M))
assert len(linked) > 30 and linked <= crates, f"the bill of materials lacks {linked - crates}"
for name in names:
    content = inside.read(name)
    for path in (root, str(pathlib.Path.home())):
        assert path == "/" or path.encode() not in content, f"{name} has the path {path}"
sources = tarfile.open(sdist).getnames()
for wanted in ("Cargo.lock", "crates/telespring/src/lib.rs", "pyproject.toml", "LICENSE"):
    assert any(name.split("/", 1)[-1] == wanted for name in sources), f"{wanted} is not in the sdist"
print(f"wheel: {len(names)} files; sdist: {len(sources)} files")
PYTHON

# A fresh environment, and a PATH without Rust, a compiler or make.
"$python" -m venv "$work/venv"
here=$work/venv/bin
"$here/python" -m pip install --disable-pip-version-check --quiet --constraint "$root/requirements/run.txt" "$wheel"
cd "$work"
clean() {
    env -i HOME="$work" PATH="$here" LANG=C.UTF-8 MPLCONFIGDIR="$work/mpl" "$@"
}
clean "$here/pip" --disable-pip-version-check check
[ "$(clean telespring --version)" = "telespring $version" ] || fail "telespring --version is not $version"

"$python" - "$root/README.md" >first.py <<'PYTHON'
import re, sys
print(re.search(r"```python\n(.*?)```", open(sys.argv[1], encoding="utf-8").read(), re.S)[1])
PYTHON
clean "$here/python" first.py
clean telespring decide --robot 1.2,6 --robot 2,9 --ping 80ms
clean telespring reproduce --quick
[ -s out/study-quick/report.html ] || fail "reproduce --quick wrote no report"
if [ -z "${WITHOUT_PAGE-}" ]; then
    clean telespring explore --robot 1.2,6 --robot 2,9 --ping 80ms --save page.html
    grep -q 'id="study">study=' page.html || fail "the page of explore has no study"
fi

# Import: the processor's time, the best of five, so that what else the machine does counts little. Told, not judged: a busy
# machine takes longer. tests/test_surface.py says what is not imported.
clean "$here/python" - <<'PYTHON'
import resource, subprocess, sys
def used():
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime
def run(code):
    before = used()
    subprocess.run([sys.executable, "-c", code], check=True)
    return used() - before
spent = min(run("import telespring") for _ in range(5)) - min(run("") for _ in range(5))
print(f"import: {spent:.3f} s of a processor (at most 0.25 s on a machine with nothing else to do)")
PYTHON
echo "check-wheel: all well"
