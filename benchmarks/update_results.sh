#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, builds, measures, and replaces the tables in doc/benchmarks.md, of
# section points those in doc/peers.md, whose picture doc/points.webp is drawn, too.
# Usage: benchmarks/update_results.sh SECTION [options of the program] [folder of clouds ...]
#   SECTION  peers, points, profiles or scale
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
section=${1:?"usage: $0 peers|points|profiles|scale [options] [folder ...]"}
shift
tables=$section
[ "$section" != peers ] || tables="efforts from_sensor peers recorded"

"$root/tools/install_packages.sh" build benchmark
# Not that of tools/run.sh, which has no PCL.
build=$root/build-benchmarks
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF -DPCL_EXT_UNITY_BUILD=ON \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON > /dev/null
cmake --build "$build" --target benchmark -j "${PCL_EXT_JOBS:-2}"

results=$(mktemp)
page=$(mktemp)
trap 'rm -f "$results" "$page"' EXIT
# shellcheck disable=SC2086 # several tables
measure() { "$build/benchmarks/benchmark" "$@" --tables $tables; }
measure "$@" | tee "$results"
if [ "$section" = scale ]; then
  # Without the machine, which is printed above.
  measure --outlier-removal 0 "$@" | sed '1,2d' | tee -a "$results"
  measure --temporal-filter 8 "$@" | sed '1,2d' | tee -a "$results"
fi
# Replaces what a file has between the section's comments.
replace_results() {
  awk -v results="$2" -v begin="<!-- results of $section -->" \
    -v end="<!-- end of results of $section -->" '
    $0 == end { replacing = 0 }
    !replacing { print }
    $0 == begin {
      replacing = 1
      print ""
      while ((getline line < results) > 0) print line
    }' "$1" > "$page"
  cat "$page" > "$1"
}
if [ "$section" = points ]; then
  replace_results "$root/doc/peers.md" "$results"
  # Debian's Python, which has the installed packages.
  /usr/bin/python3 -B "$root/benchmarks/draw_points.py" "$results" "$root/doc/points.webp"
else
  replace_results "$root/doc/benchmarks.md" "$results"
fi
