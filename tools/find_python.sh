#!/usr/bin/env bash
# find_python.sh MAJOR.MINOR: prints the path of a Python of that version; exit code 1 where there is none.
# Looked at, in this order: $TOGISHI_PYTHON_DIR/bin, PATH, /usr/bin, ~/.pyenv.
version=$1
for candidate in "${TOGISHI_PYTHON_DIR:-}/bin/python$version" "$(command -v "python$version" || true)" \
    /usr/bin/"python$version" "$HOME"/.pyenv/versions/"$version".*/bin/python; do
    # A pyenv shim exists for versions that are not switched on: ask it.
    if [ -x "$candidate" ] && "$candidate" -c "import sys; sys.exit(sys.version_info[:2] != tuple(map(int, '$version'.split('.'))))" 2>/dev/null; then
        "$candidate" -c "import sys; print(sys.executable)"
        exit 0
    fi
done
exit 1
