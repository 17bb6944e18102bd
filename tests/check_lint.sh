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
for file in "${formatted[@]}"; do
    [ -f "$file" ] || continue
    if breach=$(clang-format --dry-run -Werror "$file" 2>&1); then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED format: $(grep -m 1 -oE "^$file:[0-9]+:[0-9]+" <<<"$breach" || echo "$file"); clang-format -i $file mends it"
    fi
done

mapfile -t tidied < <(for room in "${rooms[@]}"; do ls server/"$room"/*.cpp; done)
found=$(printf '%s\n' "${tidied[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy -p "$build" --quiet 2>/dev/null |
    grep -E '(warning|error):' | sed "s|$PWD/||" | sort -u)
for file in "${tidied[@]}"; do
    if grep -q "^${file%.cpp}\." <<<"$found"; then failed=$((failed + 1)); else passed=$((passed + 1)); fi
done
[ -z "$found" ] || sed 's/^/FAILED tidy: /' <<<"$found"
# What it says of a header that has no source file of its own.
others=$(grep -c -v -F -f <(printf '%s.\n' "${tidied[@]%.cpp}") <<<"$found")
[ -z "$found" ] || failed=$((failed + others))
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
