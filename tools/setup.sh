# Steps that ./serve and ./check share: Debian packages, npm modules, the page, the server. Sourced by bash in the
# repository's root. Each step does nothing when there is nothing to do, prints one line when there is, keeps the details
# in a log under out/ and returns non-zero after having said what went wrong.

export LC_ALL=C.UTF-8
mkdir -p out build

say() { printf '%s\n' "$*"; }
complain() { printf '%s\n' "$*" >&2; }

# quietly LOG WHAT COMMAND...: runs COMMAND with its output in LOG; if it fails, shows the end of LOG.
quietly() {
    local log=$1 what=$2
    shift 2
    mkdir -p "$(dirname "$log")"
    if "$@" >"$log" 2>&1 </dev/null; then return 0; fi
    complain "$what failed; the end of $log:"
    tail -n 20 "$log" | cut -c 1-400 >&2
    return 1
}

# one_at_a_time COMMAND...: waits for another ./serve or ./check of this folder that is installing or building.
one_at_a_time() {
    (flock 9 && "$@" 9>&-) 9>build/.lock
}

# missing_packages GROUP...: the packages of these groups in packages.txt that this machine lacks.
missing_packages() {
    local group package command wanted=()
    while read -r group package command; do
        [[ " $* " == *" $group "* ]] || continue
        if [ -n "$command" ] && command -v "$command" >/dev/null; then continue; fi
        wanted+=("$package")
    done < <(grep -v '^#' packages.txt)
    [ ${#wanted[@]} -gt 0 ] || return 0
    dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${wanted[@]}" 2>/dev/null |
        awk -v wanted="${wanted[*]}" '$2 == "installed" { have[$1] = 1 }
            END { n = split(wanted, name, " "); for (i = 1; i <= n; i++) if (!(name[i] in have)) print name[i] }'
}

apt_install() {
    apt-get -q -o DPkg::Lock::Timeout=300 update || echo "apt-get update failed; trying with the old package lists"
    DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@"
}

# ensure_packages GROUP...: installs what is missing, as root or by sudo.
ensure_packages() {
    if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
        say "No apt-get here: going on in the hope that what packages.txt lists is installed."
        return 0
    fi
    local missing=() sudo=()
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0
    if [ "$(id -u)" != 0 ]; then
        if ! command -v sudo >/dev/null; then
            complain "These Debian packages are missing, and installing them takes root. Please run as root:"
            complain "  apt-get install -y --no-install-recommends ${missing[*]}"
            return 1
        fi
        sudo=(sudo)
        # Without a terminal nobody could type the password. With one, ask before the output goes to the log.
        if [ -t 0 ]; then sudo -v; else sudo=(sudo -n); fi
    fi
    say "Installing ${#missing[@]} Debian packages and what they need, a minute or two: ${missing[*]}"
    quietly out/setup/apt.log "Installing Debian packages" \
        "${sudo[@]}" bash -c "$(declare -f apt_install); apt_install \"\$@\"" apt_install "${missing[@]}"
}

# sum_of PATH...: a checksum over names and contents of all files below.
sum_of() {
    find "$@" -type f -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -d ' ' -f 1
}

# up_to_date STAMP SUM / mark STAMP SUM: whether a step was last done for inputs with this checksum.
up_to_date() { [ -f "$1" ] && [ "$(cat "$1")" = "$2" ]; }
mark() { printf '%s\n' "$2" >"$1"; }

# ensure_modules: client-web/node_modules as package-lock.json says.
ensure_modules() {
    local major sum
    if ! major=$(node -p 'process.versions.node.split(".")[0]' 2>/dev/null) || [ "$major" -lt 18 ]; then
        complain "The page is built with node 18 or newer and npm; found $(node --version 2>&1 | head -n 1)."
        return 1
    fi
    sum="$(sum_of client-web/package.json client-web/package-lock.json) node $major" || return 1
    if up_to_date client-web/node_modules/.heliograph-stamp "$sum"; then return 0; fi
    say "Installing npm modules"
    quietly out/setup/npm.log "npm ci" npm --prefix client-web ci --no-audit --no-fund --loglevel=error || return 1
    mark client-web/node_modules/.heliograph-stamp "$sum"
}

# ensure_page: client-web/dist from its sources.
ensure_page() {
    local sum
    ensure_modules || return 1
    sum=$(sum_of client-web/src client-web/static client-web/tools client-web/*.json) || return 1
    if [ -f client-web/dist/index.html ] && up_to_date build/page.stamp "$sum"; then return 0; fi
    say "Building the page"
    quietly out/setup/page.log "Building the page" npm --prefix client-web run build || return 1
    mark build/page.stamp "$sum"
}

# configure PRESET [CMAKE_OPTION...]: makes build/PRESET ready for ninja.
configure() {
    local folder=build/$1 launcher=()
    # A build folder that was made for another place (a moved or mounted checkout) cannot be used.
    if [ -f "$folder/CMakeCache.txt" ] &&
        ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$folder/CMakeCache.txt"; then rm -rf "$folder"; fi
    [ ! -f "$folder/build.ninja" ] || return 0
    if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
    say "Configuring $folder"
    quietly "out/setup/configure-$1.log" "Configuring" cmake --preset "$1" "${launcher[@]}" "${@:2}"
}

# build PRESET LOG [TARGET]: compiles; progress on a terminal, warnings always, everything in LOG.
build() {
    local preset=$1 log=$2
    configure "$preset" || return 1
    mkdir -p "$(dirname "$log")"
    say "Building build/$preset"
    NINJA_STATUS='[%f/%t] ' ninja -C "build/$preset" ${3:+"$3"} 2>&1 </dev/null | tee "$log" |
        if [ -t 1 ]; then
            awk -v width="${COLUMNS:-100}" '/^\[[0-9]+\/[0-9]+\]/ { printf "\r\033[K%s", substr($0, 1, width - 1); fflush(); next }
                /warning:/ && !seen[$0]++ { print "\r\033[K" $0 } END { printf "\r\033[K" }'
        else
            awk '/warning:/ && !seen[$0]++'
        fi
    [ "${PIPESTATUS[0]}" = 0 ] && return 0
    complain "The build failed; details in $log:"
    grep -E -m 10 'error:|undefined reference|^ninja: |FAILED:' "$log" | cut -c 1-400 >&2
    return 1
}
