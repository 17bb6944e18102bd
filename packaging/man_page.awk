# A manual page from what `COMMAND --help` prints. awk -v page=heliograph-render -v version=0.1.0 -f man_page.awk
# A line at the margin that ends in a colon begins a section; in sections of options two columns of blanks begin an entry.

function escaped(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    if (text ~ /^[.']/) text = "\\&" text
    return text
}

function section(title) { if (title != heading) print ".SH " title; heading = title; example = 0 }

# An option, a positional or a command: its name and, behind at least two blanks, what it does.
function entry(line,    at, name) {
    sub(/^ +/, "", line)
    at = match(line, /  +/)
    name = at ? substr(line, 1, at - 1) : line
    print ".TP\n.B " escaped(name)
    if (at) print escaped(substr(line, at + RLENGTH))
}

# A line of a block that is shown as typed.
function typed(line) {
    if (!example) print ".PP\n.nf"
    example = 1
    print escaped(line)
}

BEGIN { kind = "text" }
NR == 1 {
    what = $0
    sub(/\.$/, "", what)
    print ".TH " toupper(escaped(page)) " 1 \"\" \"heliograph " version "\" \"User commands\""
    print ".ad l\n.nh"
    section("NAME")
    print escaped(page) " \\- " escaped(what)
    next
}
/^Usage: / { section("SYNOPSIS"); print ".B " escaped(substr($0, 8)); kind = "text"; next }
/^(Positionals|Options):$/ { section("OPTIONS"); kind = "entries"; next }
/^Subcommands:$/ { section("COMMANDS"); kind = "entries"; next }
/^Settings for --set/ { section("SETTINGS"); print "Default and range stand in parentheses."; kind = "settings"; next }
/^Examples?:/ {
    section("EXAMPLES")
    kind = "text"
    sub(/^Examples?: */, "")
    if ($0 != "") typed("  " $0)
    next
}
/^Exit code: / { section("EXIT STATUS"); print escaped(substr($0, 12)); next }
/^ *$/ { if (example) print ".fi"; example = 0; if (kind != "text") next; gap = 1; next }
/^[^ ]/ && kind != "text" { kind = "text"; section("DESCRIPTION") }
kind == "settings" && /^  [^ ]/ { sub(/^ +/, ""); print ".TP\n.B " escaped($0); next }
kind == "entries" && /^  [^ ]/ { entry($0); next }
kind != "text" { sub(/^ +/, ""); print escaped($0); next }
/^ / { typed($0); next }
{
    if (example) print ".fi\n.PP"
    else if (gap) print ".PP"
    example = gap = 0
    print escaped($0)
}
END {
    if (example) print ".fi"
    section("SEE ALSO")
    print ".BR heliograph (1), heliograph\\-serve (1), heliograph\\-render (1), heliograph\\-load (1)"
}
