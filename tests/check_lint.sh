#!/bin/bash
# How the C++ looks (.clang-format) and what clang-tidy says of it (.clang-tidy). check_lint.sh BUILD: BUILD holds
# compile_commands.json. A line per breach; last line: N passed, N failed (files that keep to it, files that do not).
set -u
cd "$(dirname "$(readlink -f "$0")")/.." || exit 1
build=${1:?check_lint.sh BUILD}
passed=0
failed=0

# The rooms without Embree, Vulkan and image libraries, whose headers take longer to read than our code.
rooms=(base request film denoise schedule render loop net viewer stream encode lab lab/accuracy lab/live lab/convergence lab/view pool pool/wire pool/node)

mapfile -t formatted < <(git ls-files 'server/*.h' 'server/*.cpp' 'tests/*.h' 'tests/*.cpp' 2>/dev/null)
[ ${#formatted[@]} -gt 0 ] || mapfile -t formatted < <(find server tests -name '*.h' -o -name '*.cpp')
said=$(printf '%s\0' "${formatted[@]}" | xargs -0 -P "$(nproc)" -n 40 clang-format --dry-run -Werror 2>&1)
ended=$?
breaches=$(grep -oE '^[^ :]+:[0-9]+:[0-9]+: error' <<<"$said" | sort -t : -k 1,1 -u)
[ $ended = 0 ] || [ -n "$breaches" ] || { failed=$((failed + 1)); echo "FAILED format: clang-format did not run"; }
for file in "${formatted[@]}"; do
    [ -f "$file" ] || continue
    if breach=$(grep -m 1 -F -- "$file:" <<<"$breaches"); then
        failed=$((failed + 1))
        echo "FAILED format: ${breach%: error}; clang-format -i $file mends it"
    else
        passed=$((passed + 1))
    fi
done

# By clang, to which g++'s precompiled headers are none. clang-tidy reads files as they are built, several in one run: that is a
# third of the time. What it says of a file that it reads first alone (misc-unused-using-decls) is not asked for therefore.
commands=$(mktemp -d)
trap 'rm -rf "$commands"' EXIT
sed -E 's/-Winvalid-pch|-include [^ ]+\/cmake_pch\.hxx//g' "$build/compile_commands.json" >"$commands/compile_commands.json"
mapfile -t tidied < <(for room in "${rooms[@]}"; do ls server/"$room"/*.cpp; done)
pattern=$(IFS='|'; echo "server/(${rooms[*]})/[^/]+\.cpp")
mapfile -t units < <(grep -lE "$pattern" "$build"/CMakeFiles/heliograph_*.dir/Unity/*.cxx)
mapfile -t by_themselves < <(comm -23 <(printf '%s\n' "${tidied[@]}" | sort) <(cat "${units[@]}" /dev/null | grep -oE "$pattern" | sort -u))
tidy() {
    xargs -P "$(nproc)" -n 1 clang-tidy -p "$commands" --quiet 2>/dev/null
}
said=$(printf '%s\n' "${units[@]}" "${by_themselves[@]}" | tidy)
ended=$?
found=$(grep -E '(warning|error):' <<<"$said" | sed "s|$PWD/||" | sort -u)
[ $ended = 0 ] || [ -n "$found" ] || { failed=$((failed + 1)); echo "FAILED tidy: clang-tidy did not run"; }
for file in "${tidied[@]}"; do
    if grep -q "^${file%.cpp}\." <<<"$found"; then failed=$((failed + 1)); else passed=$((passed + 1)); fi
done
[ -z "$found" ] || sed 's/^/FAILED tidy: /' <<<"$found"

# Each file alone, which shows what it forgot to include; the slow ones of others, and what they include, are read once.
options=(-std=c++20 -march=x86-64-v2 -I. -DFMT_SHARED -DSPDLOG_COMPILED_LIB -DSPDLOG_FMT_EXTERNAL -DSPDLOG_SHARED_LIB
    -DHELIOGRAPH_VERSION=\"0\" -DHELIOGRAPH_ISA_NAME=\"v2\" -DHELIOGRAPH_KERNEL_NAMESPACE=lanes -DHELIOGRAPH_EFFECTS_LEFT_OUT=0ull)  # as CMake does for single files
mapfile -t -O ${#options[@]} options < <(grep -hoE -- '-isystem [^ ]+' "$commands/compile_commands.json" | sort -u | tr ' ' '\n')
grep -hoE '^#include <(nlohmann|spdlog|tbb|glm)/.*' "${tidied[@]}" server/*/*.h | sort -u >"$commands/heads.h"
clang++ "${options[@]}" -x c++-header "$commands/heads.h" -o "$commands/heads.pch" || { failed=$((failed + 1)); echo "FAILED alone: no heads"; }
said=$(printf '%s\n' "${tidied[@]}" | xargs -P "$(nproc)" -n 4 clang++ "${options[@]}" -include-pch "$commands/heads.pch" -fsyntax-only -w 2>&1)
ended=$?
found_alone=$(grep -E 'error:' <<<"$said" | sort -u)
[ $ended = 0 ] || [ -n "$found_alone" ] || { failed=$((failed + 1)); echo "FAILED alone: clang did not run"; }
for file in "${tidied[@]}"; do
    if grep -q "^$file:" <<<"$found_alone"; then failed=$((failed + 1)); else passed=$((passed + 1)); fi
done
[ -z "$found_alone" ] || failed=$((failed + $(grep -c -v '\.cpp:' <<<"$found_alone")))
[ -z "$found_alone" ] || sed 's/^/FAILED alone: /' <<<"$found_alone"
# What it says of a header that has no source file of its own.
others=$(grep -c -v -F -f <(printf '%s.\n' "${tidied[@]%.cpp}") <<<"$found")
[ -z "$found" ] || failed=$((failed + others))
[ -z "$found$found_alone" ] || [ "$failed" -gt 0 ] || failed=1
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
