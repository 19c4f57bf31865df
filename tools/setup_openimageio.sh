#!/usr/bin/env bash
# PyPI's openimageio for the Python of each environment, in a folder of its own (.venv-openimageio/MAJOR.MINOR): the
# tests load it beside Blender's. Inside an environment it would take the place of Blender's own. Quick where it is there.
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh
requirement="openimageio==3.1.19.0"
for python in .venv/bin/python .venv-5.2/bin/python; do
    [ -x "$python" ] || continue
    folder=.venv-openimageio/$("$python" -c "import sys; print('%d.%d' % sys.version_info[:2])")
    [ "$(cat "$folder/togishi-installed.txt" 2>/dev/null)" != "$requirement" ] || continue
    say "installing PyPI's $requirement into $folder"
    rm -rf "$folder"
    "$python" -m pip install --disable-pip-version-check --progress-bar off -q --no-deps --target "$folder" "$requirement" ||
        fail "pip could not install $requirement: is the network up? Its message is above."
    printf '%s' "$requirement" >"$folder/togishi-installed.txt"
done
