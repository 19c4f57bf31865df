#!/usr/bin/env bash
# setup_python.sh FOLDER MAJOR.MINOR GROUP...: a virtual environment with pyproject.toml's dependency groups.
# Quick where the folder already holds them (stamp: the list that was installed).
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh

folder=$1 version=$2
shift 2
python=$(tools/find_python.sh "$version") || fail "Python $version was not found on PATH or in ~/.pyenv. Install it (bpy for it needs exactly this version), then run again."

requirements=$("$python" - "$@" <<'P'
import sys, tomllib
groups = tomllib.load(open("pyproject.toml", "rb"))["dependency-groups"]
print("\n".join(r for g in sys.argv[1:] for r in groups[g]))
P
)
stamp=$folder/togishi-installed.txt
if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$requirements" ]; then exit 0; fi
say "making $folder ($($python --version)) with: $(echo "$requirements" | xargs)"
[ -x "$folder/bin/python" ] || "$python" -m venv "$folder" || fail "$python could not make $folder."
"$folder/bin/python" -m pip install --disable-pip-version-check --progress-bar off -q $requirements ||
    fail "pip could not install into $folder: is the network up? Its message is above."
printf '%s' "$requirements" > "$stamp"
