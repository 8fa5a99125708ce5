#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Fetches the packages that a folder's package-lock.json lists from npm's registry, unless
# they are there. Prints nothing, or one line if they cannot be fetched.
# Usage: bash tools/fetch_node_packages.sh FOLDER
set -euo pipefail
cd "$1"
[ node_modules/.package-lock.json -nt package-lock.json ] && exit 0
if ! log=$(npm ci --prefer-offline --ignore-scripts --no-audit --no-fund 2>&1); then
  echo "npm cannot fetch what $PWD/package-lock.json lists:" \
    "$(grep -m 1 'reason:' <<< "$log" || head -n 1 <<< "$log")" >&2
  exit 1
fi
