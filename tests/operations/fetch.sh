#!/bin/bash
# Puts Debian's prometheus and nginx under out/operations without installing them, for the scripts here. Needs apt-get, dpkg.
set -e
cd "$(dirname "$(readlink -f "$0")")/../.."
mkdir -p out/operations/packages
cd out/operations/packages
apt-get -q download prometheus nginx
for package in *.deb; do dpkg -x "$package" ..; done
echo "in $(dirname "$PWD")"
