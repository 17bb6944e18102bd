#!/bin/bash
# Measures a machine with a GPU from inside an unpacked bundle (cmake/bundle.cmake, component `bench`): installs nothing,
# needs only the vendor's Vulkan driver. gpu_box.sh FOLDER [DEVICE] writes JSON, pictures and a log to FOLDER; under twelve minutes.
set -u
out=${1:?gpu_box.sh FOLDER [DEVICE]}
device=${2:-}
here=$(cd "$(dirname "$(readlink -f "$0")")" && pwd)
mkdir -p "$out"
export LD_LIBRARY_PATH=$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
export VK_LAYER_PATH=$here/share/vulkan/explicit_layer.d
bench=$here/bin/heliograph-bench
log=$out/log.txt
failed=0
: >"$log"

# step NAME SECONDS ARGUMENTS...: one run; its JSON goes to NAME.json.
step() {
    local name=$1 seconds=$2
    shift 2
    local begin=$SECONDS
    if timeout -k 5 "$seconds" "$bench" "$@" ${device:+--device "$device"} >"$out/$name.json" 2>>"$log"; then
        echo "ok     $name ($((SECONDS - begin)) s)" | tee -a "$log"
    else
        echo "FAILED $name (exit code $?, $((SECONDS - begin)) s)" | tee -a "$log"
        failed=$((failed + 1))
    fi
}

{
    uname -sr
    grep -m 1 'model name' /proc/cpuinfo
    nproc
    command -v nvidia-smi >/dev/null && nvidia-smi --query-gpu=name,driver_version,clocks.sm,clocks.max.sm --format=csv
} >"$out/machine.txt" 2>&1

step devices 30 devices
if [ "$failed" != 0 ] || ! grep -q '"type": "\(discrete\|integrated\|virtual\)"' "$out/devices.json"; then
    echo "no GPU was found by the Vulkan loader; where the driver keeps its manifest elsewhere, set VK_DRIVER_FILES" | tee -a "$log"
fi
step start 60 start
step rays 90 rays
step rays-4k 90 rays --size 3840x2160 --repetitions 15
step frames 90 frames
step hybrid 240 hybrid
step effects 240 effects --repetitions 5
step reach 60 reach
step switch 120 switch
step switch-again 120 switch
step parity 120 parity --out "$out"
step validated 60 parity --validation --size 320x180 --out "$(mktemp -d)"
echo "$failed failed" | tee -a "$log"
[ "$failed" = 0 ]
