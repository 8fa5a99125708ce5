#!/usr/bin/env bash
# Installs what is missing, builds, measures the paper's experiments on the simulated robot
# cell, checks the figures, and writes a report that is one HTML file.
# Usage: experiments/report.sh [--frames N] [--seconds S] [--output file]
#   --frames   of each sensor, 3 to 1000000 (1000)
#   --seconds  of the run of all sensors at once, for each coder, 0.1 to 86400 (a twentieth
#              of the frames)
#   --output   the report, a file .html (build-run/report/report.html); measurements lie
#              beside it. What was there is replaced once the new report is whole.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

stop() {
  echo "report.sh: $*" >&2
  exit 1
}

frames=1000
seconds=
output=$root/build-run/report/report.html
while [ $# -gt 0 ]; do
  case $1 in
    --help | -h)
      sed -n '2,9s/^# //p' "$0"
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
    *) stop "there is no option '$1'; --help tells the options" ;;
  esac
done
# Of fewer the figures are those of single I-frames.
[[ $frames =~ ^([3-9]|[1-9][0-9]{1,5}|1000000)$ ]] \
  || stop "--frames is '$frames'; it must be a whole number from 3 to 1000000"
seconds=${seconds:-$(((frames + 19) / 20))}
if ! [[ $seconds =~ ^[0-9]+(\.[0-9]+)?$ ]] \
  || ! awk -v seconds="$seconds" 'BEGIN { exit !(seconds >= 0.1 && seconds <= 86400) }'; then
  stop "--seconds is '$seconds'; it must be a number from 0.1 to 86400"
fi
[[ ${output##*/} == ?*.html ]] || stop "--output is '$output'; it must be a file that ends in .html"
[ ! -d "$output" ] || stop "--output is '$output', which is a folder"
# Of its own until it is whole, in the folder where it will lie.
new=
mkdir -p "$(dirname "$output")" 2> /dev/null \
  && new=$(mktemp -d "${output%.html}_new.XXXXXX" 2> /dev/null) \
  || stop "--output is '$output'; nothing can be written there"
trap 'rm -rf "$new"' EXIT
chmod 755 "$new"

"$root/tools/install_packages.sh" build experiments
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=ON > /dev/null
cmake --build "$build" -j "${PCL_EXT_JOBS:-2}" \
  --target measure_streams measure_at_once sample_pictures measure_noise

measured=$new/measurements
mkdir "$measured"

programs=$build/experiments/report
"$programs/measure_streams" --frames "$frames" \
  --machine "$measured/machine.txt" "$measured/results_streams.csv"
clouds=$((frames < 60 ? frames : 60))
for coder in published fast balanced small; do
  "$programs/measure_at_once" --coder "$coder" --seconds "$seconds" \
    --frames "$clouds" "$measured/results_at_once_$coder.csv"
done
"$programs/sample_pictures" "$measured"
"$root/experiments/noise/measure_all.sh" "$build/experiments/measure_noise" "$measured" \
  "$frames"

# Debian's, which has the packages that were installed.
python() { /usr/bin/python3 -B "$root/experiments/report/$1" "${@:2}"; }
is_whole=true
python check_measurements.py "$measured" || is_whole=false
python make_report.py "$measured" "$new/report.html" || is_whole=false
if $is_whole; then
  python check_report.py "$new/report.html" || is_whole=false
fi
if ! $is_whole; then
  trap - EXIT
  stop "the figures are not plausible, or the report could not be made; see above." \
    "What was measured is in '$new'; what was there before is untouched"
fi
old=$new/old_measurements
measurements=${output%.html}_measurements
[ ! -e "$measurements" ] || mv "$measurements" "$old"
mv "$measured" "$measurements"
mv "$new/report.html" "$output"
echo "Report: $output"
