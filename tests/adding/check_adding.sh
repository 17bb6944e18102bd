#!/bin/bash
# What it takes to add a thing: each patch beside this file adds one. It has to apply to the tree and to touch no more files
# than docs/guide/adding.md says. check_adding.sh: a line per patch; exit code 1 if one does not hold.
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
    if holds "$spoilt" 1 >/dev/null || holds tests/adding/vignette.patch 5 >/dev/null; then
        echo "a breach was not found"
        exit 1
    fi
    exit 0
fi

failed=0
holds tests/adding/vignette.patch 6 || failed=1
holds tests/adding/null_device.patch 2 server/device/null/ || failed=1
holds tests/adding/trial_setting.patch 1 || failed=1
exit $failed
