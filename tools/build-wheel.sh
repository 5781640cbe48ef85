#!/bin/sh
# Builds the source distribution, and the wheel from it:  build-wheel.sh FOLDER [SDIST]
#
# With SDIST, one that was built before, only the wheel. It runs on every Linux with glibc 2.17 (2012) or newer and Python 3.11 or
# newer. The same sources and tools give the same bytes, in whatever folder and whenever: paths are mapped away, and the only date
# is that of the sources. It is built from the source distribution, because the whole workspace resolves to more dependencies, which
# the bill of materials would list.
#
# The page (make page) and the licences of what is linked are inside. WITHOUT_PAGE, if set, leaves the page out: such a wheel is no
# release. MATURIN is the program to build with; TARGET the machine to build for, as rustc names it; BUILD the folder to build in.
set -eu

folder=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$(dirname "$0")/.."
root=$(pwd -P)
maturin=${MATURIN:-$root/.venv/bin/maturin}
# as cargo sees it, without links
build=${BUILD:-$root/target/wheel}
build=$(mkdir -p "$build" && cd "$build" && pwd -P)
case $build in *[[:space:]]*)
    echo "build-wheel: $build has a space in its name, which flags of rustc cannot have: name another folder in BUILD." >&2
    exit 1
    ;;
esac
# zig and its linker are a Python package next to maturin
PATH=$(dirname "$maturin"):$PATH
export PATH

page=python/telespring/assets/telespring.html
if [ -n "${WITHOUT_PAGE-}" ]; then
    echo "build-wheel: a wheel WITHOUT the page: telespring explore will refuse. It is no release." >&2
elif [ -z "${2-}" ] && [ ! -s "$page" ]; then
    echo "build-wheel: no page in $page, and a wheel without it is no release: run 'make page' (it needs Rust's library for" >&2
    echo "WebAssembly: 'rustup target add wasm32-unknown-unknown'). WITHOUT_PAGE=1 leaves it out." >&2
    exit 1
fi

# The date of the last change; without git, that of the newest release in the changelog.
if [ -z "${SOURCE_DATE_EPOCH-}" ]; then
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || true)
fi
if [ -z "$SOURCE_DATE_EPOCH" ]; then
    day=$(sed -n 's/^## \[[0-9.]*\] - \([0-9-]*\)$/\1/p' CHANGELOG.md | head -n 1)
    SOURCE_DATE_EPOCH=$(date -u -d "${day:-2026-01-01}" +%s)
fi
export SOURCE_DATE_EPOCH

sdist=${2-}
if [ -z "$sdist" ]; then
    "$maturin" sdist --out "$folder"
    sdist=$(ls "$folder"/telespring-*.tar.gz)
fi
rm -rf "$build/sources" "$build/out"
mkdir "$build/sources"
tar xzf "$sdist" -C "$build/sources" --strip-components 1

# The wheel takes every file LICENSE* beside pyproject.toml: these two are of what rustc links into it.
sysroot=$(rustc --print sysroot)
notices=$(ls "$sysroot"/share/doc/rust*/COPYRIGHT-library.html 2>/dev/null | head -n 1)
if [ -z "$notices" ]; then
    echo "build-wheel: this Rust has no COPYRIGHT-library.html, the licences of its library: install one with rustup, 1.85 or newer." >&2
    exit 1
fi
cp "$notices" "$build/sources/LICENSE-rust-library.html"
"$(dirname "$maturin")/python" tools/gather_licences.py telespring-py "${TARGET:-$(rustc -vV | sed -n 's/^host: //p')}" \
    >"$build/sources/LICENSE-linked-crates.txt"

# Names of files are in the messages of a panic.
RUSTFLAGS="--remap-path-prefix=$build/sources=/telespring --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo"
RUSTFLAGS="$RUSTFLAGS --remap-path-prefix=$sysroot=/rust"
export RUSTFLAGS
# A folder of its own: other flags would make cargo build everything else anew each time.
CARGO_TARGET_DIR=$build/target
export CARGO_TARGET_DIR

set -- --release --zig --compatibility manylinux_2_17 --out "$build/out"
if [ -n "${TARGET-}" ]; then
    set -- "$@" --target "$TARGET"
fi
(cd "$build/sources" && "$maturin" build "$@")

# The lock is that of the whole workspace: cargo took out of it what the sources lack, and must have changed nothing else.
pairs() {
    sed -n '/^name = /{N;s/\n/ /p;}' "$1" | sort
}
pairs Cargo.lock >"$build/locked"
pairs "$build/sources/Cargo.lock" | comm -23 - "$build/locked" >"$build/unlocked"
if [ -s "$build/unlocked" ]; then
    echo "build-wheel: built with versions that Cargo.lock does not have:" >&2
    cat "$build/unlocked" >&2
    exit 1
fi

for wheel in "$build"/out/*.whl; do
    "$(dirname "$maturin")/python" tools/settle_wheel.py "$wheel" "$build/sources"
    mv "$wheel" "$folder"
done
