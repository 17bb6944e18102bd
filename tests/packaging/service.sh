#!/bin/bash
# The service as systemd runs it: a bare root with systemd and the package is booted in namespaces of its own. service.sh
# [BUILD]; a line a check, the last one is `N passed, N failed`. Needs what packages.sh needs, and unshare.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1
. tests/packaging/root.sh
build=${1:-build/release}
mkdir -p out/packaging
work=$(mktemp -d)
chmod 755 "$work"
root=$work/root
init=
clean_up() {
    [ -z "$init" ] || kill -KILL "$init" 2>/dev/null  # and with process 1 all others of its namespace
    wait 2>/dev/null
    umount -l "$root/proc" "$root/dev" 2>/dev/null
    rm -rf --one-file-system "$work"
}
trap clean_up EXIT

# until_true SECONDS COMMAND...: tried twice a second.
until_true() {
    local turn
    for turn in $(seq $((2 * $1))); do "${@:2}" && return 0; sleep 0.5; done
    return 1
}

prepare() {
    base_archive out/packaging/base.tar && unpack_base out/packaging/base.tar "$root" &&
        cp "$build"/packages/*.deb "$root/" && enter_root "$root" apt-get -q update &&
        enter_root "$root" apt-get -q -y install --no-install-recommends systemd dbus &&
        enter_root "$root" apt-get -q -y install --no-install-recommends "/$(basename -a "$build"/packages/heliograph_*.deb)" &&
        umount "$root/proc" "$root/dev"
}

port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
configure() {
    sed -i -e "s/^#listen = .*/listen = \"127.0.0.1:$port\"/" -e 's/^#scene = .*/scene = "cornell"/' "$root/etc/heliograph/heliograph.toml"
    sed -i "s/^ListenStream=.*/ListenStream=127.0.0.1:$port/" "$root/lib/systemd/system/heliograph.socket"
    # The unit's 60 s are long for a test.
    mkdir -p "$root/etc/systemd/system/heliograph.service.d"
    printf '[Service]\nWatchdogSec=4\n' >"$root/etc/systemd/system/heliograph.service.d/test.conf"
}

boot() {
    local shell
    : >"$work/console"
    unshare --mount --pid --fork --uts --ipc --cgroup --kill-child tests/packaging/boot.sh "$root" "$work/console" &
    shell=$!
    until_true 10 bash -c "pgrep -P $shell >/dev/null"
    init=$(pgrep -P $shell)
    until_true 60 inside systemctl --quiet is-system-running --wait || inside systemctl list-units --failed
    until_true 120 is active
}
inside() { nsenter -t "$init" -a -r -- "$@"; }
shown() { inside systemctl show -P "$1" heliograph.service; }
is() { [ "$(shown ActiveState)" = "$1" ]; }
frame() { python3 tests/packaging/one_frame.py "http://127.0.0.1:$port" "$@"; }
status_of() { inside grep -E "^$1:" "/proc/$(shown MainPID)/status" | awk '{ print $2 }'; }
refused() { ! inside "$@"; }
restarted() { [ "$(shown NRestarts)" -gt "$1" ] && is active; }

expect "a bare root with systemd and the package" prepare
configure
expect "systemd boots and the service becomes active" boot
echo "      $(shown StatusText), $(inside systemd-analyze --no-pager security heliograph.service | tail -n 1)"
expect "the status says what is served" bash -c "[[ '$(shown StatusText)' == 'serving cornell on http://127.0.0.1:$port' ]]"
expect "page and a frame under the whole sandbox" frame --page
expect "a user of its own ($(status_of Uid))" test "$(status_of Uid)" -ge 61184
expect "no capabilities ($(status_of CapEff), $(status_of CapBnd))" test "$(status_of CapEff)$(status_of CapBnd)" = 00000000000000000000000000000000
expect "system calls are filtered" test "$(status_of Seccomp)$(status_of NoNewPrivs)" = 21
expect "the file system is read only" refused touch "/proc/$(shown MainPID)/root/etc/written"
expect "but for the cache" inside touch "/proc/$(shown MainPID)/root/var/cache/heliograph/written"
expect "reload" inside systemctl reload heliograph.service
expect "the service is still there, and serves" frame
expect "a service that stands still is started anew" inside sh -c "kill -STOP $(shown MainPID)"
expect "  by the watchdog" until_true 60 restarted 0
expect "a service that was killed is started anew" inside systemctl kill --signal=KILL heliograph.service
expect "  within seconds" until_true 60 restarted 1
expect "and serves" frame
expect "systemctl stop ends it" inside systemctl stop heliograph.service
expect "  well: $(shown Result)" test "$(shown Result)" = success
sed -i 's/^listen = /#&/' "$root/etc/heliograph/heliograph.toml"  # the socket says where
expect "the socket alone" inside systemctl start heliograph.socket
expect "  starts no service ($(shown ActiveState))" is inactive
expect "  the first viewer does, and gets a frame" frame
expect "  from the service" is active
expect "purging in the running system" inside apt-get -q -y purge heliograph
expect "  leaves no service" refused systemctl cat heliograph.service
expect "  and nobody at the port" bash -c "! curl -s -m 5 http://127.0.0.1:$port/healthz"
expect "  and no file" bash -c "[ -z \"\$(find '$root' -xdev -path '*heliograph*' -not -path '*/var/lib/dpkg/*' -not -path '$root/heliograph*' -not -path '*heliograph.service.d*')\" ]"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
