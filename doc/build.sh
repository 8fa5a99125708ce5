#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing and builds the documentation; any warning and any dead link is an error.
# Usage: doc/build.sh [output folder]     (default: build-doc)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
output=${1:-$root/build-doc}
bash "$root/tools/install_packages.sh" documentation
rm -rf "$output/html"
mkdir -p "$output"
cd "$root"
(cat doc/Doxyfile; echo "OUTPUT_DIRECTORY = $output") | doxygen -
python3 -B doc/check_links.py "$output/html" $(find . -name '*.md' -not -path '*/build*' -not -path '*/node_modules/*')
echo "Documentation: $output/html/index.html"
