#!/bin/bash
# The server as an operator meets it: signals, sockets, service manager, metrics, proxy. run.sh [SCRIPT...]; the last line is
# `N passed, N failed`. What needs a program that is not here (nginx, prometheus, openssl) says so and counts as neither.
# HELIOGRAPH names the program (build/release/heliograph).
cd "$(dirname "$(readlink -f "$0")")" || exit 1
[ $# -gt 0 ] || set -- signals.py listen.py reload.py nginx.py prometheus.py
passed=0 failed=0
for script in "$@"; do
    echo "== $script"
    out=$(mktemp)
    timeout 300 python3 "$script" 2>&1 | tee "$out"
    # A script that ends without having counted has failed.
    [ "${PIPESTATUS[0]}" -le 1 ] && grep -q '^[0-9]* checks, [0-9]* failed$' "$out" || failed=$((failed + 1))
    passed=$((passed + $(grep -c '^ok ' "$out")))
    failed=$((failed + $(grep -c '^FAIL ' "$out")))
    rm -f "$out"
done
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
