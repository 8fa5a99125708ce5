#!/usr/bin/env bash
# Installs what is missing, builds, measures, and replaces the tables in doc/benchmarks.md.
# Usage: benchmarks/update_results.sh [peers] [options of compare_with_peers] [folder of PCD files ...]
#        benchmarks/update_results.sh profiles [options of compare_with_peers] [folder of PCD files ...]
#        benchmarks/update_results.sh scale [options of measure_scale] [folder of PCD files ...]
#        benchmarks/update_results.sh stages [options of measure_stages] [folder of PCD files ...]
#        benchmarks/update_results.sh growth [options of measure_growth]
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

program=compare_with_peers
section=results
case ${1:-} in
  peers) shift ;;
  profiles)
    shift
    section="results of profiles"
    set -- --tables profiles "$@"
    ;;
  scale)
    shift
    program=measure_scale
    section="results of scale"
    ;;
  stages)
    shift
    program=measure_stages
    section="results of stages"
    ;;
  growth)
    shift
    program=measure_growth
    section="results of growth"
    ;;
esac

"$root/tools/install_packages.sh" build benchmark
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON > /dev/null
cmake --build "$build" --target "$program" -j "${PCL_EXT_JOBS:-2}"

results=$(mktemp)
page=$(mktemp)
counts=$(mktemp -d)
trap 'rm -rf "$results" "$page" "$counts"' EXIT
"$build/benchmarks/$program" "$@" | tee "$results"
if [ "$program" = measure_scale ]; then
  # Without the machine, which is printed above.
  "$build/benchmarks/$program" --outlier-removal 0 "$@" | sed '1,2d' | tee -a "$results"
fi
if [ "$program" = measure_stages ] && grep -q "^Not counted" "$results"; then
  valgrind --quiet --tool=callgrind --instr-atstart=no --branch-sim=yes --cache-sim=yes \
    --callgrind-out-file="$counts/stages" "$build/benchmarks/$program" \
    --callgrind-file "$counts/stages" "$@" | sed '1,2d' | tee -a "$results"
fi
awk -v results="$results" -v begin="<!-- $section -->" -v end="<!-- end of $section -->" '
  $0 == end { replacing = 0 }
  !replacing { print }
  $0 == begin {
    replacing = 1
    print ""
    while ((getline line < results) > 0) print line
  }' "$root/doc/benchmarks.md" > "$page"
cat "$page" > "$root/doc/benchmarks.md"
