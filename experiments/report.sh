#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs missing packages, builds, measures the paper's experiments on the simulated robot
# cell, checks that the results are plausible, and writes a report as one HTML file.
# Usage: experiments/report.sh [--frames N] [--seconds S] [--output file]
#   --frames   of each sensor, 3 to 1000000 (1000)
#   --seconds  of the run of all cameras' streams at once, for each coder, 0.1 to 600 (a
#              twentieth of the frames, 5 at most)
#   --output   the report, a file .html (build-report/report.html); the measurements
#              are written beside it. Existing ones are replaced by a complete new report.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

stop() {
  echo "report.sh: $*" >&2
  exit 1
}

frames=1000
seconds=
output=$root/build-report/report.html
while [ $# -gt 0 ]; do
  case $1 in
    --help | -h)
      sed -n '4,11s/^# //p' "$0"
      exit 0
      ;;
    --frames | --seconds | --output)
      [ $# -ge 2 ] || stop "$1 needs a value"
      case $1 in
        --frames) frames=$2 ;;
        --seconds) seconds=$2 ;;
        --output) output=$2 ;;
      esac
      shift 2
      ;;
    *) stop "there is no option '$1'; --help lists the options" ;;
  esac
done
# With fewer frames the results are those of single I-frames.
[[ $frames =~ ^([3-9]|[1-9][0-9]{1,5}|1000000)$ ]] \
  || stop "--frames is '$frames'; it must be a whole number from 3 to 1000000"
seconds=${seconds:-$((frames < 100 ? (frames + 19) / 20 : 5))}
if ! [[ $seconds =~ ^[0-9]+(\.[0-9]+)?$ ]] \
  || ! awk -v seconds="$seconds" 'BEGIN { exit !(seconds >= 0.1 && seconds <= 600) }'; then
  stop "--seconds is '$seconds'; it must be a number from 0.1 to 600"
fi
[[ ${output##*/} == ?*.html ]] || stop "--output is '$output'; it must be a file that ends in .html"
[ ! -d "$output" ] || stop "--output is '$output', which is a folder"
# Written to a folder of its own, beside the output, until it is complete.
new=
mkdir -p "$(dirname "$output")" 2> /dev/null \
  && new=$(mktemp -d "${output%.html}_new.XXXXXX" 2> /dev/null) \
  || stop "--output is '$output'; nothing can be written there"
trap 'rm -rf "$new"' EXIT
chmod 755 "$new"

"$root/tools/install_packages.sh" build experiments viewer
bash "$root/viewer/build.sh" > /dev/null
# Not that of tools/run.sh, which has no PCL.
build=$root/build-report
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON -DPCL_EXT_UNITY_BUILD=ON \
  ${PCL_EXT_CMAKE_ARGUMENTS:-} > /dev/null
cmake --build "$build" -j "${PCL_EXT_JOBS:-2}" --target benchmark pcl_ext_program

measured=$new/measurements
mkdir "$measured"

at_most() { echo $((frames < $1 ? frames : $1)); }
# Arguments: name of the results, most frames, options of the program.
measure() {
  "$build/benchmarks/benchmark" --frames "$(at_most "$2")" "${@:3}" > "$measured/results_$1.csv"
}
measure streams "$frames" --tables streams
# A process for each, so that none finds memory that another one left.
for coder in published fast balanced small; do
  measure "at_once_$coder" "$frames" --tables at_once --efforts "$coder" --seconds "$seconds"
done
measure pictures 1 --tables pictures --folder "$measured"
rm "$measured/results_pictures.csv"
# The viewer with a recording of what a figure shows; arguments: figure, options of the demo.
view_figure() {
  local program=$build/tools/bin/pcl_ext demo=$new/demo
  "$program" demo --frames "$(at_most 100)" --output "$demo" --quiet "${@:2}" > /dev/null
  "$program" view "$demo/cell.mcap" --export "$measured/figure_$1.html" --quiet
  rm -r "$demo"
}
view_figure 10 --sensors 1 --law count
view_figure 11 --sensors 6 --law quadratic
# PCL's filters on one sensor alone, as they are slow.
measure noise_1 300 --tables noise --sensors 1
measure noise 300 --tables noise --sensors 2 3 4 5 6 --methods count linear quadratic voxels
# The lidar has half as many revolutions a second as the cameras have frames.
for weather in none snow dust; do
  measure "lidar_$weather" 45 --tables lidar_noise --weather "$weather" \
    --methods filter "DSOR 5" "DROR 10"
done
measure temporal 300 --tables temporal

# Debian's Python, which has the installed packages.
python() { /usr/bin/python3 -B "$root/experiments/report/$1" "${@:2}"; }
measurements=${output%.html}_measurements
if ! python make_report.py "$measured" "$new/report.html" "$(basename "$measurements")" \
  || ! python check_report.py "$measured" "$new/report.html"; then
  trap - EXIT
  stop "the results are not plausible, or the report could not be made; see above." \
    "The measurements are in '$new'; an earlier report is unchanged"
fi
old=$new/old_measurements
[ ! -e "$measurements" ] || mv "$measurements" "$old"
mv "$measured" "$measurements"
mv "$new/report.html" "$output"
echo "Report: $output"
