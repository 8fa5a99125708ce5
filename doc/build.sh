#!/usr/bin/env bash
# Builds the documentation; any warning is an error.
# Usage: doc/build.sh [output folder]     (default: build-doc)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
output=${1:-$root/build-doc}
mkdir -p "$output"
cd "$root"
(cat doc/Doxyfile; echo "OUTPUT_DIRECTORY = $output") | doxygen -
echo "Documentation: $output/html/index.html"
