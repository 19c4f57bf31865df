#!/usr/bin/env bash
# The extension in Debian trixie's Blender, in a real window on a screen without a screen: its life-cycle, pictures of
# every panel, and its command line. test_window.sh ZIP [PART...]; parts: lifecycle pictures failure command.
# Results and pictures: out/window/. Debian trixie (1.3 GB) is unpacked once, into .cache/trixie-root.
set -euo pipefail
cd "$(dirname "$0")/.."
. tools/say.sh

[ $# -ge 1 ] || fail "test_window.sh needs the extension's zip: 'make test-window' makes it and hands it over."
zip=$1
shift
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(lifecycle pictures failure command)
[ -f "$zip" ] || fail "$zip: no such file. 'make package' makes the extension's zip."

root=.cache/trixie-root
packages=blender,python3-numpy,python3-openimageio,libegl1,libgl1,libgl1-mesa-dri
out=$PWD/out/window
shots=$out/.shots
blender_pid="" screen_pid=""
work=$(mktemp -d)

clean_up() {
    [ -z "$blender_pid" ] || kill "$blender_pid" 2>/dev/null || true
    [ -z "$screen_pid" ] || kill "$screen_pid" 2>/dev/null || true
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 130' INT TERM HUP

tools/setup_debian.sh apt-window.txt
for program in mmdebstrap:mmdebstrap bwrap:bubblewrap Xvfb:xvfb xwd:x11-apps convert:imagemagick; do
    command -v "${program%%:*}" >/dev/null ||
        fail "'${program%%:*}' is missing: install ${program##*:} (apt-window.txt lists all that the window needs), then run again."
done

if [ "$(cat "$root/packages" 2>/dev/null)" != "$packages" ]; then
    say "unpacking Debian trixie with its Blender into $root (once; some 3 minutes, 1.3 GB)"
    rm -rf "$root" "$root.part" && mkdir -p .cache
    mmdebstrap --variant=minbase --include="$packages" trixie "$root.part" \
        >"$work/mmdebstrap.log" 2>&1 || {
        tail -n 20 "$work/mmdebstrap.log" >&2
        fail "Debian trixie could not be unpacked: is the network up? The end of mmdebstrap's log is above."
    }
    echo "$packages" >"$root.part/packages"
    mv "$root.part" "$root"
fi

mkdir -p "$out"
exec 9>"$out/.lock"
flock -n 9 || fail "another test_window.sh works in $out: wait for it, or end it."
rm -rf "$shots" && mkdir "$shots"

start_screen() { # WIDTH HEIGHT: sets $display
    mkdir -p /tmp/.X11-unix
    : >"$work/display"
    Xvfb -displayfd 3 -screen 0 "$1x$2x24" -nolisten tcp 3>"$work/display" 2>"$work/xvfb.log" 9>&- &
    screen_pid=$!
    for _ in $(seq 100); do
        [ -s "$work/display" ] && break
        sleep .1
    done
    display=$(tr -d '\n' <"$work/display")
    [ -n "$display" ] || {
        cat "$work/xvfb.log" >&2
        fail "Xvfb did not start within 10 s; what it said is above."
    }
}

stop_screen() {
    kill "$screen_pid" 2>/dev/null || true
    wait "$screen_pid" 2>/dev/null || true
    screen_pid=""
}

# Debian trixie, read-only, without network; an empty home; our scripts, the zip and the results.
inside() {
    local x11=()
    [ -z "${display:-}" ] || x11=(--bind /tmp/.X11-unix /tmp/.X11-unix --setenv DISPLAY ":$display")
    exec bwrap --ro-bind "$root" / --dev /dev --proc /proc --tmpfs /tmp --tmpfs /home "${x11[@]}" \
        --ro-bind tests /tmp/tests --ro-bind "$zip" /tmp/togishi.zip --bind "$out" /tmp/out \
        --unshare-pid --unshare-net --die-with-parent --clearenv --setenv PATH /usr/bin:/bin --setenv HOME /home \
        ${display:+--setenv DISPLAY ":$display"} --setenv LANG C.UTF-8 --setenv XDG_RUNTIME_DIR /tmp \
        --setenv BLENDER_USER_RESOURCES /tmp/user --chdir /tmp "$@"
}

take_shots() { # until process $1 has ended
    local request name geometry keep
    while kill -0 "$1" 2>/dev/null; do
        for request in "$shots"/*.request; do
            [ -e "$request" ] || continue
            name=$(basename "$request" .request)
            read -r geometry keep <"$request"
            if xwd -root -silent -display ":$display" -out "$work/shot.xwd" &&
                convert "xwd:$work/shot.xwd" -crop "$geometry" +repage -strip -type TrueColor -depth 8 "$work/shot.ppm"; then
                [ "$keep" != keep ] || convert "$work/shot.ppm" -define png:compression-level=6 "$out/$name.png"
                mv "$work/shot.ppm" "$shots/$name.ppm"
            fi
            rm "$request"
        done
        sleep .03
    done
}

# in_window NAME SECONDS WIDTH HEIGHT SCRIPT: runs one script in a window; its console is out/window/NAME.log.
in_window() {
    local name=$1 seconds=$2 width=$3 height=$4 script=$5 code=0
    start_screen "$width" "$height"
    say "window: $name"
    : >"$out/$name.log"
    inside timeout --kill-after=10 "$seconds" blender --factory-startup --enable-event-simulate --no-window-focus \
        --window-geometry 0 0 "$width" "$height" --python-exit-code 3 --python "/tmp/tests/window/$script" -- \
        --zip /tmp/togishi.zip --out /tmp/out --console "/tmp/out/$name.log" >"$out/$name.log" 2>&1 9>&- &
    blender_pid=$!
    take_shots "$blender_pid"
    wait "$blender_pid" || code=$?
    blender_pid=""
    stop_screen
    case $code in
        0) ;;
        124 | 137) tail -n 30 "$out/$name.log" >&2; fail "$name: not done after $seconds s. Its console is above and in $out/$name.log." ;;
        *) tail -n 30 "$out/$name.log" >&2; fail "$name failed (exit code $code). Its console is above and in $out/$name.log." ;;
    esac
    python3 tests/window/console.py "$out/$name.log" || fail "$name: the lines above stand in $out/$name.log, and none should."
}

run_lifecycle() { in_window lifecycle 1800 1280 800 lifecycle.py; }
run_pictures() { in_window pictures 1200 1800 1400 pictures.py; }
run_failure() { in_window failure 300 1000 700 failure.py; }
run_command() {
    say "command line"
    (inside bash /tmp/tests/window/command_line.sh) || fail "blender --command togishi: see above."
}

for part in "${parts[@]}"; do "run_$part"; done
say "the window's pictures and results are in out/window"
