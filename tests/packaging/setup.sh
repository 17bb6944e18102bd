#!/bin/bash
# What ./serve and ./check say where they cannot install: another system, no root, no network. setup.sh; a line a failure,
# the last one is `N passed, N failed`. Systems are told by files and programs of a scratch folder; nothing is installed.
set -u
cd "$(dirname "$(readlink -f "$0")")/../.." || exit 1
passed=0 failed=0
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$scratch/tree/client-web" "$scratch/bin" "$scratch/none" "$scratch/all"
cp -r tools packages.txt "$scratch/tree"
cp client-web/package.json client-web/package-lock.json "$scratch/tree/client-web"
for tool in bash mkdir cat cut awk grep sed tail head dirname uname find sort xargs sha256sum tr; do
    ln -s "$(command -v $tool)" "$scratch/bin/$tool"
done
printf 'ID=fedora\nVERSION_ID=40\nPRETTY_NAME="Fedora Linux 40"\n' >"$scratch/fedora"
printf 'ID=ubuntu\nVERSION_ID="22.04"\nPRETTY_NAME="Ubuntu 22.04"\n' >"$scratch/ubuntu"
printf 'ID=debian\nVERSION_ID="12"\nPRETTY_NAME="Debian 12"\n' >"$scratch/debian"
while read -r _ _ header; do
    [[ ${header:-} == '<'* ]] || continue
    header=${header#<} header=${header%>}
    mkdir -p "$(dirname "$scratch/all/$header")"
    : >"$scratch/all/$header"
done <packages.txt

# stub NAME CODE TEXT...: a program that says that and ends so; unstub NAME...
stub() { printf '#!/bin/bash\ncat <<"TEXT"\n%s\nTEXT\nexit %s\n' "${*:3}" "$2" >"$scratch/bin/$1" && chmod +x "$scratch/bin/$1"; }
unstub() { (cd "$scratch/bin" && rm -f "$@"); }

# expect WHAT CODE SYSTEM INCLUDES COMMAND: runs it with the stubs alone; then `says` and `says_not` look at its words.
expect() {
    local status
    what=$1
    (cd "$scratch/tree" && env -i PATH="$scratch/bin" HELIOGRAPH_OS_RELEASE="$scratch/$3" HELIOGRAPH_INCLUDES="$scratch/$4" \
        bash -c ". tools/setup.sh; $5") >"$scratch/said" 2>&1
    status=$?
    count "exit code $status, not $2" [ $status = "$2" ]
}
count() {
    if "${@:2}"; then passed=$((passed + 1)); else failed=$((failed + 1)); echo "FAILED $what: $1"; sed 's/^/    /' "$scratch/said"; fi
}
says() { count "does not say '$1'" grep -q -F -- "$1" "$scratch/said"; }
says_not() { count "says '$1'" bash -c '! grep -q -F -- "$1" "$2"' - "$1" "$scratch/said"; }

expect "another system" 1 fedora none "ensure_packages run"
says "This is Fedora Linux 40."
says "libembree-dev (embree3/rtcore.h)"
says "g++ (g++)"
says "docker build -f docker/Dockerfile -t heliograph . &&"
says "docker run --rm -p 127.0.0.1:8080:8080 heliograph serve --insecure"
says_not "clang"
expect "another system, for ./check" 1 fedora none "ensure_packages run check"
says "clang-format (clang-format)"
says 'docker run --rm -it -v "$PWD":/src -w /src debian:bookworm ./check'

for tool in g++ cmake ninja pkg-config glslangValidator node npm; do stub $tool 0; done
expect "another system with the tools" 1 fedora none "ensure_packages run"
says "libwebsockets-dev (libwebsockets.h)"
says_not "cmake"
expect "another system with everything" 0 fedora all "ensure_packages run"
says "This is Fedora Linux 40, not Debian 12: going on"
stub apt-get 0 "apt-get was called"
stub dpkg-query 1
expect "another system with apt" 1 ubuntu none "ensure_packages run"
says "This is Ubuntu 22.04."
says_not "apt-get was called"

stub id 0 1000
expect "no root and no sudo" 1 debian none "ensure_packages run"
says "apt-get install -y --no-install-recommends libembree-dev"
says "docker build"
says_not "libcli11-dev g++"
stub sudo 1 "sudo: a password is required"
expect "no root, and sudo that is refused" 1 debian none "ensure_packages run"
says "sudo: a password is required"
says "an administrator runs:"
says "docker build"
unstub sudo
stub id 0 0
stub apt-get 100 "Err:1 http://deb.debian.org Temporary failure resolving 'deb.debian.org'"
expect "no network" 1 debian none "ensure_packages run"
says "The package mirror was not reached: Err:1 http://deb.debian.org Temporary failure resolving"
says "  libembree-dev libtbb-dev"
stub apt-get 100 "E: Sub-process /usr/bin/dpkg returned an error code (1)"
expect "a broken package" 1 debian none "ensure_packages run"
says_not "was not reached"
stub node 0 18
stub npm 1 "npm error network request to https://registry.npmjs.org/ failed, reason: getaddrinfo EAI_AGAIN"
expect "no network for the page" 1 debian none "ensure_modules"
says "The npm registry was not reached: npm error network request"
stub node 0 16
expect "an old node" 1 debian none "ensure_modules"
says "node 18 or newer"
echo "$passed passed, $failed failed"
[ $failed = 0 ] && [ $passed -gt 0 ]
