#!/bin/sh
# The program runs on every x86-64-v2 processor and picks newer instructions at start. So newer code may be only in
# heliograph::lanes_v3 and lanes_v4, the linker may not be able to give such code to others, and nothing is fused (the same
# bits on every device).
# check_isa.sh [BUILD]: prints every breach in that build (build/release); the last line is `N passed, N failed`.
# check_isa.sh --self-test: plants breaches in listings and sees that each is found.
set -eu

# Reads `objdump -d --no-show-raw-insn`: breaches on stdout, exit code 1 if there is one or if no newer code was seen at
# all. tzcnt counts as old: without BMI it is bsf, and the compiler emits it only where both give the same.
judgeCode() {
    awk '
    function breach(why) { if (!seen[name why]++) { printf "%s: %s: %s\n", name, why, $0; breaches++ } }
    /^[0-9a-f]+ <.*>:$/ { name = $2; sub(/^</, "", name); sub(/>:$/, "", name); next }
    !/^ *[0-9a-f]+:\t/ { next }
    {
        isa = name ~ /10heliograph8lanes_v4/ ? 4 : name ~ /10heliograph8lanes_v3/ ? 3 : 2
        if (name ~ /_GLOBAL__sub_I|_GLOBAL__sub_D/) isa = 2  # runs on every processor
        op = $2
        if (op == "lock" || op ~ /^rep/ || op == "notrack" || op == "bnd") op = $3
        if (op ~ /^vfn?m(add|sub)/) breach("fused arithmetic")
        newer = op ~ /^v/ || op ~ /^k[a-z]+[bwdq]$/ || op ~ /^(andn|bextr|bls(r|i|msk)|bzhi|pdep|pext|rorx|sarx|shlx|shrx|mulx|lzcnt|movbe)[wlq]?$/
        wide = /%zmm|%k[0-7]|%[xy]mm(1[6-9]|2[0-9]|3[01])/
        if (wide && isa < 4) breach("AVX-512 outside lanes_v4")
        else if (newer && isa < 3) breach("x86-64-v3 outside lanes_v3 and lanes_v4")
        if (newer) count[isa]++
    }
    END {
        if (!count[3] || !count[4]) { print "no code of lanes_v3 or of lanes_v4 was found"; breaches++ }
        exit breaches > 0
    }'
}

# Reads `nm --defined-only` of the object of lanes_$1: functions that other objects can see.
judgeSymbols() {
    awk -v own="10heliograph8lanes_$1" '
    $2 == "t" { functions++ }  # of the file alone
    $2 ~ /^[TWuVi]$/ {
        functions++
        if (index($3, own) || $3 ~ /^(_ZTI|_ZTS|_ZTV|DW\.ref)/) next  # tables hold no code
        printf "lanes_%s: %s can be linked into the rest of the program\n", substr(own, length(own) - 1), $3
        breaches++
    }
    END {
        if (!functions) { print "no symbols"; breaches++ }
        exit breaches > 0
    }'
}

passed=0
failed=0
expect() {  # NAME STATUS OUTPUT
    if [ "$2" = 0 ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED $1"; echo "$3" | head -n 20; fi
}

checkBuild() {
    status=0
    found=$(objdump -d --no-show-raw-insn "$1/heliograph" | judgeCode) || status=1
    expect "instructions of $1/heliograph" $status "$found"
    for which in tiles:device/embree/tile_programs_isa filter:denoise/filter_isa; do for isa in v2 v3 v4; do
        status=0
        object=$1/CMakeFiles/heliograph_${which%%:*}_$isa.dir/server/${which#*:}.cpp.o
        # A file that an earlier build left behind says nothing.
        if grep -qF "build ${object#"$1"/}:" "$1/build.ninja"; then
            found=$(nm --defined-only "$object" | judgeSymbols $isa) || status=1
        else
            found="$1/build.ninja does not make it" status=1
        fi
        expect "symbols of $object" $status "$found"
    done; done
    echo "$passed passed, $failed failed"
    [ $failed = 0 ]
}

selfTest() {
    function_() { printf '0000000000001000 <%s>:\n    1000:\t%s\n' "$1" "$2"; }
    good() {
        function_ _ZN10heliograph8lanes_v31fEv 'vaddps %ymm0,%ymm1,%ymm2'
        function_ _ZN10heliograph8lanes_v41fEv 'vaddps %zmm0,%zmm1,%zmm2'
        function_ _ZN10heliograph8lanes_v21fEv 'pextrd $0x1,%xmm0,%eax'
        function_ main 'rep tzcnt %eax,%ebx'
    }
    good | judgeCode || { echo "self-test: good code was refused"; exit 1; }
    plant() {
        if found=$({ good; function_ "$1" "$2"; } | judgeCode); then echo "self-test: not found: $1: $2"; exit 1; fi
        case $found in "$1: $3"*) ;; *) echo "self-test: not as expected: $found"; exit 1 ;; esac
    }
    plant _ZN3glm3dotEv 'vmulss %xmm0,%xmm1,%xmm2' x86-64-v3
    plant _ZN10heliograph8lanes_v21fEv 'shlx %eax,%ebx,%ecx' x86-64-v3
    plant _GLOBAL__sub_I__ZN10heliograph8lanes_v413PROGRAM_TABLEE 'vxorps %xmm0,%xmm0,%xmm0' x86-64-v3
    plant _ZN10heliograph8lanes_v31gEv 'vaddps %zmm0,%zmm1,%zmm2' AVX-512
    plant _ZN10heliograph8lanes_v31gEv 'vmovaps %xmm17,%xmm1' AVX-512
    plant _ZN10heliograph8lanes_v41gEv 'vfmadd231ps %zmm0,%zmm1,%zmm2' 'fused arithmetic'
    if function_ main 'mov %eax,%ebx' | judgeCode >/dev/null; then echo "self-test: a program without lanes passed"; exit 1; fi
    own='0000 W _ZN10heliograph8lanes_v41fEv'
    echo "$own" | judgeSymbols v4 || { echo "self-test: good symbols were refused"; exit 1; }
    if printf '%s\n%s\n' "$own" '0000 W _ZN3glm3dotEv' | judgeSymbols v4 >/dev/null; then echo "self-test: glm::dot passed"; exit 1; fi
    if echo "$own" | judgeSymbols v3 >/dev/null; then echo "self-test: another build's symbol passed"; exit 1; fi
    echo "self-test: every planted breach was found"
}

case ${1:-} in
    --self-test) selfTest ;;
    *) checkBuild "${1:-build/release}" ;;
esac
