#!/bin/sh
# Builds the core of the page where rustup cannot download a library for WebAssembly: with Debian's packages.
#
# Debian's rustc-web and its sources are unpacked beside the system (nothing is installed, no root), and cargo builds the
# standard library from these sources. Compiler and sources are of one version, because they are of one Debian version.
# The linker is rust-lld of any Rust that rustup has installed, or lld of Debian.
set -eu

root=$(cd "$(dirname "$0")/.." && pwd)
place=${TELESPRING_DEBIAN_RUST:-${XDG_CACHE_HOME:-$HOME/.cache}/telespring/debian-rust}
target=wasm32-unknown-unknown

command -v apt-get >/dev/null 2>&1 && command -v dpkg >/dev/null 2>&1 || {
    echo "debian-wasm.sh needs Debian's apt-get and dpkg." >&2
    exit 1
}
version=$(apt-cache policy rustc-web | sed -n 's/^ *Candidate: //p')
case $version in
'' | '(none)')
    echo "debian-wasm.sh found no package rustc-web: try 'apt-get update'." >&2
    exit 1
    ;;
esac
stamp=$place/$version.ready
if [ ! -e "$stamp" ]; then
    rm -rf "$place"
    mkdir -p "$place/packages"
    library=$(apt-cache depends "libstd-rust-web-dev=$version" | sed -n 's/^ *Depends: \(libstd-rust-web-[0-9][^ ]*\)$/\1/p' | head -n 1)
    llvm=$(apt-cache depends "$library=$version" | sed -n 's/^ *Depends: \(libllvm[0-9][^ ]*\)$/\1/p' | head -n 1)
    (cd "$place/packages" && apt-get download -qq "rustc-web=$version" "$library=$version" \
        "libstd-rust-web-dev=$version" "rust-web-src=$version" ${llvm:+"$llvm"})
    for package in "$place"/packages/*.deb; do
        dpkg -x "$package" "$place"
    done
    rm -rf "$place/packages"
    touch "$stamp"
fi

rustc=$place/usr/bin/rustc
sources=$(ls -d "$place"/usr/src/rustc-*/library 2>/dev/null | head -n 1)
[ -n "$sources" ] || {
    echo "debian-wasm.sh found no sources of the standard library below $place." >&2
    exit 1
}
# where cargo looks for them; Debian's own link leads there since 1.96
if [ ! -e "$place/usr/lib/rustlib/src/rust/library/std" ]; then
    mkdir -p "$place/usr/lib/rustlib/src/rust"
    ln -sfn "$sources" "$place/usr/lib/rustlib/src/rust/library"
fi
linker=$(find "$HOME/.rustup/toolchains" -name rust-lld 2>/dev/null | head -n 1)
linker=${linker:-$(command -v wasm-ld || command -v rust-lld || true)}
[ -n "$linker" ] || {
    echo "debian-wasm.sh needs rust-lld (of any Rust by rustup) or wasm-ld (Debian's lld)." >&2
    exit 1
}
export LD_LIBRARY_PATH="$place/usr/lib:$place/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null || echo x86_64-linux-gnu)${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
export RUSTC="$rustc" RUSTC_BOOTSTRAP=1 CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$linker"
cd "$root"
cargo build --locked --profile page --target "$target" -Zbuild-std=std,panic_abort -p telespring-wasm
