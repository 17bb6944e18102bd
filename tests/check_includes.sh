#!/bin/sh
# The include rules of docs/guide/rooms.md: which folder may include which, and who may use which library.
# check_includes.sh [ROOT]: prints every breach as FILE:LINE and why; exit code 1 if there is one.
# check_includes.sh --self-test: plants breaches in a scratch tree and sees that each is found.
set -eu

# One row per folder of server/: FOLDER MAY-INCLUDE... The longest folder that fits a path is its folder.
FOLDERS='
base
kernel               base
scene                base kernel
scene/build          base kernel scene scene/light scene/media
scene/light          base kernel scene scene/build
scene/media          base kernel scene scene/build
scene/generate       base kernel scene scene/build
images               base
images/module        images
scene/load           base kernel scene images scene/build scene/generate
request              base kernel scene
film                 base kernel scene request
device               base kernel scene request film
denoise              base kernel scene request film shaders
schedule             base kernel scene request film device
render               base kernel scene request film device denoise schedule
device/embree        base kernel scene request film device
device/vulkan/core   base kernel
device/vulkan/tree   base kernel scene device/vulkan/core
device/vulkan/denoise base kernel scene request film device denoise device/vulkan/core
device/vulkan/trace  base kernel scene request film device denoise device/vulkan/core device/vulkan/denoise device/vulkan/tree shaders
device/vulkan/raster base kernel scene request film device device/vulkan/core device/vulkan/trace
device/vulkan/bench  base kernel scene request film device device/vulkan/core device/vulkan/tree device/vulkan/trace
device/remote        base kernel scene request film device pool pool/wire
encode               base kernel images
net/guard            base
net/listen           base net/guard
uploads              base net/guard
net                  base kernel scene request net/guard net/listen uploads
pool/wire            base kernel scene request film
pool                 base kernel scene request film net/guard pool/wire
pool/node            base kernel scene request film device schedule render pool pool/wire
lab                  base kernel scene request film device schedule render
lab/accuracy         base kernel scene images request film device schedule render encode lab pace
lab/live             base kernel scene request film device denoise schedule render encode lab lab/accuracy pace
lab/view             base kernel scene request film device schedule render encode loop lab lab/accuracy
lab/convergence      base kernel scene request film device render lab lab/accuracy
pace                 base
loop                 base kernel scene request film device denoise schedule render pace
viewer               base kernel scene scene/load request film device schedule render pace loop encode net net/guard
stream               base kernel scene scene/load request film device schedule render pace loop net net/guard viewer lab/view
operations           base kernel scene request film net net/guard net/listen viewer
service              base kernel scene scene/load request film device schedule render loop encode net net/guard viewer stream operations
app                  base kernel scene scene/load request film device denoise schedule render loop device/embree device/vulkan/trace device/vulkan/raster device/vulkan/bench device/remote images encode net net/guard net/listen pool pool/wire pool/node lab lab/accuracy lab/convergence lab/live viewer stream operations service uploads
main             base app
'
# PREFIX-OF-HEADER FOLDERS-THAT-MAY-USE-IT...
LIBRARIES='
embree3/         device/embree device/vulkan/tree
vulkan/          device/vulkan/core device/vulkan/denoise device/vulkan/tree device/vulkan/trace device/vulkan/raster device/vulkan/bench
libwebsockets    net
nats             pool
turbojpeg.h      images encode
vpx/             encode
wels/            encode
jpeglib.h        encode
png.h            images encode
webp/            images
OpenImageIO/     images/module
tiny_gltf.h      scene/load
draco/           scene/load
meshoptimizer.h  scene/load
CLI/             app main
tbb/             scene/build scene/light scene/generate scene/load denoise render encode device/embree device/vulkan/tree device/vulkan/trace device/vulkan/raster
toml++/          operations
prometheus/      operations
gtest/           tests
gmock/           tests
'

