#!/bin/bash
# `blender --command togishi …` as a render farm calls it: installation from the command line, exit codes, what is
# written where. Run by tools/test_window.sh inside Debian trixie, without a window.
set -uo pipefail
work=/tmp/command
mkdir -p "$work" && cd "$work"
failures=0

bad() {
    failures=$((failures + 1))
    printf 'command line: %s\n' "$*" >&2
    sed 's/^/    /' "$work/stdout" "$work/stderr" >&2
}

# expect NAME CODE COMMAND…: runs it with its streams in files
expect() {
    local name=$1 wanted=$2 code=0
    shift 2
    timeout 200 "$@" >"$work/stdout" 2>"$work/stderr" || code=$?
    [ "$code" -eq "$wanted" ] || bad "$name: exit code $code, not $wanted"
}
says() { grep -qF -- "$2" "$work/$1" || bad "$3: '$2' is not on its $1"; }
saved() { [ "$(grep -c "^Saved: '" "$work/stdout")" -eq "$1" ] || bad "$2: not $1 'Saved:' lines"; }
is_png() { [ "$(head -c 4 "$1" 2>/dev/null | tail -c 3)" = PNG ] || bad "$1 is no PNG"; }

expect "installation" 0 blender --command extension install-file -r user_default --enable /tmp/togishi.zip
expect "scene" 0 blender -b --python-exit-code 3 --python /tmp/tests/window/command_scene.py -- "$work/scene.blend"
[ -s scene.blend ] || bad "no scene was saved"

expect "render" 0 blender --command togishi render scene.blend -o 'a/f_####.png' -f 1-2
saved 2 "render"
says stdout "Saved: '$work/a/f_0002.png'" "render"
says stderr "2 of 2" "render"
is_png a/f_0001.png && is_png a/f_0002.png
[ "$(ls a | wc -l)" -eq 2 ] || bad "render: other files than the two frames: $(ls a)"

expect "the file given to Blender" 0 blender -b scene.blend --command togishi render scene.blend -o b.png -r 48x24
saved 1 "the file given to Blender"
is_png b.png

expect "skip existing" 0 blender --command togishi render scene.blend -o 'a/f_####.png' -f 1-3 --skip-existing
saved 1 "skip existing"
says stderr "2 of 3 frames are there already" "skip existing"

expect "help" 0 blender --command togishi --help
says stdout "render" "help"
expect "no such file" 2 blender --command togishi render absent.blend -o c.png
says stderr "absent.blend: no such file" "no such file"
expect "unknown option" 2 blender --command togishi render scene.blend -o c.png --wings
says stderr "--wings" "unknown option"
expect "no such camera" 2 blender --command togishi render scene.blend -o c.png --camera Nikon
says stderr "'Nikon' is not a camera" "no such camera"
expect "folder that cannot be written" 2 blender --command togishi render scene.blend -o /proc/c.png
says stderr "--output" "folder that cannot be written"
[ ! -e c.png ] || bad "a refused command left a picture"

cp a/f_0001.png /tmp/out/command_line.png
[ "$failures" -eq 0 ] || exit 1
echo "command line: all as documented"
