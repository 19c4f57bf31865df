# Sourced by the scripts of this folder: how they speak.
say() { printf '\033[1m[togishi]\033[0m %s\n' "$*"; }
fail() { printf '\033[1m[togishi] %s\033[0m\n' "$*" >&2; exit 1; }
