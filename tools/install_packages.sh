#!/usr/bin/env bash
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
    # Other packages of nodejs than Debian's have npm in them, and conflict with Debian's.
    [ "$package" = npm ] && command -v npm > /dev/null && status=installed
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

# A dry run tells how much it will be.
echo "Installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
options=(--no-install-recommends "${missing[@]}")
LC_ALL=C "${as_root[@]}" apt-get install --assume-no "${options[@]}" 2> /dev/null \
  | grep -E '^[0-9]+ upgraded|^Need to get|^After this' || true
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq "${options[@]}" > /dev/null
