#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the viewer: the codec in WebAssembly, then the page, one file, viewer/dist/viewer.html.
# Installs the Debian packages that are missing; npm's packages are installed in this folder.
# With an argument the page is written there.
set -euo pipefail
cd "$(dirname "$0")"
bash ../tools/install_packages.sh viewer

bash ../tools/fetch_node_packages.sh .
bash codec/build.sh
node_modules/.bin/tsc -p page
node bundle.mjs "$@"
