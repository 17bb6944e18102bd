#!/bin/bash
# What the pages of docs/ and README.md promise: links lead somewhere, named files exist, lines are short.
# check_docs.sh [ROOT]: prints every breach as FILE:LINE and why; the last line is `N passed, N failed`, a file each.
# check_docs.sh --self-test: plants breaches in a scratch tree and sees that each is found.
set -u
export LC_ALL=C.UTF-8
COLUMNS_MOST=100

# anchors FILE: the anchors of its headings, as web views of Markdown make them.
anchors() {
    awk '/^```/ { code = !code } !code && /^#+ / { sub(/^#+ /, ""); print tolower($0) }' "$1" |
        sed -E 's/\[([^]]*)\]\([^)]*\)/\1/g; s/[^[:alnum:] _-]//g; s/ /-/g'
}

# prose FILE: its lines, those of code blocks empty.
prose() { awk '/^```/ { code = !code } { print code || /^(```|    )/ ? "" : $0 }' "$1"; }

# check_page ROOT FILE: breaches of one page.
check_page() {
    local root=$1 file=$2 folder line target path anchor
    folder=$(dirname "$root/$file")
    grep -nE "^.{$((COLUMNS_MOST + 1)),}" "$root/$file" |
        sed -E "s|^([0-9]+):.*|$file:\1: over $COLUMNS_MOST columns|"
    while IFS=$'\t' read -r line target; do
        case $target in '' | http://* | https://*) continue ;; esac
        path=${target%%#*}
        anchor=
        [[ $target == *#* ]] && anchor=${target#*#}
        if [ -n "$path" ] && [ ! -e "$folder/$path" ]; then
            echo "$file:$line: link to $target, where nothing is"
        elif [ -n "$anchor" ] && ! anchors "$folder/${path:-${file##*/}}" | grep -qxF -- "$anchor"; then
            echo "$file:$line: link to $target, which has no such heading"
        fi
    done < <(prose "$root/$file" | grep -noE '\]\([^) ]+\)' | sed -E 's/^([0-9]+):\]\((.*)\)$/\1\t\2/')
    # A path in backticks that begins with a folder of the repository.
    while IFS=$'\t' read -r line target; do
        [ -e "$root/$target" ] || echo "$file:$line: names $target, which does not exist"
    done < <(prose "$root/$file" | grep -noE '`(server|shaders|client-web|tests|tools|docs|cmake|scenes)/[A-Za-z0-9_./-]+`' |
        sed -E 's/^([0-9]+):`(.*)`$/\1\t\2/' | grep -vE $'\tclient-web/(dist|node_modules)')
}

check() {
    local root=$1 file found passed=0 failed=0
    while read -r file; do
        found=$(check_page "$root" "$file")
        if [ -z "$found" ]; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "$found"; fi
    done < <(cd "$root" && find README.md docs docker -name '*.md' 2>/dev/null | sort)
    echo "$passed passed, $failed failed"
    [ $failed = 0 ] && [ $passed -gt 0 ]
}

self_test() {
    local found expected wrong=0
    tree=$(mktemp -d)
    trap 'rm -rf "$tree"' EXIT
    mkdir -p "$tree/docs" "$tree/server"
    touch "$tree/server/here.h"
    printf '# A page\n\n[good](docs/b.md#two-words), `server/here.h`, [out](https://example.org)\n' >"$tree/README.md"
    printf '## Two words\n\n[self](#two-words) [up](../README.md)\n\n    [in code](nowhere.md)\n' >"$tree/docs/b.md"
    check "$tree" >/dev/null || { echo "FAILED a sound tree is refused"; wrong=1; }
    printf '[a](gone.md)\n[b](../README.md#gone)\n`server/gone.h`\n%s\n' "$(printf 'x%.0s' {1..101})" >"$tree/docs/c.md"
    found=$(check "$tree")
    for expected in 'c.md:1: link to gone.md' 'c.md:2: link to ../README.md#gone' 'c.md:3: names server/gone.h' 'c.md:4: over 100 columns'; do
        grep -qF "$expected" <<<"$found" || { echo "FAILED not found: $expected"; wrong=1; }
    done
    [ $wrong = 0 ] && echo "self-test passed"
    return $wrong
}

if [ "${1:-}" = --self-test ]; then self_test; else check "${1:-.}"; fi
