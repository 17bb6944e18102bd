#!/bin/bash
# The program starts light: it links no picture library but those for PNG and JPEG, and works without the picture module.
# check_start.sh [BUILD]: a line per failure; the last line is `N passed, N failed`.
set -u
cd "$(dirname "$(readlink -f "$0")")/.." || exit 1
program=$(readlink -f "${1:-build/release}")/heliograph
passed=0
failed=0
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export HELIOGRAPH_CACHE=

# expect NAME CONDITION...: a command that must succeed.
expect() {
    local name=$1
    shift
    if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED $name: $(head -c 300 "$scratch/said" 2>/dev/null)"; fi
}

# Libraries at start. It would be 260 with OpenImageIO.
ldd "$program" >"$scratch/said" 2>&1
libraries=$(grep -c '=>' "$scratch/said")
expect "ldd finds everything" [ "$libraries" -gt 5 -a "$(grep -c 'not found' "$scratch/said")" = 0 ]
expect "at most 24 libraries ($libraries)" [ "$libraries" -le 24 ]
expect "no OpenImageIO" [ "$(grep -c -i -E 'OpenImageIO|OpenEXR|Imath|libtiff|libheif|ffmpeg|avcodec' "$scratch/said")" = 0 ]

# Processor time, the least of 40 runs: what others take of the machine is not the program's.
read -r micros peak < <(python3 -c 'import os, subprocess, sys
least = peak = 0
for _ in range(40):
    child = subprocess.Popen([sys.argv[1], "--version"], stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if status: sys.exit("it ended with %d" % status)
    micros = int((used.ru_utime + used.ru_stime) * 1e6)
    least, peak = min(least or micros, micros), max(peak, used.ru_maxrss)
print(least, peak)' "$program")
expect "--version in at most 20 ms ($micros us)" [ "${micros:-999999}" -le 20000 ]
expect "--version in at most 20 MB ($peak KB)" [ "${peak:-999999}" -le 20000 ]

# model NAME TYPE BASE64: a triangle with this texture.
model() {
    cat >"$scratch/$1.gltf" <<JSON
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":0}],
"images":[{"mimeType":"image/$2","uri":"data:image/$2;base64,$3"}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
JSON
}
model png png iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==
model exr png di8xAQIAAAA=

# run NAME CODE TEXT ARGUMENTS...: the program without the module must end with CODE and say TEXT.
run() {
    local name=$1 code=$2 text=$3 status
    shift 3
    HELIOGRAPH_IMAGE_MODULE=$scratch/none.so "$program" "$@" >"$scratch/said" 2>&1
    status=$?
    expect "$name: exit code $status" [ $status = "$code" ]
    expect "$name: says '$text'" grep -q -F -- "$text" "$scratch/said"
}
small=(--size 32x18 --samples 1 --device embree)
run "without the module, a scene without pictures" 0 "" render cornell "${small[@]}" --out "$scratch/a.png"
run "without the module, the same as JPEG" 0 "" render cornell "${small[@]}" --out "$scratch/a.jpg"
model jpeg jpeg "$(base64 -w 0 "$scratch/a.jpg")"
run "without the module, a texture as JPEG" 0 '"textures": 1' inspect "$scratch/jpeg.gltf" --json
run "without the module, a texture as PNG" 0 '"textures": 1' inspect "$scratch/png.gltf" --json
run "without the module, a texture as OpenEXR" 0 "was not found as $scratch/none.so" inspect "$scratch/exr.gltf"
run "without the module, the film as OpenEXR" 2 "was not found as $scratch/none.so" render cornell "${small[@]}" --out "$scratch/a.exr"
run "without the module, an environment as PNG" 0 "" render cornell "${small[@]}" --out "$scratch/b.png" --environment "$scratch/a.png"
printf '#?RADIANCE\n' >"$scratch/sky.hdr"
run "without the module, an environment as Radiance HDR" 2 "HELIOGRAPH_IMAGE_MODULE" inspect "$scratch/png.gltf" --environment "$scratch/sky.hdr"
"$program" render cornell "${small[@]}" --out "$scratch/c.exr" >"$scratch/said" 2>&1
expect "with the module, the film as OpenEXR" [ -s "$scratch/c.exr" ]

# The folder for another machine (cmake/bundle.cmake): small, and with every library but glibc's.
cmake --install "$(dirname "$program")" --strip --component server --prefix "$scratch/server" >"$scratch/said" 2>&1
bytes=$(find "$scratch/server" -type f -printf '%s\n' | awk '{ sum += $1 } END { print sum + 0 }')
# Embree alone is 44 MB; libcrypto 5.
expect "the server's folder holds at most 66 MB ($bytes bytes)" [ "$bytes" -gt 1000000 -a "$bytes" -le 66000000 ]
packed=$(tar -C "$scratch" -cJ server | wc -c)
expect "packed at most 25 MB ($packed bytes)" [ "$packed" -gt 1000000 -a "$packed" -le 25000000 ]
ldd "$scratch/server/bin/heliograph" | grep -F '=> /' | grep -v -F "$scratch/server/" |
    grep -v -E '/lib(c|m|dl|rt|pthread|resolv|util|mvec)\.so' >"$scratch/said"
expect "every library of the folder is its own" [ ! -s "$scratch/said" ]
"$scratch/server/bin/heliograph" render cornell "${small[@]}" --out "$scratch/d.exr" >"$scratch/said" 2>&1
expect "the folder has no picture module" grep -q "$scratch/server/lib/heliograph/heliograph-images.so" "$scratch/said"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
