#!/usr/bin/env bash
# Installs what is missing, builds, measures, and replaces the tables in doc/benchmarks.md.
# Usage: benchmarks/update_results.sh SECTION [options of the program] [folder of clouds ...]
#   SECTION  peers, profiles, stages, growth, scale or recording
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
section=${1:?"usage: $0 peers|profiles|stages|growth|scale|recording [options] [folder ...]"}
shift
tables=$section
[ "$section" != peers ] || tables="efforts from_sensor peers recorded threads"

"$root/tools/install_packages.sh" build benchmark
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
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
awk -v results="$results" -v begin="<!-- results of $section -->" \
  -v end="<!-- end of results of $section -->" '
  $0 == end { replacing = 0 }
  !replacing { print }
  $0 == begin {
    replacing = 1
    print ""
    while ((getline line < results) > 0) print line
  }' "$root/doc/benchmarks.md" > "$page"
cat "$page" > "$root/doc/benchmarks.md"
