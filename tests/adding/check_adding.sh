#!/bin/bash
# What it takes to add a thing: each patch beside this file adds one. It has to apply to the tree and to touch no more files
# than docs/guide/adding.md says. check_adding.sh: a line per patch; exit code 1 if one does not hold.
# check_adding.sh --build: applies them to a copy in out/adding/, builds it and shows what they add; the last line is
# `N passed, N failed`. Compares with build/release.
# check_adding.sh --self-test: sees that a patch of too many files and one that does not apply are found.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1

# holds PATCH FILES [OWN]: applies, and touches at most FILES files outside the folder OWN.
holds() {
    local touched
    touched=$(sed -n 's|^+++ b/||p; s|^--- a/||p' "$1" | sort -u | grep -v "^${3:-//}" | wc -l)
    if ! git apply --check "$1" 2>/dev/null; then
        echo "FAILED $1: does not apply"
        return 1
    elif [ "$touched" = 0 ] || [ "$touched" -gt "$2" ]; then
        echo "FAILED $1: $touched files; at most $2"
        return 1
    fi
    echo "$1: $touched files, at most $2"
}

if [ "${1:-}" = --self-test ]; then
    spoilt=$(mktemp)
    trap 'rm -f "$spoilt"' EXIT
    sed 's/^ SETTING/ SETTINGS/' tests/adding/trial_setting.patch >"$spoilt"
    if holds "$spoilt" 1 >/dev/null || holds tests/adding/vignette.patch 4 >/dev/null; then
        echo "a breach was not found"
        exit 1
    fi
    exit 0
fi

# shows WHAT COMMAND...: a command that must succeed.
passed=0
failed=0
shows() {
    local what=$1
    shift
    if "$@"; then passed=$((passed + 1)); echo "ok     $what"; else failed=$((failed + 1)); echo "FAILED $what"; fi
}

# same / differs FILE FILE
same() { cmp -s "$1" "$2"; }
differs() { [ -s "$1" ] && [ -s "$2" ] && ! cmp -s "$1" "$2"; }

# told PROGRAM TEXT: whether `hello` of a server has TEXT.
told() {
    local port said=$made/said server found=1
    mkdir -p "$made/client" && echo "<title>none</title>" >"$made/client/index.html"
    HELIOGRAPH_CACHE='' "$1" serve cornell --client "$made/client" --listen 127.0.0.1:0 >"$said" 2>&1 &
    server=$!
    for _ in $(seq 300); do
        port=$(grep -oE '127\.0\.0\.1:[0-9]+' "$said" | head -n 1 | cut -d : -f 2)
        [ -n "$port" ] && break
        sleep 0.1
    done
    if [ -n "$port" ] && exec 4<>"/dev/tcp/127.0.0.1/$port"; then
        printf 'GET /ws HTTP/1.1\r\nHost: 127.0.0.1:%s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: heliograph.v1\r\n\r\n' "$port" >&4
        timeout 5 cat <&4 >"$made/hello"
        exec 4>&-
        grep -a -q -F -- "$2" "$made/hello" && found=0
    fi
    kill "$server"
    wait "$server" 2>/dev/null
    return $found
}

# draw PROGRAM OUT ARGUMENTS...
draw() {
    local program=$1 out=$2
    shift 2
    HELIOGRAPH_CACHE='' "$program" render cornell --size 96x54 --samples 2 --out "$out" "$@" >"$out.log" 2>&1
}

buildAndShow() {
    local before after device
    before=$(pwd)/build/release/heliograph
    made=$(pwd)/out/adding
    [ -x "$before" ] || { echo "build/release/heliograph is needed: ./check build"; exit 1; }
    mkdir -p "$made/tree" "$made/fresh"
    git ls-files -z | while IFS= read -r -d '' file; do
        # Only what changed, so that a second run builds little.
        cmp -s "$file" "$made/fresh/$file" && continue
        cp -p --parents "$file" "$made/fresh" && cp -p --parents "$file" "$made/tree"
    done
    # What has gone since goes there too.
    comm -23 <(cd "$made/fresh" && find . -type f -printf '%P\n' | sort) <(git ls-files | sort) |
        while read -r file; do rm -f "$made/fresh/$file" "$made/tree/$file"; done
    local patch
    for patch in tests/adding/*.patch; do
        sed -n 's|^+++ b/||p' "$patch" | while read -r file; do
            [ ! -f "$file" ] || cp "$file" "$made/tree/$file"
            [ -f "$file" ] || rm -f "$made/tree/$file"
        done
    done
    for patch in tests/adding/*.patch; do
        (cd "$made/tree" && GIT_CEILING_DIRECTORIES=$made git apply "$OLDPWD/$patch") || { echo "FAILED $patch: does not apply"; exit 1; }
    done
    (cd "$made/tree" && . tools/setup.sh && configure release && ninja -C build/release heliograph test_image) >"$made/build.log" 2>&1 || {
        grep -m 5 -E 'error:|FAILED' "$made/build.log"
        echo "FAILED build: see $made/build.log"
        exit 1
    }
    after=$made/tree/build/release/heliograph

    for device in embree vulkan; do
        draw "$before" "$made/before.png" --device $device && draw "$after" "$made/off.png" --device $device &&
            draw "$after" "$made/on.png" --device $device --set vignette=on
        shows "vignette, $device: off, the same bits as without it" same "$made/before.png" "$made/off.png"
        shows "vignette, $device: on, another picture" differs "$made/off.png" "$made/on.png"
    done
    shows "vignette: its test" "$made/tree/build/release/tests/test_image" --gtest_filter='Vignette.*' --gtest_brief=1
    "$after" inspect cornell --json >"$made/inspect.json" 2>/dev/null
    shows "vignette: inspect names it" grep -q '"vignette"' "$made/inspect.json"

    "$after" devices --json >"$made/devices.json" 2>/dev/null
    shows "null: heliograph devices lists it" grep -q '"name": "null"' "$made/devices.json"
    draw "$after" "$made/null.png" --device null --json
    shows "null: it makes all tiles of a picture" grep -qE '"tiles": *\{ *"null": *[1-9]' <(tr -d '\n' <"$made/null.png.log")
    shows "null: hello tells of its kind" told "$after" '"name":"null"'

    "$after" inspect --settings >"$made/settings.json" 2>/dev/null
    shows "trial: in the schema of the settings" grep -q '"trial"' "$made/settings.json"
    shows "trial: hello has it" told "$after" '"name":"trial"'
    shows "trial: --set takes 9" draw "$after" "$made/trial.png" --set trial=9
    draw "$after" "$made/refused.png" --set trial=10
    shows "trial: --set refuses 10 and says the range" grep -q 'setting trial: 10.0; allowed: a whole number from 0 to 9' "$made/refused.png.log"
    echo "$passed passed, $failed failed"
    [ $failed = 0 ]
    exit
}
if [ "${1:-}" = --build ]; then buildAndShow; fi

holds tests/adding/vignette.patch 6 || failed=1
holds tests/adding/null_device.patch 2 server/device/null/ || failed=1
holds tests/adding/trial_setting.patch 1 || failed=1
exit $failed
