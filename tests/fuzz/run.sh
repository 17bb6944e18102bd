#!/bin/bash
# Fuzzes the readers of what strangers send, with AddressSanitizer and UndefinedBehaviorSanitizer: run.sh SECONDS [TARGET...]
# builds build/fuzz by clang, makes seeds, and lets each target run that long. What was found lies in out/fuzz/<target>/;
# the corpus grows in build/fuzz-corpus/. A target fails on a crash, a report, an input over 5 s or over 1 GiB. Last line:
# N passed, N failed.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1
seconds=${1:?run.sh SECONDS [TARGET...]}
shift
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(message settings header upload image gltf glb obj pool)
mkdir -p out/fuzz build
cmake --preset fuzz $(command -v ccache >/dev/null && echo -DCMAKE_CXX_COMPILER_LAUNCHER=ccache) >out/fuzz/configure.log 2>&1 &&
    ninja -C build/fuzz fuzz_seeds "${targets[@]/#/fuzz_}" >out/fuzz/build.log 2>&1 || {
    echo "FAILED: the build, see out/fuzz/build.log"
    echo "0 passed, 1 failed"
    exit 1
}
build/fuzz/tests/fuzz_seeds build/fuzz-seeds
# Real broken files, where they are: copied, so that nothing is written beside them.
find ../shared/scenes/invalid -type f -size -64k 2>/dev/null | while read -r file; do
    case $file in
        *.gltf) into=gltf ;; *.glb) into=glb ;; *.obj) into=obj ;; *.png | *.jpg | *.webp | *.hdr | *.exr) into=image ;; *) continue ;;
    esac
    cp "$file" "build/fuzz-seeds/$into/$(printf '%s' "$file" | sha256sum | cut -c 1-16)"
done

fuzz() {
    local target=$1
    mkdir -p "out/fuzz/$target" "build/fuzz-corpus/$target"
    ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=1 LSAN_OPTIONS=suppressions=tests/support/lsan.supp:print_suppressions=0 \
        build/fuzz/tests/fuzz_"$target" -max_total_time="$seconds" -timeout=5 -rss_limit_mb=1024 -max_len=65536 -print_final_stats=1 \
        -artifact_prefix="out/fuzz/$target/" "build/fuzz-corpus/$target" "build/fuzz-seeds/$target" >"out/fuzz/$target.log" 2>&1
}
export -f fuzz
export seconds
printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -I TARGET bash -c 'fuzz TARGET; echo "TARGET $?"' >out/fuzz/results
passed=0
failed=0
while read -r target status; do
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "out/fuzz/$target.log")
    if [ "$status" = 0 ] && [ "${runs:-0}" -gt 0 ]; then
        passed=$((passed + 1))
        echo "ok $target: $runs inputs"
    else
        failed=$((failed + 1))
        echo "FAILED $target: $(grep -m 1 -aE 'SUMMARY:|ERROR:|runtime error:' "out/fuzz/$target.log" || echo "exit code $status"), see out/fuzz/$target.log"
    fi
done <out/fuzz/results
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" = ${#targets[@]} ]
