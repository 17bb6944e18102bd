#!/bin/bash
# The client of sixty lines against a real server: run.sh PROGRAM; the last line is `N passed, N failed`. It is written from
# docs/reference/protocol.md alone, so what fails here fails for whoever writes another client.
set -u
program=$(readlink -f "${1:?run.sh PROGRAM}")
cd "$(dirname "$(readlink -f "$0")")" || exit 1
passed=0 failed=0
scratch=$(mktemp -d)
mkdir "$scratch/page" "$scratch/frames"
echo '<p>' >"$scratch/page/index.html"
"$program" serve cornell --listen 127.0.0.1:0 --client "$scratch/page" >"$scratch/out" 2>"$scratch/err" &
server=$!
trap 'kill $server 2>/dev/null; wait $server; rm -rf "$scratch"' EXIT

expect() {
    if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED $1: $(tail -n 3 "$scratch/said")"; fi
}
for _ in $(seq 600); do
    url=$(sed -n 's,.* on http:\(.*\),ws:\1/ws,p' "$scratch/out")
    [ -z "$url" ] && kill -0 $server 2>/dev/null || break
    sleep 0.1
done
/usr/bin/python3 orbit.py "$url" --size 320x180 --seconds 2 --save "$scratch/frames" >"$scratch/said" 2>&1
expect "the client ends well" [ $? = 0 ]
expect "the last input was shown" grep -q '"last_input_shown": true' "$scratch/said"
expect "frames were saved" [ "$(find "$scratch/frames" -name '*.jpg' -size +1k | wc -l)" -ge 2 ]
/usr/bin/python3 orbit.py "$url" --scene nowhere --seconds 1 >"$scratch/said" 2>&1
expect "a scene that is not there is an error" [ $? != 0 ]
expect "which the server names" grep -q 'the server says: .*nowhere' "$scratch/said"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
