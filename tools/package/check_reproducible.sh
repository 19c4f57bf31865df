#!/usr/bin/env bash
# Makes the package of the last commit twice, in two clones of different paths, and compares the bytes.
# check_reproducible.sh [make_package.py's options]; without any: zig, Python 3.11 and 3.13. Some 10 minutes.
# The package is then in dist/, with nothing in it that is not committed.
set -euo pipefail
cd "$(dirname "$0")/../.."
. tools/say.sh

[ $# -gt 0 ] || set -- --python "3.11=$(tools/find_python.sh 3.11)" --python "3.13=$(tools/find_python.sh 3.13)"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Both are clones of one commit, whatever is committed meanwhile.
git clone -q . "$work/one"
git clone -q "$work/one" "$work/another/and/longer"
for folder in one another/and/longer; do
    ln -s "$PWD"/.venv "$PWD"/.venv-5.2 "$work/$folder/"
    # No cache is shared: the second package is compiled anew.
    ZIG_GLOBAL_CACHE_DIR=$work/$folder/build/zig-cache .venv-package/bin/python \
        "$work/$folder/tools/package/make_package.py" --tools "$PWD/.venv-package" "$@"
done
(cd "$work" && sha256sum one/dist/*.zip another/and/longer/dist/*.zip)
cmp "$work"/one/dist/*.zip "$work"/another/and/longer/dist/*.zip || fail "the two packages differ."
mkdir -p dist && cp "$work"/one/dist/*.zip dist/
say "the same bytes from two folders: $(basename "$work"/one/dist/*.zip), now in dist"
