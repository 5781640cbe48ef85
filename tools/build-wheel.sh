#!/bin/sh
# Builds the wheel and the source distribution:  build-wheel.sh FOLDER [SOURCES]
#
# SOURCES is an unpacked source distribution, by default this repository.
# The wheel runs on every Linux with glibc 2.17 (2012) or newer and Python 3.11 or newer. The same sources and tools give the
# same bytes, in whatever folder and whenever: paths are mapped away, and the only date is that of the sources.
#
# MATURIN, if set, is the program to build with; TARGET, if set, the machine to build for, as rustc names it.
set -eu

folder=$(mkdir -p "$1" && cd "$1" && pwd)
tools=$(cd "$(dirname "$0")" && pwd)
cd "${2:-$tools/..}"
root=$(pwd)
case $root in *[[:space:]]*)
    echo "build-wheel: $root has a space in its name, which flags of rustc cannot have." >&2
    exit 1
    ;;
esac
maturin=${MATURIN:-$tools/../.venv/bin/maturin}
# zig and its linker are a Python package next to maturin
PATH=$(dirname "$maturin"):$PATH
export PATH

# The date of the last change; without git, that of the newest release in the changelog.
if [ -z "${SOURCE_DATE_EPOCH-}" ]; then
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || true)
fi
if [ -z "$SOURCE_DATE_EPOCH" ]; then
    day=$(sed -n 's/^## \[[0-9.]*\] - \([0-9-]*\)$/\1/p' CHANGELOG.md | head -n 1)
    SOURCE_DATE_EPOCH=$(date -u -d "${day:-2026-01-01}" +%s)
fi
export SOURCE_DATE_EPOCH

# Names of files are in the messages of a panic.
cargo_home=${CARGO_HOME:-$HOME/.cargo}
RUSTFLAGS="--remap-path-prefix=$root=/telespring --remap-path-prefix=$cargo_home=/cargo"
RUSTFLAGS="$RUSTFLAGS --remap-path-prefix=$(rustc --print sysroot)=/rust"
export RUSTFLAGS
# A folder of its own: other flags would make cargo build everything else anew each time.
CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target/wheel}
export CARGO_TARGET_DIR

python=$(dirname "$maturin")/python
# A source distribution has the lock of the whole workspace, and cargo takes out of it what it lacks.
if [ $# -lt 2 ]; then
    set -- --locked --sdist
else
    set --
fi
if [ -n "${TARGET-}" ]; then
    set -- "$@" --target "$TARGET"
fi
"$maturin" build --release --zig --compatibility manylinux_2_17 --out "$folder" "$@"
for wheel in "$folder"/*.whl; do
    "$python" "$tools/settle_wheel.py" "$wheel" "$root"
done
