#!/bin/bash
# What an effect leaves in the Vulkan tracer when it is off. For each row of the effect table the tracer is specialised with
# every effect but this one, as a request does, and optimised; the same is done with a tracer whose source has the effect's
# code removed (LEFT_OUT of device.glsl). Both must have the same instructions, one for one, and differ from the tracer with
# all effects. Prints instructions with and without each effect. Last line: N passed, N failed.
set -u
cd "$(dirname "$(readlink -f "$0")")/.." || exit 1
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
passed=0
failed=0

# compiled OUT [OPTION]...: the tracer as SPIR-V
compiled() {
    local out=$1
    shift
    glslangValidator --quiet -V --target-env vulkan1.2 -I. -Ishaders -DBVH_WIDTH=2 "$@" shaders/vulkan/trace.comp -o "$out"
}

# specialised EFFECTS IN OUT: the instructions, names and debug information left out. Effects from bit 32 on are a word of their own.
specialised() {
    spirv-opt --target-env=vulkan1.2 --set-spec-const-default-value="0:$(($1 & 0xffffffff)) 6:$(($1 >> 32))" --freeze-spec-const --fold-spec-const-op-composite \
        --ccp --eliminate-dead-branches --eliminate-dead-functions --eliminate-dead-code-aggressive --eliminate-dead-const \
        --merge-blocks --strip-debug --compact-ids "$2" -o "$3.spv" &&
        spirv-dis --no-header --no-indent "$3.spv" -o "$3"
}

instructions() { grep -vcE '^Op(Decorate|MemberDecorate|Capability|Extension|EntryPoint|ExecutionMode)|= Op(Constant|Type)' "$1"; }
operations() { sed -E 's/^%[0-9]+ = //; s/ .*//' "$1" | grep -vE '^Op(Constant|Type)' | sort; }

rows=$(sed -n -E 's/^EFFECT\(([0-9]+), [A-Z_]+, ([A-Za-z]+),.*/\1 \2/p' shaders/kernel/effect_table.glsl)
[ -n "$rows" ] || { echo "no rows in effect_table.glsl"; echo "0 passed, 1 failed"; exit 1; }
# Paths do what other rays do, and glossy reflections what mirrors do: rows before those two are looked at without them. So do
# occlusion rays what images of occlusion do.
every=0
path=0
glossy=0
occlusion=0
while read -r bit name; do
    every=$((every | 1 << bit))
    [ "$name" = path ] && path=$((1 << bit))
    [ "$name" = glossyReflections ] && glossy=$((1 << bit))
    [ "$name" = ambientOcclusion ] && occlusion=$((1 << bit))
done <<<"$rows"
whole=$every

compiled "$folder/trace.spv" || { echo "0 passed, 1 failed"; exit 1; }
printf '%-26s %12s %12s %12s\n' effect "all effects" "without it" "row removed"

# row BIT NAME EVERY: prints its line, FAILED in it if it keeps anything.
row() {
    local bit=$1 name=$2 every=$3 own=$folder/$1 all=$folder/all-$3
    if ! { compiled "$own.removed.spv" "-DLEFT_OUT=$(((1 << bit) & 0xffffffff))u" "-DLEFT_OUT_LAYERS=$((1 << bit >> 32))u" &&
        specialised "$every" "$own.removed.spv" "$own.removed" &&
        specialised $((every & ~(1 << bit))) "$folder/trace.spv" "$own.off"; }; then
        echo "$name: FAILED: does not compile"
        return
    fi
    printf '%-26s %12d %12d %12d' "$name" "$(instructions "$all")" "$(instructions "$own.off")" "$(instructions "$own.removed")"
    if ! diff -q <(operations "$own.off") <(operations "$own.removed") >/dev/null; then
        echo "  FAILED: something of it is left"
    elif cmp -s "$own.off" "$all"; then
        echo "  FAILED: nothing asks for it, so nothing is left out"
    else
        echo
    fi
}

# As many at a time as there are processors; their lines in the table's order.
while read -r bit name; do
    case $name in
        path) every=$whole ;;
        glossyReflections) every=$((whole & ~path)) ;;
        occlusionTextures) every=$((whole & ~path & ~occlusion)) ;;
        *) every=$((whole & ~path & ~glossy)) ;;
    esac
    [ -f "$folder/all-$every" ] || specialised "$every" "$folder/trace.spv" "$folder/all-$every" || { echo "0 passed, 1 failed"; exit 1; }
    while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n; done
    row "$bit" "$name" "$every" >"$folder/$bit.line" &
done <<<"$rows"
wait
while read -r bit name; do
    cat "$folder/$bit.line"
    if [ ! -s "$folder/$bit.line" ] || grep -q FAILED "$folder/$bit.line"; then failed=$((failed + 1)); else passed=$((passed + 1)); fi
done <<<"$rows"
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" -gt 0 ]
