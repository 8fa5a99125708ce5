#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Makes a clean Debian (or Ubuntu) of this machine's release in a folder, installs this
# project's packages there with apt and without recommendations, and uses them:
#   1. library, programs and Python alone: each program finds its libraries and runs;
#   2. development files, a compiler, CMake and pkg-config: example 01 as a project of its
#      own, and programs compiled with pkg-config;
#   3. removed again: no file stays.
# Step 2 takes 2.6 GB while it runs, as libpcl-dev needs that; all is deleted in the end.
#
# Usage, as root, after tools/package.sh: test/package/clean_root.sh [--without-dev] [FOLDER]
#   FOLDER         with the packages (build-package/packages)
#   --without-dev  without step 2
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)

arguments=("$@")
with_dev=yes
if [ "${1:-}" = --without-dev ]; then
  with_dev=no
  shift
fi
packages=$(cd "${1:-$source/build-package/packages}" && pwd)
work=$(dirname "$packages")/clean-root

# Deletes no file of another file system, should one be mounted in the folder after all.
delete_root() { rm -rf --one-file-system "$work"; }

# In namespaces of its own, where that is allowed, mounts and processes end with the script.
# Where not, as in many containers, nothing is mounted.
if [ -z "${PCL_EXT_CAN_MOUNT:-}" ]; then
  delete_root
  trap delete_root EXIT
  namespaces=(unshare --mount --pid --fork --kill-child --mount-proc)
  if "${namespaces[@]}" true 2> /dev/null; then
    PCL_EXT_CAN_MOUNT=yes "${namespaces[@]}" bash "$0" "${arguments[@]}"
  else
    PCL_EXT_CAN_MOUNT=no bash "$0" "${arguments[@]}"
  fi
  exit
fi

root=$work/root
log=$work/log

stop() {
  tail -n 40 "$log" >&2
  echo "clean_root: $*" >&2
  exit 1
}
step() { printf '%4d s  %s\n' "$SECONDS" "$*"; }

# Runs a command in the root, with none of this machine's settings but the proxy.
in_root() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
    LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive CACERT_UPDATES=disabled \
    ${http_proxy:+"http_proxy=$http_proxy"} ${https_proxy:+"https_proxy=$https_proxy"} "$@"
}
run() { in_root "$@" >> "$log" 2>&1 || stop "failed in the clean root: $*"; }
install_in_root() { run apt-get install -y -q --no-install-recommends "$@"; }

# Memory is faster than a disk, if there is enough of it.
use_memory() {
  if awk '/^MemAvailable/ { exit $2 < 8e6 }' /proc/meminfo; then
    mount -t tmpfs -o size=6g tmpfs "$work"
  fi
}

# What this machine has downloaded before is read from its cache; nothing is added there.
reuse_downloads() {
  local cache=/var/cache/apt/archives
  mkdir -p "$root$cache" "$work/downloaded" "$work/overlay"
  if [ "$PCL_EXT_CAN_MOUNT" = no ] || ! mount -t overlay overlay "$root$cache" \
    -o "lowerdir=$cache,upperdir=$work/downloaded,workdir=$work/overlay" 2> /dev/null; then
    find "$cache" -name '*.deb' -exec cp -l -t "$root$cache" {} + 2> /dev/null || true
  fi
}

# Packages come from where this machine has its own from.
make_root() {
  local sources=() file
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.{list,sources}; do
    if [ -s "$file" ]; then sources+=("$file"); fi
  done
  apt-config dump | grep '^Acquire' > "$work/apt.conf" || true
  reuse_downloads
  mmdebstrap --mode=root --variant=apt --skip=check/empty,cleanup/apt \
    --aptopt="$work/apt.conf" --dpkgopt=force-unsafe-io \
    --dpkgopt='path-exclude=/usr/share/doc/*' \
    "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$root" "${sources[@]}" \
    >> "$log" 2>&1 || stop "mmdebstrap failed"
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  if [ "$PCL_EXT_CAN_MOUNT" = yes ]; then
    mount -t proc proc "$root/proc"
  else
    # Without /proc Java, which libpcl-dev depends on, refuses to be installed.
    printf '#!/bin/sh\n' > "$root/usr/sbin/mountpoint"
    chmod +x "$root/usr/sbin/mountpoint"
  fi
  mkdir "$root/packages" "$root/source"
  cp "$packages"/*.deb "$root/packages"
}

# The path in the root of the package whose file's name matches a pattern.
package() { (cd "$root" && find packages -name "$1" -printf '/%p\n'); }

expect_libraries() {
  run sh -c "ldd $* > /tmp/libraries"
  if grep 'not found' "$root/tmp/libraries"; then stop "$* need more libraries"; fi
}

use_programs() {
  local program
  expect_libraries '/usr/bin/pcl_ext*'
  for program in "$root"/usr/bin/pcl_ext*; do
    run "${program#"$root"}" --help
  done
  if [ -e "$root/usr/bin/pcl_ext" ]; then
    run pcl_ext info /source/test/data/golden/balanced_counts.pcxi
  fi
}

build_example() {
  run cmake -S /source/examples -B /tmp/examples -DCMAKE_BUILD_TYPE=Release
  run cmake --build /tmp/examples --target 01_pcl_tutorial
  run /tmp/examples/01_pcl_tutorial
}

# $1: module of pkg-config, $2: program
compile_with_pkg_config() {
  run sh -c "g++ -std=c++17 -o /tmp/$2 /source/test/package/$2/$2.cpp \
    \$(pkg-config --cflags --libs $1)"
  run "/tmp/$2"
}

mkdir "$work"
[ "$PCL_EXT_CAN_MOUNT" = no ] || use_memory
step "a clean root"
make_root
cp -a "$source/examples" "$root/source"
mkdir -p "$root/source/test/data"
cp -a "$source/test/package" "$root/source/test"
cp -a "$source/test/data/golden" "$root/source/test/data"

# One after the other, so that none lives from what another one brings along.
step "library"
install_in_root "$(package 'libpcl-ext[0-9]*')"
expect_libraries '/usr/lib/*/libpcl_ext*.so.*'
if [ -n "$(package 'python3-pcl-ext_*')" ]; then
  step "Python"
  install_in_root "$(package 'python3-pcl-ext_*')"
  run python3 -c 'import numpy, pcl_ext
frame = pcl_ext.Encoder(resolution=0.1).encode(numpy.arange(30.0).reshape(10, 3))
assert len(pcl_ext.Decoder().decode(frame)) == 10'
fi
step "programs"
install_in_root "$(package 'pcl-ext-tools_*')"
use_programs

if [ "$with_dev" = yes ]; then
  step "the packages to build programs"
  install_in_root g++ make cmake pkg-config "$(package 'libpcl-ext-dev_*')"
  step "$(in_root dpkg-query -W | wc -l) packages; example 01"
  build_example
  step "programs by pkg-config"
  compile_with_pkg_config pcl_ext_codec codec_consumer
  compile_with_pkg_config pcl_ext_recording recording_consumer
  compile_with_pkg_config pcl_ext_view view_consumer
  compile_with_pkg_config pcl_ext_link link_consumer
  compile_with_pkg_config pcl_ext consumer
fi

step "removed again"
mapfile -t names < <(in_root dpkg-query -W -f '${Package}\n' '*pcl-ext*')
run apt-get purge -y -q "${names[@]}"
left=$(find "$root"/{usr,etc,var/lib} -name '*pcl[_-]ext*' ! -path '*/var/lib/apt/*')
[ -z "$left" ] || stop "files stay after the packages' removal: $left"
step "done"
