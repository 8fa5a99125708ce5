#!/usr/bin/env bash
# Installs the Debian packages of tools/packages.txt that are missing.
# Usage: tools/install_packages.sh [group ...]     (default: build)
set -euo pipefail
list=$(dirname "$0")/packages.txt

missing=()
for group in "${@:-build}"; do
  packages=$(awk -v group="[$group]" '/^\[/ { reading = $1 == group; next }
                                      reading && !/^#/ && NF { print $1 }' "$list")
  if [ -z "$packages" ]; then
    echo "install_packages: no group '$group' in $list" >&2
    exit 2
  fi
  for package in $packages; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing+=("$package")
  done
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "Installing ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
