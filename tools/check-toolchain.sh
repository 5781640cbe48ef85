#!/bin/sh
# Checks what must be installed before anything is built: Rust, Python with venv, a C compiler and make.
#
#   check-toolchain.sh            prints a sentence on stderr for each tool that is missing or too old, and exits with 1
#   check-toolchain.sh --python   also prints the name of the Python to use
#   check-toolchain.sh --link     checks for what the live program needs, which is a newer Rust
#   check-toolchain.sh --docs     also checks for Node.js and npm, which the documentation site needs
#
# The required versions are read from Cargo.toml and pyproject.toml, so that each is stated only once.
set -u

root=$(cd "$(dirname "$0")/.." && pwd) || exit 1
missing=0

first_number() { # the first a.b after a key: first_number FILE KEY
    sed -n "s/^$2 *= *\"[^0-9]*\([0-9][0-9]*\.[0-9][0-9]*\).*/\1/p" "$root/$1" | head -n 1
}

at_least() { # at_least HAVE WANT, both major.minor
    [ "${1%%.*}" -gt "${2%%.*}" ] || { [ "${1%%.*}" -eq "${2%%.*}" ] && [ "${1#*.}" -ge "${2#*.}" ]; }
}

tell() {
    printf '%s\n' "$1" >&2
    missing=1
}

rust_wanted=$(first_number Cargo.toml rust-version)
who=telespring
if [ "${1-}" = --link ]; then
    rust_wanted=$(first_number crates/telespring-link/Cargo.toml rust-version)
    who='the live program'
fi
python_wanted=$(first_number pyproject.toml requires-python)

check_rust() {
    if ! command -v cargo >/dev/null 2>&1 || ! command -v rustc >/dev/null 2>&1; then
        tell "$who needs Rust $rust_wanted or newer and found no cargo and rustc: install Rust from https://rustup.rs."
        return
    fi
    have=$(rustc --version 2>/dev/null | sed -n 's/^rustc \([0-9]*\.[0-9]*\).*/\1/p')
    if [ -z "$have" ]; then
        tell "$who needs Rust $rust_wanted or newer and rustc does not run: install a toolchain with 'rustup default stable'."
    elif ! at_least "$have" "$rust_wanted"; then
        tell "$who needs Rust $rust_wanted or newer and found $have: update it with 'rustup update stable', or install it from https://rustup.rs."
    fi
}

check_python() {
    newest_seen=
    python=
    for candidate in ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11 python}; do
        command -v "$candidate" >/dev/null 2>&1 || continue
        have=$("$candidate" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
        newest_seen=${newest_seen:-$have}
        if at_least "$have" "$python_wanted"; then
            python=$candidate
            break
        fi
    done
    if [ -z "$python" ] && [ -z "$newest_seen" ]; then
        tell "telespring needs Python $python_wanted or newer and found none: install Python from https://www.python.org or your system's packages."
    elif [ -z "$python" ]; then
        tell "telespring needs Python $python_wanted or newer and found $newest_seen: install a newer Python, which can coexist with it, from https://www.python.org or your system's packages."
    elif ! "$python" -c 'import venv, ensurepip' >/dev/null 2>&1; then
        tell "telespring needs Python's venv module and $python has none: install it (on Debian and Ubuntu: apt install python3-venv)."
    fi
}

check_c_compiler() {
    compiler=${CC:-cc}
    trial=$(mktemp -d) || exit 1
    printf '#include <stdlib.h>\nint main(void) { return EXIT_SUCCESS; }\n' >"$trial/trial.c"
    if ! command -v "${compiler%% *}" >/dev/null 2>&1; then
        tell "telespring needs a C compiler to link with and found no '$compiler': install one (Debian and Ubuntu: apt install build-essential; macOS: xcode-select --install)."
    # Unquoted on purpose: CC may contain options.
    elif ! $compiler -o "$trial/trial" "$trial/trial.c" >/dev/null 2>&1; then
        tell "telespring needs a C compiler and '$compiler' cannot build a program: install it with its headers (Debian and Ubuntu: apt install build-essential; macOS: xcode-select --install)."
    fi
    rm -rf "$trial"
}

check_make() {
    command -v "${MAKE:-make}" >/dev/null 2>&1 ||
        tell "telespring needs make and found none: install it (Debian and Ubuntu: apt install make; macOS: xcode-select --install)."
}

check_node() {
    if ! command -v node >/dev/null 2>&1 || ! command -v npm >/dev/null 2>&1; then
        tell "the documentation site needs Node.js with npm and found none: install it (Debian and Ubuntu: apt install nodejs npm; macOS: brew install node)."
    fi
}

check_rust
check_python
check_c_compiler
check_make
[ "${1-}" != --docs ] || check_node
[ "$missing" -eq 0 ] || exit 1
[ "${1-}" != --python ] || printf '%s\n' "$python"
