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

# system: name and version of this system, as /etc/os-release tells; is_debian_12.
OS_RELEASE=${HELIOGRAPH_OS_RELEASE:-/etc/os-release}
system() { (. "$OS_RELEASE" 2>/dev/null && echo "${PRETTY_NAME:-an unknown system}") || uname -sr; }
is_debian_12() { (. "$OS_RELEASE" 2>/dev/null && [ "${ID:-} ${VERSION_ID:-}" = "debian 12" ]); }

# wanted_packages GROUP...: the packages of these groups in packages.txt whose command is not here, each with what tells.
wanted_packages() {
    local group package tells
    while read -r group package tells; do
        [[ " $* " == *" $group "* ]] || continue
        if [[ -n $tells && $tells != '<'* ]] && command -v "$tells" >/dev/null; then continue; fi
        echo "$package $tells"
    done < <(grep -v '^#' packages.txt)
}

# missing_packages GROUP...: those of them that dpkg does not know as installed.
missing_packages() {
    local wanted=()
    mapfile -t wanted < <(wanted_packages "$@" | cut -d ' ' -f 1)
    [ ${#wanted[@]} -gt 0 ] || return 0
    dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${wanted[@]}" 2>/dev/null |
        awk -v wanted="${wanted[*]}" '$2 == "installed" { have[$1] = 1 }
            END { n = split(wanted, name, " "); for (i = 1; i <= n; i++) if (!(name[i] in have)) print name[i] }'
}

# missing_elsewhere GROUP...: those whose command or header is not here. What has neither is not looked for.
missing_elsewhere() {
    local package tells folder found
    while read -r package tells; do
        [ -n "$tells" ] || continue
        found=
        if [[ $tells == '<'* ]]; then
            tells=${tells#<} tells=${tells%>}
            for folder in ${HELIOGRAPH_INCLUDES:-/usr/include /usr/local/include /usr/include/*-linux-gnu}; do
                [ ! -e "$folder/$tells" ] || found=yes
            done
        fi
        [ -n "$found" ] || echo "$package ($tells)"
    done < <(wanted_packages "$@")
}

# say_container GROUP...: what does the same without installing anything here.
say_container() {
    complain "In a container instead, with Docker or Podman:"
    if [[ " $* " == *" check "* ]]; then
        complain "  docker run --rm -it -v \"\$PWD\":/src -w /src debian:bookworm ./check"
    else
        complain "  docker build -f docker/Dockerfile -t heliograph . &&"
        complain "  docker run --rm -p 127.0.0.1:8080:8080 heliograph serve --insecure"
    fi
}

# unreachable LOG: the line of a log that says that the network was not reached.
unreachable() {
    grep -m 1 -i -E 'could not resolve|temporary failure (in name )?resol|could not connect|connection (refused|timed out)|network is unreachable|ENOTFOUND|EAI_AGAIN|ECONNREFUSED|ETIMEDOUT|ENETUNREACH' "$1" | cut -c 1-200
}

apt_install() {
    apt-get -q -o DPkg::Lock::Timeout=300 update || echo "apt-get update failed; trying with the old package lists"
    DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@"
}

# ensure_elsewhere GROUP...: on another system than Debian 12 nothing is installed; what lacks is named.
ensure_elsewhere() {
    local missing=()
    mapfile -t missing < <(missing_elsewhere "$@")
    if [ ${#missing[@]} -eq 0 ]; then
        say "This is $(system), not Debian 12: going on, as all that is looked for is here."
        return 0
    fi
    complain "This is $(system). Heliograph installs what it needs on Debian 12 only; here these are missing"
    complain "(names of Debian's packages, and the command or header by which they are found):"
    printf '  %s\n' "${missing[@]}" >&2
    say_container "$@"
    return 1
}

# ensure_packages GROUP...: installs what is missing, as root or by sudo.
ensure_packages() {
    if ! is_debian_12 || ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
        ensure_elsewhere "$@"
        return
    fi
    local missing=() sudo=() line
    mapfile -t missing < <(missing_packages "$@")
    [ ${#missing[@]} -gt 0 ] || return 0
    if [ "$(id -u)" != 0 ]; then
        if ! command -v sudo >/dev/null; then
            complain "These Debian packages are missing, and installing them takes root. Please run as root:"
            complain "  apt-get install -y --no-install-recommends ${missing[*]}"
            say_container "$@"
            return 1
        fi
        sudo=(sudo)
        # Without a terminal nobody could type the password. With one, ask before the output goes to the log.
        if [ -t 0 ]; then sudo -v; else sudo=(sudo -n); fi
    fi
    say "Installing ${#missing[@]} Debian packages and what they need, a minute or two: ${missing[*]}"
    quietly out/setup/apt.log "Installing Debian packages" \
        "${sudo[@]}" bash -c "$(declare -f apt_install); apt_install \"\$@\"" apt_install "${missing[@]}" && return 0
    if line=$(unreachable out/setup/apt.log) && [ -n "$line" ]; then
        complain "The package mirror was not reached: $line"
        complain "With network, or where a mirror can be reached, the same command goes on. These packages are missing:"
        complain "  ${missing[*]}"
    elif [ ${#sudo[@]} -gt 0 ]; then
        complain "Where sudo is not allowed, an administrator runs:"
        complain "  apt-get install -y --no-install-recommends ${missing[*]}"
        say_container "$@"
    fi
    return 1
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
    if ! quietly out/setup/npm.log "npm ci" npm --prefix client-web ci --no-audit --no-fund --loglevel=error; then
        local line
        line=$(unreachable out/setup/npm.log)
        if [ -n "$line" ]; then
            complain "The npm registry was not reached: $line"
            complain "The page needs it once; client-web/node_modules of another machine with the same node does, too."
        fi
        return 1
    fi
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
