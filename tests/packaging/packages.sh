#!/bin/bash
# Debian packages in a bare root: installed, run as the unit's user would run it, purged. packages.sh [BUILD]; a line a
# check, the last one is `N passed, N failed`. Needs root, debootstrap, python3 and a mirror (tests/packaging/root.sh).
# out/packaging/ keeps the bare root as a tar; HELIOGRAPH_KEEP_ROOT=1 keeps the installed one for a look.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1
. tests/packaging/root.sh
build=${1:-build/release}
mkdir -p out/packaging
work=$(mktemp -d)
root=$work/root
server=
clean_up() {
    [ -z "$server" ] || kill "$server" 2>/dev/null
    wait 2>/dev/null
    umount -l "$work"/read-only/* "$work/read-only" "$root/proc" "$root/dev" 2>/dev/null
    if [ -z "${HELIOGRAPH_KEEP_ROOT:-}" ]; then rm -rf --one-file-system "$work"; else echo "kept: $root"; fi
}
trap clean_up EXIT

# files: what there is in the root, but for what dpkg, apt and the linker keep for themselves.
files() {
    (cd "$root" && find . -xdev -path ./proc -prune -o -path ./dev -prune -o -print) |
        grep -v -E '^\./(var/lib/(dpkg|apt)|var/cache/(apt|debconf|ldconfig)|var/log|tmp|run|packages)(/|$)|^\./etc/ld\.so\.cache$' | sort
}

deb() { basename -a "$build/packages/$1"_*.deb | sed 's,^,/packages/,'; }
apt() { enter_root "$root" apt-get -q -y "$@"; }

prepare() {
    chmod 755 "$work" && base_archive out/packaging/base.tar && unpack_base out/packaging/base.tar "$root" &&
        mkdir -p "$root/packages" && cp "$build"/packages/*.deb "$root/packages/" && apt update
}

# The unit's sandbox as far as it can be had without systemd: its command and environment, a user of no account, no
# capability, no new ones, a file system that is read only but for the cache and a /tmp of its own.
as_the_unit() {
    local command environment
    command=$(sed -n 's/^ExecStart=//p' "$root/lib/systemd/system/heliograph.service")
    mapfile -t environment < <(sed -n 's/^Environment=//p' "$root/lib/systemd/system/heliograph.service" | sed 's,%C,/var/cache,g')
    mkdir -p "$work/read-only"
    install -d -o 65000 -g 65000 "$root/var/cache/private/heliograph"
    ln -sfn private/heliograph "$root/var/cache/heliograph"
    exec unshare -m bash -c '
        root=$1 view=$2; shift 2
        mount --bind "$root" "$view" && mount -o remount,bind,ro "$view" && mount -t tmpfs none "$view/tmp" &&
            mount --bind "$root/var/cache" "$view/var/cache" && mount -t proc proc "$view/proc" &&
            mount --bind /dev "$view/dev" && mount -t tmpfs none "$view/run" && mount --bind "$NOTIFY_FOLDER" "$view/run" &&
            exec chroot "$view" setpriv --reuid 65000 --regid 65000 --clear-groups --bounding-set -all --inh-caps -all \
                --no-new-privs env -i NOTIFY_SOCKET=/run/notify WATCHDOG_USEC=2000000 "$@"' \
        unit "$root" "$work/read-only" "${environment[@]}" HELIOGRAPH_LISTEN=127.0.0.1:0 $command
}

start_as_the_unit() {
    mkdir -p "$work/notify"
    chmod 777 "$work/notify"
    python3 tests/packaging/notified.py "$work/notify/notify" >"$work/notified" &
    local listener=$!
    NOTIFY_FOLDER=$work/notify as_the_unit >"$work/server.out" 2>"$work/server.err" &
    server=$!
    local turn
    for turn in $(seq 600); do
        grep -q serving "$work/server.out" && break
        kill -0 $server 2>/dev/null || break
        sleep 0.1
    done
    sleep 3  # two turns of the watchdog
    kill $listener
    url=$(sed -n 's/.* on \(http:.*\)/\1/p' "$work/server.out")
    [ -n "$url" ] || { tail -n 3 "$work/server.err"; return 1; }
}

completes() {  # LINE EXPECTED: the completion as installed, asked in the root
    enter_root "$root" bash -c '. /usr/share/bash-completion/completions/heliograph; compopt() { :; }
        read -ra COMP_WORDS <<<"$1"; [[ $1 != *" " ]] || COMP_WORDS+=(""); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
        _heliograph; printf "%s " "${COMPREPLY[@]}"' complete "$1" | grep -F -- "$2"
}

nothing_left() {
    rmdir "$root/var/cache/private"  # systemd's own
    files >"$work/after"
    diff "$work/before" "$work/after"
}

expect "a bare root" prepare
[ $failed = 0 ] || { echo "$passed passed, $failed failed"; exit 1; }
files >"$work/before"
expect "heliograph installs, with Debian's packages alone" apt install --no-install-recommends "$(deb heliograph)"
packages=$(enter_root "$root" dpkg-query -W -f '${Package} ${Installed-Size}\n' | awk '{ n++; kib += $2 } END { print n " packages, " int(kib / 1024) " MiB" }')
echo "      the root holds $packages"
expect "no library of OpenImageIO came" bash -c "! ls '$root'/usr/lib/x86_64-linux-gnu | grep -i -E 'openimageio|openexr'"
expect "--version as the user of no account" enter_root "$root" setpriv --reuid 65000 --regid 65000 --clear-groups heliograph --version
expect "the service is enabled" test -L "$root/etc/systemd/system/multi-user.target.wants/heliograph.service"
expect "as the unit runs it, it serves" start_as_the_unit
expect "READY=1 was said" grep -q READY=1 "$work/notified"
expect "WATCHDOG=1 was said" grep -q WATCHDOG=1 "$work/notified"
expect "/healthz, the page and one frame over WebSocket" python3 tests/packaging/one_frame.py "${url:-http://127.0.0.1:1}" --page
kill "$server" 2>/dev/null
wait "$server"
expect "SIGTERM ends it with 0 ($?)" test $? = 0
server=
expect "without heliograph-images .exr is refused" bash -c "chroot '$root' heliograph render cornell --size 16x16 --samples 1 --out /tmp/a.exr 2>&1 | grep heliograph-images.so"
expect "a manual page for each command" bash -c "[ \$(ls '$root'/usr/share/man/man1/heliograph*.gz | wc -l) -ge 11 ]"
expect "completion of commands" completes 'heliograph in' inspect
expect "completion of options" completes 'heliograph bench frames --fra' --frames
expect "completion of settings" completes 'heliograph render cornell --set toneC' toneCurve=filmic
expect "heliograph-load installs" apt install --no-install-recommends "$(deb heliograph-load)"
expect "heliograph-load runs" enter_root "$root" heliograph-load --help
expect "heliograph-images installs" apt install --no-install-recommends "$(deb heliograph-images)"
expect "with heliograph-images .exr is written" enter_root "$root" heliograph render cornell --size 16x16 --samples 1 --out /tmp/a.exr
expect "removing keeps the configuration" bash -c "chroot '$root' apt-get -q -y remove heliograph-images heliograph && [ -f '$root/etc/heliograph/heliograph.toml' ]"
expect "purging works" apt purge --autoremove heliograph heliograph-images heliograph-load
expect "nothing is left" nothing_left
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
