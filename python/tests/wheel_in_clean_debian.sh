#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs a wheel in a virtual environment of a clean Debian of this machine's release that has
# python3, python3-venv and python3-numpy, without compiler, PCL or packages of this project, and
# uses it there. The Debian is deleted in the end.
# Usage, as root: wheel_in_clean_debian.sh WHEEL
set -euo pipefail
tests=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf --one-file-system "$work"' EXIT
mkdir "$work/wheel"
cp "$1" "$tests/use_wheel.py" "$work/wheel"

# Packages come from where this machine has its own from, by the same proxy.
apt-config dump | grep '^Acquire' > "$work/apt.conf" || true
sources=()
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.{list,sources}; do
  if [ -s "$file" ]; then sources+=("$file"); fi
done
mmdebstrap --mode=root --quiet --variant=apt --include=python3-venv,python3-numpy \
  --aptopt="$work/apt.conf" --dpkgopt=force-unsafe-io --dpkgopt='path-exclude=/usr/share/doc/*' \
  --customize-hook="copy-in '$work/wheel' /" \
  --customize-hook='chroot "$1" python3 -m venv --system-site-packages /venv' \
  --customize-hook='chroot "$1" sh -c "/venv/bin/pip install --quiet --no-index /wheel/*.whl"' \
  --customize-hook='chroot "$1" /venv/bin/python /wheel/use_wheel.py' \
  "$(. /etc/os-release && echo "$VERSION_CODENAME")" /dev/null "${sources[@]}"
