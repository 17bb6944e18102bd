#!/bin/bash
# The container images, built and run without a container engine: buildah with chroot isolation on a bare root. images.sh
# [--prebuilt] [BUILDAH_OPTION...]; a line a check, the last one is `N passed, N failed`. Without --prebuilt everything is
# compiled in the container, which takes long; with it the packages of build/release/packages are taken. Needs root, buildah,
# debootstrap, python3 and a mirror. HELIOGRAPH_CA names a bundle of certificates where the npm registry needs another one.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1
. tests/packaging/root.sh
container='' mounted=''
mkdir -p out/packaging
work=$(mktemp -d -p out/packaging)
work=$(readlink -f "$work")
buildah=(buildah --root "$work/root" --runroot "$work/run" --storage-driver vfs)
options=(--pull-never --isolation chroot --network host --format docker "--build-arg=BASE=localhost/base:bookworm")
packages=build  # said, because buildah 1.28 does not see through the default when it skips stages
if [ "${1:-}" = --prebuilt ]; then packages=prebuilt; shift; fi
options+=("--build-arg=PACKAGES=$packages")
[ -z "${HELIOGRAPH_CA:-}" ] || options+=(--volume "$HELIOGRAPH_CA:/usr/local/share/ca-certificates/more.crt:ro")
options+=("$@")
server=
clean_up() {
    [ -z "$server" ] || kill "$server" 2>/dev/null
    wait 2>/dev/null
    "${buildah[@]}" rm -a >/dev/null 2>&1
    rm -rf --one-file-system "$work"
}
trap clean_up EXIT

base_image() {
    local container
    base_archive out/packaging/base.tar && container=$("${buildah[@]}" from scratch) &&
        "${buildah[@]}" add -q "$container" out/packaging/base.tar / &&
        "${buildah[@]}" config --cmd /bin/bash --env PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "$container" &&
        "${buildah[@]}" commit -q --rm "$container" localhost/base:bookworm
}
image() { "${buildah[@]}" bud "${options[@]}" "${@:3}" -f "docker/$2" -t "localhost/$1" .; }
container_of() { container=$("${buildah[@]}" from --pull-never "localhost/$1") && mounted=$("${buildah[@]}" mount "$container"); }
configured() { "${buildah[@]}" inspect --type image --format "{{.Docker.Config.$2}}" "localhost/$1"; }

# running [NAME=VALUE...] -- COMMAND...: as a container of the image would: its user and environment, no capability, a root
# that is read only and a /tmp of its own.
running() {
    local environment=()
    while [ "$1" != -- ]; do environment+=("$1"); shift; done
    shift
    local user
    user=$(configured heliograph User)
    mkdir -p "$work/view"
    # shellcheck disable=SC2016
    exec unshare -m bash -c 'view=$1 root=$2 ids=$3; shift 3
        mount --bind "$root" "$view" && mount -o remount,bind,ro "$view" && mount -t tmpfs none "$view/tmp" &&
            mount -t proc proc "$view/proc" && mount --bind /dev "$view/dev" &&
            exec chroot "$view" setpriv --reuid "${ids%:*}" --regid "${ids#*:}" --clear-groups --bounding-set -all --inh-caps -all \
                --no-new-privs env -i "$@"' \
        running "$work/view" "$mounted" "$user" $(configured heliograph Env | tr -d '[]') "${environment[@]}" "$@"
}
port=$(python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
serve() {
    running "HELIOGRAPH_LISTEN=0.0.0.0:$port" HELIOGRAPH_INSECURE=true -- heliograph serve cornell >"$work/server" 2>&1 &
    server=$!
    local turn
    for turn in $(seq 120); do
        grep -q '^heliograph: serving' "$work/server" && return 0
        kill -0 $server || break
        sleep 0.5
    done
    cat "$work/server"
    return 1
}
healthy() { (running "HELIOGRAPH_LISTEN=0.0.0.0:$port" -- heliograph-healthy); }
ill() { ! healthy; }
load() { (running -- heliograph-load "ws://127.0.0.1:$port/ws" --viewers 2 --seconds 2 --require errors==0); }
refuses() { (running -- heliograph serve) 2>&1 | grep -e --token-file; }

# weigh NAME: what a registry would hold of the image, and what takes the room.
weigh() {
    local bytes
    bytes=$(tar -C "$mounted" --one-file-system -c . | gzip -6 | wc -c)
    echo "      $1: $((bytes / 1000000)) MB compressed, $(du -s --block-size=1000000 "$mounted" | cut -f 1) MB on disk; the largest:"
    (cd "$mounted" && find . -xdev -type f -size +2M -printf '%s %p\n' | sort -rn | head -n 8 | awk '{ printf "        %6.1f MB %s\n", $1 / 1e6, $2 }')
    [ "$bytes" -gt 1000000 ] && [ "$bytes" -le "$2" ]
}

expect "a base image" base_image
expect "docker/Dockerfile builds" image heliograph Dockerfile
expect "docker/Dockerfile.gpu builds" image heliograph:gpu Dockerfile.gpu --build-arg=IMAGE=localhost/heliograph
expect "a container of it" container_of heliograph
[ $failed = 0 ] || { echo "$passed passed, $failed failed"; exit 1; }
weigh "docker/Dockerfile" 150000000
expect "  which is at most 150 MB" test $? = 0
expect "no compiler in it" bash -c "! ls '$mounted'/usr/bin | grep -E '^(gcc|g\+\+|cc|clang|cmake|ninja|node|make)'"
expect "its user is nobody who owns anything" bash -c "[[ '$(configured heliograph User)' == 65532:65532 ]] && [ -z \"\$(find '$mounted' -xdev -user 65532)\" ]"
expect "it has a health check" bash -c "[[ '$(configured heliograph Healthcheck)' == *heliograph-healthy* ]]"
expect "nothing of a package manager's lists is left" bash -c "[ -z \"\$(find '$mounted'/var/lib/apt/lists '$mounted'/packages -type f 2>/dev/null)\" ]"
expect "for all without a token it refuses, and says how" refuses
expect "on a read-only root, as that user, it serves" serve
expect "/healthz, the page and one frame over WebSocket" python3 tests/packaging/one_frame.py "http://127.0.0.1:$port" --page
expect "its health check says well" healthy
expect "its load test passes" load
kill "$server" 2>/dev/null
wait "$server"
expect "SIGTERM ends it with 0 ($?)" test $? = 0
server=
expect "its health check says ill" ill
expect "the GPU image differs by packages and environment" container_of heliograph:gpu
weigh "docker/Dockerfile.gpu" 200000000
expect "  which is at most 200 MB" test $? = 0
expect "the GPU image asks for NVIDIA's Vulkan" bash -c "[[ '$(configured heliograph:gpu Env)' == *NVIDIA_DRIVER_CAPABILITIES=graphics* ]]"
if command -v docker-compose >/dev/null; then
    for profile in none load-test pool; do
        expect "docker/compose.yaml is valid, profile $profile" docker-compose -f docker/compose.yaml --profile $profile config
    done
else
    echo "      docker/compose.yaml was not looked at: no docker-compose here"
fi
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
