# Bare Debian 12 roots for the tests of packages and images. Sourced by bash; needs root, debootstrap and a mirror.
# HELIOGRAPH_MIRROR names the mirror, else what this machine's own apt uses.

# mirror: where packages come from.
mirror() {
    [ -z "${HELIOGRAPH_MIRROR:-}" ] || { echo "$HELIOGRAPH_MIRROR"; return; }
    cat /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null |
        awk '/^URIs:/ { print $2 } $1 == "deb" { for (i = 2; i <= NF; i++) if ($i ~ /^https?:/) print $i }' |
        grep -m 1 -E '/debian/?$' || echo http://deb.debian.org/debian
}

# base_archive FILE: a tar of a bare root, made if it is not there.
base_archive() {
    local root
    [ ! -f "$1" ] || return 0
    root=$(mktemp -d)
    chmod 755 "$root"
    debootstrap --variant=minbase bookworm "$root" "$(mirror)" >"$1.log" 2>&1 || { tail -n 5 "$1.log"; return 1; }
    # Security updates, and nothing that another apt run on this machine could take away.
    cat >"$root/etc/apt/sources.list" <<SOURCES
deb $(mirror) bookworm main
deb $(mirror) bookworm-updates main
deb $(mirror | sed 's,debian/*$,debian-security,') bookworm-security main
SOURCES
    rm -rf "$root"/var/cache/apt/archives/*.deb "$root"/var/lib/apt/lists/*
    tar -C "$root" --exclude='./proc/*' --exclude='./sys/*' --exclude='./dev/*' -cf "$1.part" . && mv "$1.part" "$1"
    rm -rf "$root"
}

# unpack_base ARCHIVE FOLDER: a root to enter; /proc and /dev are the machine's.
unpack_base() {
    mkdir -p "$2" && tar -C "$2" -xf "$1" && mkdir -p "$2/proc" "$2/dev" && mount -t proc proc "$2/proc" &&
        mount --bind /dev "$2/dev" && cp -L /etc/resolv.conf "$2/etc/resolv.conf"
}

# enter_root FOLDER COMMAND...: in the root, with nothing of the caller's environment.
enter_root() {
    local root=$1
    shift
    chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}

# expect WHAT COMMAND...: must succeed; else the end of what it said is shown. Counts in $passed and $failed; $work is a folder.
passed=0 failed=0
expect() {
    local what=$1
    shift
    if "$@" >"$work/said" 2>&1; then
        passed=$((passed + 1))
        echo "ok    $what"
    else
        failed=$((failed + 1))
        echo "FAIL  $what: $(tail -n 8 "$work/said" | cut -c 1-300)"
    fi
}
