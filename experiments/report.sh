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
targets=(measure_streams measure_at_once sample_pictures)
if [ -d "$root/experiments/noise" ]; then
  targets+=(measure_noise)
fi
cmake --build "$build" -j "${PCL_EXT_JOBS:-2}" --target "${targets[@]}"

at_most() { echo $((frames < $1 ? frames : $1)); }

rm -rf "$measurements"
mkdir -p "$measurements"
programs=$build/experiments/report
"$programs/measure_streams" --frames "$frames" \
  --machine "$measurements/machine.txt" "$measurements/results_streams.csv"
for coder in published fast balanced small; do
  "$programs/measure_at_once" --coder "$coder" --seconds "$seconds" \
    --frames "$(at_most 60)" "$measurements/results_at_once_$coder.csv"
done
"$programs/sample_pictures" "$measurements"

measure_noise() {
  local part=$1 most_frames=$2
  shift 2
  echo "measure_noise: $part" >&2
  "$build/experiments/measure_noise" --part "$part" --frames "$(at_most "$most_frames")" \
    "$@" > "$measurements/noise_$part.md"
}
if [ -d "$root/experiments/noise" ]; then
  measure_noise laws 300 --sensor 1 2 3 4 5 6
  measure_noise fused 300
  measure_noise peers 60
  measure_noise time 60
  measure_noise bytes 300
fi

# Debian's, which has the packages that were installed.
/usr/bin/python3 -B "$root/experiments/report/make_report.py" "$measurements" "$output"
/usr/bin/python3 -B "$root/experiments/report/check_report.py" "$measurements" "$output"
echo "Report: $output"
