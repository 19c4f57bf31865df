#!/usr/bin/env bash
# meshoptimizer's C++ sources (MIT), into .deps/meshoptimizer, where CMake compiles them: Debian's package has only a shared
# library, which the module that Blender loads must not need. PyPI's source package carries them. Quick where they are.
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh
version=0.2.30a0
sha256=36b18b61a95ba992de804b1e91e86be2ba185925e4e2c1481495f8c68a17f5db
folder=.deps/meshoptimizer
[ "$(cat "$folder/togishi-installed.txt" 2>/dev/null)" != "$sha256" ] || exit 0

python=.venv/bin/python
[ -x "$python" ] || python=$(tools/find_python.sh 3.11) || fail "Python 3.11 was not found on PATH or in ~/.pyenv. Install it, then run again."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
say "downloading meshoptimizer's sources into $folder"
echo "meshoptimizer==$version --hash=sha256:$sha256" >"$work/requirements.txt"
"$python" -m pip download --disable-pip-version-check --progress-bar off -q --no-deps --no-binary meshoptimizer \
    --require-hashes -r "$work/requirements.txt" --dest "$work" ||
    fail "pip could not download meshoptimizer $version: is the network up? Its message is above."
echo "$sha256  $work/meshoptimizer-$version.tar.gz" | sha256sum --check --quiet ||
    fail "meshoptimizer-$version.tar.gz is not the file that was expected."
tar -xzf "$work/meshoptimizer-$version.tar.gz" -C "$work"
rm -rf "$folder" && mkdir -p "$folder"
cp "$work/meshoptimizer-$version"/src/{meshoptimizer.h,simplifier.cpp,allocator.cpp} "$folder"
printf '%s' "$sha256" >"$folder/togishi-installed.txt"