check() {
    find "$1/server" "$1/shaders" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.glsl' -o -name '*.comp' \
        -o -name '*.vert' -o -name '*.frag' \) | sort | sed "s|^$1/||" | awk -v root="$1" -v folders="$FOLDERS" -v libraries="$LIBRARIES" '
    function folderOf(path,    best, name) {
        if (path ~ /^shaders\/kernel\//) return "kernel"
        if (path ~ /^shaders\//) return "shaders"
        if (path ~ /^server\/main\.cpp$/) return "main"
        sub(/^server\//, "", path)
        best = ""
        for (name in allowed) if (index(path, name "/") == 1 && length(name) > length(best)) best = name
        return best
    }
    function breach(why) { printf "%s:%d: %s\n", file, line, why; breaches++ }
    function project(target, folder,    other) {
        if (target !~ /^(server|shaders)\//) {
            # Inside shaders/, neighbours are named by their path from the including file.
            if ((folder == "kernel" || folder == "shaders") && target !~ /\.\./) return
            breach("\"" target "\": project files are included by their path from the root, server/... or shaders/...")
            return
        }
        other = folderOf(target)
        if (other == folder && other != "") return
        if (folder == "shaders" && other == "kernel") return
        if (other == "" || !index(" " allowed[folder] " ", " " other " "))
            breach(folder " may not include " target "; allowed: " folder " " allowed[folder])
    }
    function library(target, folder,    prefix) {
        for (prefix in users)
            if (index(target, prefix) == 1 && !index(" " users[prefix] " ", " " folder " "))
                breach("<" target "> belongs to " users[prefix] ", not to " folder)
    }
    BEGIN {
        count = split(folders, rows, "\n")
        for (i = 1; i <= count; i++) if (split(rows[i], field, " ") > 0) {
            list = ""
            n = split(rows[i], field, " ")
            for (j = 2; j <= n; j++) list = list " " field[j]
            allowed[field[1]] = substr(list, 2)
        }
        count = split(libraries, rows, "\n")
        for (i = 1; i <= count; i++) if (split(rows[i], field, " ") > 0) {
            list = ""
            n = split(rows[i], field, " ")
            for (j = 2; j <= n; j++) list = list " " field[j]
            users[field[1]] = substr(list, 2)
        }
        allowed["kernel"] = ""
    }
    {
        file = $0
        line = 0
        files++
        folder = folderOf(file)
        if (folder == "") { breach("no row for its folder in tests/check_includes.sh"); next }
        pragma = (file !~ /\.h$/)
        while ((getline text < (root "/" file)) > 0) {
            line++
            if (text ~ /^[ \t]*#[ \t]*pragma[ \t]+once/) pragma = 1
            if (text !~ /^[ \t]*#[ \t]*include/) continue
            if (match(text, /"[^"]+"/)) project(substr(text, RSTART + 1, RLENGTH - 2), folder)
            else if (match(text, /<[^>]+>/)) library(substr(text, RSTART + 1, RLENGTH - 2), folder)
        }
        close(root "/" file)
        line = 1
        if (!pragma) breach("a header without #pragma once")
    }
    END {
        if (files == 0) { print "no source files found under " root; exit 1 }
        printf "%d files, %d breaches\n", files, breaches
        exit breaches > 0
    }'
}

selfTest() {
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    mkdir -p "$scratch/server/base" "$scratch/server/film" "$scratch/server/device/embree" "$scratch/server/lost" \
        "$scratch/shaders/kernel"
    echo '#pragma once' >"$scratch/server/base/good.h"
    printf '#pragma once\n#include "server/base/good.h"\n#include <vector>\n' >"$scratch/server/film/good.h"
    check "$scratch" >/dev/null || { echo "self-test: a tree without breaches was refused"; exit 1; }
    plant() {  # FILE LINES: the check must now fail, and name the file
        mkdir -p "$(dirname "$scratch/$1")"
        printf "$2" >"$scratch/$1"
        if found=$(check "$scratch"); then echo "self-test: not found: $1: $2"; exit 1; fi
        case $found in *"$1:"*) ;; *) echo "self-test: $1 is not named in: $found"; exit 1 ;; esac
        rm "$scratch/$1"
    }
    plant server/base/up.h '#pragma once\n#include "server/film/good.h"\n'
    plant server/film/gpu.h '#pragma once\n#include <embree3/rtcore.h>\n'
    plant server/film/near.cpp '#include "good.h"\n'
    plant server/film/back.cpp '#include "../base/good.h"\n'
    plant server/device/embree/other.cpp '#include "server/device/vulkan/trace/vulkan_device.h"\n'
    plant server/lost/alone.cpp 'int x;\n'
    plant server/base/twice.h 'int x;\n'
    plant shaders/kernel/up.h '#pragma once\n#include "server/base/good.h"\n'
    plant server/main.cpp '#include "server/device/embree/device.h"\n'
    echo "self-test: every planted breach was found"
}

case ${1:-} in
    --self-test) selfTest ;;
    *) check "${1:-.}" ;;
esac
