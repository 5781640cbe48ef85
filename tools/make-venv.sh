#!/bin/sh
# Installs pinned requirements into .venv:  make-venv.sh FILE...
#
# .venv/.unfinished exists until the last package is installed, so that an interrupted set-up is
# discarded and repeated instead of being reused.
set -eu

cd "$(dirname "$0")/.."
python=$(tools/check-toolchain.sh --python)

if [ -e .venv/.unfinished ] || [ "$(cat .venv/.place 2>/dev/null)" != "$PWD" ] || ! .venv/bin/python -c '' 2>/dev/null; then
    rm -rf .venv
    mkdir .venv
    touch .venv/.unfinished
    echo "Creating .venv with $("$python" --version)"
    "$python" -m venv .venv
    # A virtual environment cannot be moved: its scripts contain the path of its folder.
    pwd >.venv/.place
fi

touch .venv/.unfinished
for file in "$@"; do
    echo "Installing $file"
    .venv/bin/python -m pip install --disable-pip-version-check --quiet --requirement "$file"
done
rm .venv/.unfinished
