#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs the Debian packages of tools/packages.txt that are missing.
# Usage: bash tools/install_packages.sh [group ...]     (default: build)
if [ -z "${BASH_VERSION:-}" ]; then
  echo "install_packages: run it with bash: bash $0 $*" >&2
  exit 2
fi
set -euo pipefail
list=$(dirname "$0")/packages.txt

stop() {
  echo "install_packages: $*" >&2
  exit 2
}

missing=()
for group in "${@:-build}"; do
  packages=$(awk -v group="[$group]" '/^\[/ { reading = $1 == group; next }
                                      reading && !/^#/ && NF { print $1 }' "$list")
  [ -n "$packages" ] || stop "no group '$group' in $list"
  for package in $packages; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    # They may come from elsewhere. Other packages of nodejs than Debian's have npm in them,
    # and conflict with Debian's.
    case $package in
      npm) command -v npm > /dev/null && status=installed ;;
      nodejs) command -v node > /dev/null && status=installed ;;
    esac
    [ "$status" = installed ] || missing+=("$package")
  done
done
[ ${#missing[@]} -eq 0 ] && exit 0

command -v apt-get > /dev/null \
  || stop "there is no apt-get; install what these Debian packages hold: ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  as_root=(sudo)
  sudo true 2> /dev/null \
    || stop "only root can install; as root run: apt-get update && apt-get install" \
      "--no-install-recommends ${missing[*]}; then run this again"
fi

# Runs apt-get without its lines on standard output. While another program holds one of apt's
# locks, as on a machine that has just started, waits for it: DPkg::Lock::Timeout is for the
# lock of dpkg, not for that of `apt-get update`.
apt_get() {
  local errors minutes=15 tries=0
  until errors=$("${as_root[@]}" env LC_ALL=C DEBIAN_FRONTEND=noninteractive \
    apt-get -qq "$@" 2>&1 > /dev/null); do
    [[ $errors == *"Could not get lock"* ]] && [ $tries -lt $((minutes * 30)) ] \
      || stop "apt-get $1 failed: $errors"
    [ $tries -gt 0 ] \
      || echo "Waiting for another program:" "$(grep 'Could not get lock' <<< "$errors")"
    tries=$((tries + 1))
    sleep 2
  done
  [ -z "$errors" ] || echo "$errors" >&2
}

# A dry run, which needs no lock, tells how much it will be.
echo "Installing ${missing[*]}"
apt_get update
options=(--no-install-recommends "${missing[@]}")
LC_ALL=C "${as_root[@]}" apt-get install --assume-no -o Debug::NoLocking=1 "${options[@]}" \
  2> /dev/null | grep -E '^[0-9]+ upgraded|^Need to get|^After this' || true
apt_get install -y "${options[@]}"
