#!/usr/bin/env bash
# Installs what is missing, builds, measures the paper's experiments on the simulated robot
# cell, checks the figures, and writes a report that is one HTML file.
# Usage: experiments/report.sh [--frames N] [--seconds S] [--output file]
#   --frames   of each sensor (1000)
#   --seconds  of the run of all sensors at once, for each coder (a twentieth of the frames)
#   --output   the report (build-run/report/report.html); measurements lie beside it
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

frames=1000
seconds=
output=$root/build-run/report/report.html
while [ $# -gt 0 ]; do
  case $1 in
    --frames) frames=$2 ;;
    --seconds) seconds=$2 ;;
    --output) output=$2 ;;
    *)
      sed -n '4,7s/^# //p' "$0" >&2
      exit 2
      ;;
  esac
  shift 2
done
seconds=${seconds:-$(((frames + 19) / 20))}
measurements=${output%.html}_measurements

"$root/tools/install_packages.sh" build experiments
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON > /dev/null
cmake --build "$build" -j "${PCL_EXT_JOBS:-2}" \
  --target measure_streams measure_at_once

rm -rf "$measurements"
mkdir -p "$measurements"
programs=$build/experiments/report
"$programs/measure_streams" --frames "$frames" \
  --machine "$measurements/machine.txt" "$measurements/results_streams.csv"
for coder in published fast balanced small; do
  "$programs/measure_at_once" --coder "$coder" --seconds "$seconds" \
    --frames "$((frames < 60 ? frames : 60))" "$measurements/results_at_once_$coder.csv"
done

# Debian's, which has the packages that were installed.
/usr/bin/python3 -B "$root/experiments/report/make_report.py" "$measurements" "$output"
echo "Report: $output"
