#!/bin/sh
# Builds the core of the page as WebAssembly: build-wasm.sh OUT.wasm
# Says by its exit status whether it can without Debian's compiler: build-wasm.sh --ready
#
# Needs the standard library of Rust for wasm32-unknown-unknown: 'rustup target add wasm32-unknown-unknown' downloads it.
# Where rustup cannot, tools/debian-wasm.sh unpacks Debian's compiler beside the system and builds the library with it.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:?build-wasm.sh OUT.wasm | --ready}
target=wasm32-unknown-unknown

has_target() {
    ls "$(rustc --print target-libdir --target "$target" 2>/dev/null)"/libcore-*.rlib >/dev/null 2>&1
}

if ! has_target && command -v rustup >/dev/null 2>&1; then
    (cd "$root" && rustup target add "$target") || true
fi
if [ "$out" = --ready ]; then
    has_target
    exit
fi
if has_target; then
    # paths of this machine stay out of the module
    RUSTFLAGS="--remap-path-prefix=$root=. --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo" \
        cargo build --manifest-path "$root/Cargo.toml" --locked --profile page --target "$target" -p telespring-wasm
    built=${CARGO_TARGET_DIR:-$root/target}/$target/page/telespring_wasm.wasm
else
    built=${CARGO_TARGET_DIR:-$root/target}/$target/page/telespring_wasm.wasm
    "$root/tools/debian-wasm.sh" || {
        echo "the page needs Rust's library for $target: run 'rustup target add $target'." >&2
        exit 1
    }
fi
mkdir -p "$(dirname "$out")"
cp "$built" "$out"
