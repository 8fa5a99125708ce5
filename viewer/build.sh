#!/usr/bin/env bash
# Builds the viewer: the codec in WebAssembly, then the page, one file, viewer/dist/viewer.html.
# Needs the group `viewer` of tools/packages.txt; npm's packages are installed in this folder.
# With an argument the page is written there.
set -euo pipefail
cd "$(dirname "$0")"

if ! [ node_modules/.package-lock.json -nt package-lock.json ]; then
  if ! log=$(npm ci --no-audit --no-fund 2>&1); then
    echo "$log" >&2
    echo "$0: npm cannot install what viewer/package-lock.json lists" >&2
    exit 1
  fi
fi
bash codec/build.sh
node_modules/.bin/tsc -p page
node bundle.mjs "$@"
