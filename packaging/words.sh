#!/bin/bash
# What packages say beside the programs, made from what the programs say themselves: manual pages, bash completion and the
# commented configuration. words.sh HELIOGRAPH HELIOGRAPH_LOAD FOLDER
set -euo pipefail
here=$(dirname "$(readlink -f "$0")")
program=$(readlink -f "$1") load=$(readlink -f "$2") out=$3
rm -rf "$out"
mkdir -p "$out/man1" "$out/completions"
export LC_ALL=C.UTF-8
version=$("$program" --version | awk '{ print $2 }')

commands_of() { awk '/^Subcommands:$/ { on = 1; next } /^[^ ]/ { on = 0 } on && /^  [a-z]/ { print $1 }'; }

# page NAME PROGRAM COMMAND...: the manual page of a command.
page() {
    local name=$1
    shift
    "$@" --help | awk -v page="$name" -v version="$version" -f "$here/man_page.awk" | gzip -9n >"$out/man1/$name.1.gz"
}

branches=
# tell COMMAND...: page and completion of this command of the program and of those below it.
tell() {
    local help below
    help=$("$program" "$@" --help)
    page "$(IFS=- && echo "heliograph $*" | sed 's/ $//; s/ /-/g')" "$program" "$@"
    branches+=$(awk -v command="$*" -f "$here/completion.awk" <<<"$help")$'\n'
    for below in $(commands_of <<<"$help"); do tell "$@" "$below"; done
}
tell
page heliograph-load "$load"

scenes=$("$program" inspect --help | awk '/^  SCENE/ { sub(/^ *SCENE TEXT[^ ]*( REQUIRED)? +/, ""); sub(/, or a .*/, ""); gsub(/,/, ""); print }')
while IFS= read -r line; do
    case $line in
        '@BRANCHES@') printf '%s' "$branches" ;;
        '@LOAD@') "$load" --help | awk -v command=heliograph-load -f "$here/completion.awk" ;;
        *) printf '%s\n' "${line//@SCENES@/$scenes}" ;;
    esac
done <"$here/completion.in" >"$out/completions/heliograph"
cp "$out/completions/heliograph" "$out/completions/heliograph-load"  # each package has its own

# Every option as the program knows it, commented out at its default.
{
    cat "$here/heliograph.toml.head"
    env -i PATH="$PATH" "$program" serve --print-config | sed -n '/^[a-z]/ s/ *# default$//p' | sed 's/^/#/'
    printf '\n[set]\n#samples = 64\n'
} >"$out/heliograph.toml"
