#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Prints the path of the program nats-server. Where there is none it is unpacked into
# build-nats-server before, as to install its package would start a service.
# Usage: bash tools/fetch_nats_server.sh
# To try a site: $(bash tools/fetch_nats_server.sh) -c tools/site/trial.conf
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
folder=$root/build-nats-server
PATH=$PATH:/usr/sbin:$folder/usr/sbin
command -v nats-server && exit 0
package=$(awk '/^\[/ { reading = $1 == "[unpacked]"; next } reading && NF { print $1 }' \
  "$root/tools/packages.txt")
mkdir -p "$folder"
cd "$folder"
# On a fresh machine apt has no lists of packages yet.
download() { apt-get -qq download "$package" 2>&1; }
update() { if [ "$(id -u)" -eq 0 ]; then apt-get -qq update; else sudo apt-get -qq update; fi; }
if ! log=$(download || { update && download; } 2>&1); then
  echo "apt-get cannot fetch the package $package, which tests of streams between machines need:" \
    "$(tail -n 1 <<< "$log")" >&2
  exit 1
fi
dpkg-deb --extract "$package"_*.deb .
rm "$package"_*.deb
command -v nats-server
