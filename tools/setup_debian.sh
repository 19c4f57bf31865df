#!/usr/bin/env bash
# setup_debian.sh [FILE]: installs what FILE (apt.txt) lists and is missing. Quick where nothing is.
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh

mapfile -t wanted < <(sed 's/#.*//' "${1:-apt.txt}" | xargs -n1)
missing=()
for package in "${wanted[@]}"; do
    dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

command -v apt-get >/dev/null || fail "These packages are missing, and this is no Debian: ${missing[*]}. Install them by hand, then run again."
as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "Packages are missing (${missing[*]}): run 'apt-get install' for them as root, then run again."
    as_root=(sudo)
fi
say "installing ${#missing[@]} Debian packages: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -q || fail "apt-get update failed: is the network up?"
"${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}" ||
    fail "apt-get could not install: ${missing[*]}. Its message is above."
