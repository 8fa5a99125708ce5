#!/usr/bin/env bash
# Installs what is missing, builds, measures all figures of experiments/noise/README.md anew,
# and puts them in the place of those that were there.
# Usage: experiments/noise/update_readme.sh [folder that report.sh left measurements in]
#   With a folder nothing is measured: its figures are taken, if they are of enough frames.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)

if [ $# -gt 1 ] || [[ ${1:-} == -* ]]; then
  sed -n '2,5s/^# //p' "$0" >&2
  [[ ${1:-} == --help || ${1:-} == -h ]]
  exit
fi
"$root/tools/install_packages.sh" build experiments
if [ $# -eq 1 ]; then
  measured=$1
else
  build=$root/build-run
  cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
    -DPCL_EXT_BUILD_EXAMPLES=OFF > /dev/null
  cmake --build "$build" --target measure_noise -j "${PCL_EXT_JOBS:-2}"
  measured=$(mktemp -d)
  trap 'rm -rf "$measured"' EXIT
  "$root/experiments/noise/measure_all.sh" "$build/experiments/measure_noise" "$measured" 300
fi
/usr/bin/python3 -B "$root/experiments/report/update_noise_readme.py" "$measured" \
  "$root/experiments/noise/README.md"
