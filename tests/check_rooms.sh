#!/bin/sh
# How large the rooms are. check_rooms.sh [ROOT]: a row per folder of server/ and shaders/ (files, lines, the rooms that it
# includes), then every folder, file or function that is too large, as FILE:LINE and why; exit code 1 if there is one.
# check_rooms.sh --self-test: plants what is too large in a scratch tree and sees that each is found.
# A folder holds at most 28 files and 2,700 lines (scene/generate and scene/load apart: a file per scene or format), a file
# at most 500 lines, a function at most 60.
set -eu

check() {
    (cd "$1" && find server shaders -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.inc' -o -name '*.glsl' -o -name '*.comp' \
        -o -name '*.vert' -o -name '*.frag' \) | sort) | awk -v root="$1" '
    function folderOf(path) { sub(/\/[^\/]*$/, "", path); sub(/^server\//, "", path); return path }
    function breach(line, why) { printf "%s:%d: %s\n", file, line, why > "/dev/stderr"; breaches++ }
    # A function begins where a line at most one level in ends with ") {", "const {" or the like, and ends at the brace in the
    # column where that line began. Types, namespaces and initialisers are none.
    function opens(text) { return text ~ /^(    )?[A-Za-z_~].*\).*\{$/ && text !~ /^ *(namespace|struct|class|enum|union|if|for|while|switch|else|do)[ (]/ && text !~ /=[ ]*\{$/ }
    {
        file = $0
        folder = folderOf(file)
        if (!(folder in files)) order[++folders] = folder
        files[folder]++
        line = 0; inside = 0
        while ((getline text < (root "/" file)) > 0) {
            line++
            if (match(text, /^#[ ]*include "[^"]+"/)) {
                target = text; sub(/^[^"]*"/, "", target); sub(/".*/, "", target)
                if (target !~ /^server\//) target = target ~ /^shaders\// ? target : "shaders/" target
                target = folderOf(target)
                if (target ~ /^shaders\/.*\..*/ || target == "shaders") continue
                if (target != folder && !((folder, target) in seen)) { seen[folder, target] = 1; uses[folder] = uses[folder] " " target }
            }
            if (!inside && opens(text)) { inside = line; match(text, /^ */); indent = RLENGTH; continue }
            if (inside) {
                match(text, /^ */)
                if (RLENGTH == indent && substr(text, indent + 1, 1) == "}") {
                    if (line - inside + 1 > 60) breach(inside, "a function of " (line - inside + 1) " lines; at most 60")
                    inside = 0
                }
            }
        }
        close(root "/" file)
        lines[folder] += line
        if (line > 500) breach(line, "a file of " line " lines; at most 500")
    }
    END {
        if (!folders) { print "no source files found under " root; exit 1 }
        printf "%-24s %5s %6s  %s\n", "room", "files", "lines", "includes"
        for (i = 1; i <= folders; i++) {
            folder = order[i]
            printf "%-24s %5d %6d %s\n", folder, files[folder], lines[folder], uses[folder]
            allFiles += files[folder]; allLines += lines[folder]
            if (folder == "scene/generate" || folder == "scene/load") continue
            file = folder
            if (files[folder] > 28) breach(0, files[folder] " files in a folder; at most 28")
            if (lines[folder] > 2700) breach(0, lines[folder] " lines in a folder; at most 2700")
        }
        printf "%-24s %5d %6d  %d too large\n", "all", allFiles, allLines, breaches
        exit breaches > 0
    }'
}

selfTest() {
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    mkdir -p "$scratch/server/base" "$scratch/shaders/kernel"
    printf '#pragma once\nint small() {\n    return 1;\n}\n' >"$scratch/server/base/good.h"
    check "$scratch" >/dev/null 2>&1 || { echo "self-test: a small tree was refused"; exit 1; }
    seen() {  # FILE WHY: the check must now fail, naming both
        if found=$(check "$scratch" 2>&1); then echo "self-test: not found: $1"; exit 1; fi
        case $found in *"$1:"*"$2"*) ;; *) echo "self-test: $1 is not named in: $found"; exit 1 ;; esac
    }
    { echo 'int long() {'; yes '    f();' | head -n 60; echo '}'; } >"$scratch/server/base/long.cpp"
    seen server/base/long.cpp "a function of 62 lines"
    rm "$scratch/server/base/long.cpp"
    { echo 'struct S {'; echo '    int inner() const {'; yes '        f();' | head -n 70; echo '    }'; echo '};'; } >"$scratch/shaders/kernel/inner.glsl"
    seen shaders/kernel/inner.glsl "a function of 72 lines"
    rm "$scratch/shaders/kernel/inner.glsl"
    yes '// x' | head -n 501 >"$scratch/server/base/file.h"
    seen server/base/file.h "a file of 501 lines"
    rm "$scratch/server/base/file.h"
    for i in $(seq 28); do echo "int x$i;" >"$scratch/server/base/part$i.cpp"; done
    seen base "29 files in a folder"
    echo "self-test: everything too large was found"
}

case ${1:-} in
    --self-test) selfTest ;;
    *) check "${1:-.}" ;;
esac
