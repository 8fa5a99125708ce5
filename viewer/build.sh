#!/usr/bin/env bash
# Builds the viewer: the codec in WebAssembly, then the page, one file, viewer/dist/viewer.html.
# Needs the group `viewer` of tools/packages.txt, and `npm ci` in this folder.
# With an argument the page is written there.
set -euo pipefail
cd "$(dirname "$0")"

if ! [ -e node_modules/.bin/esbuild ]; then
  echo "$0: run 'npm ci' in viewer, which installs what the page is built with" >&2
  exit 1
fi
bash codec/build.sh
node_modules/.bin/tsc -p page
node bundle.mjs "$@"
