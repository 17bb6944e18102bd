#!/bin/bash
# How the C++ looks (.clang-format) and what clang-tidy says of it (.clang-tidy). check_lint.sh BUILD: BUILD holds
# compile_commands.json. A line per breach; last line: N passed, N failed (files that keep to it, files that do not).
set -u
cd "$(dirname "$(readlink -f "$0")")/.." || exit 1
build=${1:?check_lint.sh BUILD}
passed=0
failed=0

# The rooms without Embree, Vulkan and image libraries, whose headers take longer to read than our code.
rooms=(base request film schedule render loop net viewer stream encode lab lab/accuracy pool pool/wire pool/node)

mapfile -t formatted < <(git ls-files 'server/*.h' 'server/*.cpp' 'tests/*.h' 'tests/*.cpp' 2>/dev/null)
[ ${#formatted[@]} -gt 0 ] || mapfile -t formatted < <(find server tests -name '*.h' -o -name '*.cpp')
breaches=$(printf '%s\0' "${formatted[@]}" | xargs -0 -P "$(nproc)" -n 40 clang-format --dry-run -Werror 2>&1 |
    grep -oE '^[^ :]+:[0-9]+:[0-9]+: error' | sort -t : -k 1,1 -u)
for file in "${formatted[@]}"; do
    [ -f "$file" ] || continue
    if breach=$(grep -m 1 -F -- "$file:" <<<"$breaches"); then
        failed=$((failed + 1))
        echo "FAILED format: ${breach%: error}; clang-format -i $file mends it"
    else
        passed=$((passed + 1))
    fi
done

# Together, as they are compiled: their headers take longer to read than they do. But by clang, to which g++'s precompiled
# headers are none.
commands=$(mktemp -d)
trap 'rm -rf "$commands"' EXIT
mapfile -t tidied < <(for room in "${rooms[@]}"; do ls server/"$room"/*.cpp; done)
mapfile -t together < <(python3 - "$build" "$commands" "${tidied[@]}" <<'PYTHON'
import json, os, re, sys
wanted = {os.path.abspath(file) for file in sys.argv[3:]}
entries = json.load(open(sys.argv[1] + "/compile_commands.json"))
for entry in entries:
    entry["command"] = re.sub(r"-Winvalid-pch|-include \S+/cmake_pch\.hxx", "", entry["command"])
json.dump(entries, open(sys.argv[2] + "/compile_commands.json", "w"))
for entry in entries:
    file = entry["file"]
    parts = {file} | set(re.findall(r'^#include "(.*)"', open(file).read(), re.M) if "/Unity/" in file else [])
    if parts & wanted:
        print(os.path.getsize(file), file)
        wanted -= parts
for file in sorted(wanted):
    print(0, file)
PYTHON
)
[ ${#together[@]} -gt 0 ] || together=(0\ nothing)
said=$(printf '%s\n' "${together[@]}" | sort -rn | cut -d ' ' -f 2- | xargs -P "$(nproc)" -n 1 \
    clang-tidy -p "$commands" --quiet --checks=-bugprone-suspicious-include 2>/dev/null)
ended=$?
found=$(grep -E '(warning|error):' <<<"$said" | sed "s|$PWD/||" | sort -u)
[ $ended = 0 ] || [ -n "$found" ] || { failed=$((failed + 1)); echo "FAILED tidy: clang-tidy did not run"; }
for file in "${tidied[@]}"; do
    if grep -q "^${file%.cpp}\." <<<"$found"; then failed=$((failed + 1)); else passed=$((passed + 1)); fi
done
[ -z "$found" ] || sed 's/^/FAILED tidy: /' <<<"$found"
# What it says of a header that has no source file of its own.
others=$(grep -c -v -F -f <(printf '%s.\n' "${tidied[@]%.cpp}") <<<"$found")
[ -z "$found" ] || failed=$((failed + others))
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
