#!/bin/bash
# The walk of a frame: docs/guide/frame.md lists, between the socket's message and the sent picture, every file that a frame
# enters, by which function, and the call that leads on. This reads the code and sees that each function is in its file, that
# it (or a function of the same file that it calls) makes that call, that what is handed over to another thread goes through
# the slot named, and that there are no more rows, files and second visits than allowed.
# check_walk.sh: a line per row, then the counts; exit code 1 if something does not hold.
# check_walk.sh --self-test: spoils copies of the list and sees that each is found.
set -u
cd "$(dirname "$(readlink -f "$0")")/.." || exit 1
MOST_CALLS=17
MOST_FILES=14
MOST_TWICE=3

# bodies FILE: NAME<tab>BODY, a line per function. By the layout of .clang-format a definition begins in column 1 or, in a
# class, 5.
bodies() {
    awk '
    function flush() { print name "\t" text; name = "" }
    name == "" && match($0, /^(    )?[A-Za-z_~][^;=#]*\(/) && $0 !~ /^ *(if|for|while|switch|return|else|using|namespace|class|struct|enum|throw|case|static_assert)[ (]/ {
        head = $0
        sub(/\(.*/, "", head)
        count = split(head, part, /[^A-Za-z0-9_~]+/)
        name = part[count]
        text = ""
        depth = 0
        open = 0
    }
    name != "" {
        line = $0
        sub(/\/\/.*/, "", line)
        text = text " " line
        if (!open && line ~ /;$/) { name = ""; next }  # a declaration
        gsub(/"([^"\\]|\\.)*"/, "", line)
        if (line ~ /\{/) open = 1
        depth += gsub(/\{/, "{", line) - gsub(/\}/, "}", line)
        if (open && depth == 0 && line ~ /\}$/) flush()
    }' "$1"
}

# walks FUNCTION TEXT: reads bodies; the functions of the file by which FUNCTION comes to TEXT, or fails.
walks() {
    awk -F '\t' -v function_="$1" -v wanted="$2" '
    { body[$1] = body[$1] " " $2 }
    END {
        if (!(function_ in body)) exit 2
        queue[1] = function_; from[function_] = ""; last = 1
        for (i = 1; i <= last; i++) {
            at = queue[i]
            if (index(body[at], wanted)) {
                path = at
                for (back = from[at]; back != ""; back = from[back]) path = back " " path
                print path
                exit 0
            }
            for (other in body) {
                if (other in from || other == at) continue
                if (match(" " body[at], "[^A-Za-z0-9_.>]" other "\\(") || index(body[at], "self->" other "(")) { from[other] = at; queue[++last] = other }
            }
        }
        exit 3
    }'
}

# rows FILE: the table of the guide without its marks, FUNCTION|FILE|SLOT, TAKER|CALL, CALL...
rows() {
    sed -n '/^## The walk/,/^## /p' "$1" | grep -E '^\| `' | sed -E 's/`//g; s/^\| *//; s/ *\|$//; s/ *\| */|/g'
}

# check GUIDE: a row has to be entered by the call that is due: the first one of the row before, or where a row calls nothing
# (it returns) the next one of the row that called it.
check() {
    local failed=0 calls=0 functions=0 path number entry file slot taker leads call from found due=() files=()
    while IFS='|' read -r entry file slot leads; do
        number=$((++calls))
        file=server/$file
        taker=${slot#*,}
        taker=${taker# }
        slot=${slot%,*}
        files+=("$file")
        if [ $calls -gt 1 ]; then
            call=${due[0]:-nothing}
            due=("${due[@]:1}")
            call=${call##*[.>]}
            if [ "${call%_}" != "${entry##*::}" ]; then echo "row $number: $call is due, not $entry"; failed=1; fi
        fi
        if [ ! -f "$file" ]; then echo "row $number: no file $file"; failed=1; continue; fi
        from=${entry##*::}
        found=$from
        if [ -n "$slot" ]; then
            found=$(bodies "$file" | walks "$from" "$slot") || { echo "row $number: $entry in $file does not reach $slot"; failed=1; }
            from=$taker
            bodies "$file" | walks "$from" "$slot" >/dev/null || { echo "row $number: $taker in $file does not reach $slot"; failed=1; }
            found="$found | $from"
        elif [ -z "$leads" ]; then
            bodies "$file" | walks "$from" "" >/dev/null || { echo "row $number: no $entry in $file"; failed=1; }
        fi
        read -ra leads <<<"${leads//,/ }"
        due=("${leads[@]}" "${due[@]}")
        for call in "${leads[@]}"; do
            path=$(bodies "$file" | walks "$from" "$call(") || { echo "row $number: $from in $file does not get to $call"; failed=1; }
            found="$found ${path#"$from"} -> $call"
        done
        functions=$((functions + $(sed -E 's/-> [^ ]+//g; s/[|]//g' <<<"$found" | tr -s ' ' '\n' | grep . | sort -u | wc -l)))
        [ "${2:-}" = quiet ] || printf '%2d  %-40s %s\n' "$number" "$file" "$found"
    done < <(rows "$1")
    [ ${#due[@]} = 0 ] || { echo "left out: ${due[*]}"; failed=1; }
    local distinct twice
    distinct=$(printf '%s\n' "${files[@]}" | sort -u | wc -l)
    twice=$((calls - distinct))
    echo "$calls calls over $distinct files, $twice of them into a file that was entered before; $functions functions in all"
    if [ "$calls" = 0 ] || [ "$calls" -gt "$MOST_CALLS" ] || [ "$distinct" -gt "$MOST_FILES" ] || [ "$twice" -gt "$MOST_TWICE" ]; then
        echo "allowed: $MOST_CALLS calls over $MOST_FILES files, $MOST_TWICE into one entered before"
        failed=1
    fi
    return $failed
}

if [ "${1:-}" = --self-test ]; then
    spoilt=$(mktemp)
    trap 'rm -f "$spoilt"' EXIT
    for change in 's/`loop_.show`/`loop_.shew`/' 's/`Session::receive`/`Session::recieve`/' 's/newest_/newer_/' '/`PassRenderer::render`/d' 's/^## The walk/## A walk/'; do
        sed "$change" docs/guide/frame.md >"$spoilt"
        if cmp -s "$spoilt" docs/guide/frame.md || check "$spoilt" quiet >/dev/null; then echo "a breach was not found: $change"; exit 1; fi
    done
    exit 0
fi
check docs/guide/frame.md
