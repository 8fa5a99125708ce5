#!/usr/bin/env bash
# Installs what is missing, builds, compares with all peers, and puts the tables into
# doc/benchmarks.md in the place of those that were there.
# Usage: benchmarks/update_results.sh [options of compare_with_peers] [folder of PCD files ...]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

"$root/tools/install_packages.sh" build benchmark
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON > /dev/null
cmake --build "$build" --target compare_with_peers -j "${PCL_EXT_JOBS:-2}"

results=$(mktemp)
page=$(mktemp)
trap 'rm -f "$results" "$page"' EXIT
"$build/benchmarks/compare_with_peers" "$@" | tee "$results"
awk -v results="$results" '
  /^<!-- end of results -->/ { replacing = 0 }
  !replacing { print }
  /^<!-- results -->/ {
    replacing = 1
    print ""
    while ((getline line < results) > 0) print line
  }' "$root/doc/benchmarks.md" > "$page"
cat "$page" > "$root/doc/benchmarks.md"
