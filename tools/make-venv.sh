#!/bin/sh
# Installs pinned requirements into .venv:  make-venv.sh FILE...
#
# .venv/.unfinished stands from before the first byte is written until the last package is in, so
# that a set-up that was interrupted is thrown away and made again, never built upon.
set -eu

cd "$(dirname "$0")/.."
python=$(tools/check-toolchain.sh --python)

if [ -e .venv/.unfinished ] || [ "$(cat .venv/.place 2>/dev/null)" != "$PWD" ] || ! .venv/bin/python -c '' 2>/dev/null; then
    rm -rf .venv
    mkdir .venv
    touch .venv/.unfinished
    echo "Creating .venv with $("$python" --version)"
    "$python" -m venv .venv
    # a virtual environment cannot be moved: its programs name the folder it was made in
    pwd >.venv/.place
fi

touch .venv/.unfinished
for file in "$@"; do
    echo "Installing $file"
    .venv/bin/python -m pip install --disable-pip-version-check --quiet --requirement "$file"
done
rm .venv/.unfinished
