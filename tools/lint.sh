#!/usr/bin/env bash
# Formatters and linters over the whole tree. Every finding is an error; all of them run before it fails.
set -uo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh
failed=()
check() {
    local name=$1
    shift
    say "lint: $name"
    "$@" || failed+=("$name")
}
mapfile -t cpp < <(git ls-files 'cpp_core/*.hpp' 'cpp_core/*.cpp' 'tests/cpp/*.cpp' 'tests/bench/*.cpp')
# Binding files need Python's headers and are compiled with warnings as errors; clang-tidy reads the rest.
mapfile -t tidy < <(git ls-files 'cpp_core/*.cpp' | grep -v '^cpp_core/python/')

tidy_all() { printf '%s\n' "${tidy[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy --quiet --extra-arg=-Wno-unknown-warning-option -p build/release 2>&1 |
    grep -vE '^[0-9]+ warnings? generated|^Suppressed|^Use -header-filter|^$' | tee build/clang-tidy.log
    ! grep -qE '(error|warning):' build/clang-tidy.log; }

check clang-format clang-format --dry-run -Werror "${cpp[@]}"
check clang-tidy tidy_all
check "ruff check" .venv/bin/ruff check -q .
check "ruff format" .venv/bin/ruff format -q --check .
check "mypy" .venv/bin/mypy
[ ${#failed[@]} -eq 0 ] || fail "not clean: ${failed[*]}. 'make format' mends the formatters' findings."
say "lint: clean"
