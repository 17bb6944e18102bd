# Options of one command for bash completion, from what `COMMAND --help` prints, as a branch of a case.
# awk -v command='bench frames' -f completion.awk

/^Subcommands:$/ { part = "commands"; next }
/^Options:$/ { part = "options"; next }
/^Settings for --set/ { part = "settings"; next }
/^(Positionals|Examples?):/ { part = "" }
/^[^ ]/ { part = "" }
part == "commands" && /^  [a-z]/ { commands = commands " " $1 }
part == "options" && /^  -/ {
    count = split($1, names, ",")
    for (i = 1; i <= count; i++) {
        name = names[i]
        sub(/=.*/, "", name)
        if (name !~ /^--/) continue
        options = options " " name
        if ($2 ~ /^(FILE|DIR|TEXT)/ && name ~ /file|out|csv|html|junit|cert|key|client|config|environment/) files = files " " name
        else if ($2 ~ /^[A-Za-z]/ && $2 == toupper($2) && $0 ~ /^  [^ ]+ [A-Z]/) values = values " " name
    }
}
part == "settings" && /^  [A-Za-z]/ {
    line = $0
    range = line
    sub(/^[^;]*; /, "", range)
    sub(/\)$/, "", range)
    if (range == "true or false") words = "true,false"
    else if (range ~ / to /) words = ""
    else { words = range; gsub(/, */, ",", words) }
    count = split(words, choices, ",")
    settings = settings " " $1 "="
    for (i = 1; i <= count; i++) settings = settings " " $1 "=" choices[i]
}
END {
    printf "    '%s')\n        commands='%s'\n        options='%s'\n        files='%s '\n        values='%s '\n", command, commands, options, files, values
    printf "        settings='%s'\n        ;;\n", settings
}
