#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Shows a recording in the browser.
# Usage: bash tools/view.sh [RECORDING | - | --cell] [options of pcl_ext view]
#   RECORDING   a .pcxi or MCAP file, or a rosbag2 folder
#   -           frames from the standard input, as they arrive
#   --cell      the simulated robot cell, live
# Without arguments: a recording of the simulated robot cell, which is made in build-run.
# The first run takes as long as that of tools/run.sh, some minutes.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
case ${1:-} in
  --help | -h)
    sed -n '4,/^set /s/^# //p' "$0"
    exit 0
    ;;
esac

case ${1:-} in
  -*) ;;
  ?*)
    # Before the packages and the build, which take minutes.
    if [ ! -e "$1" ]; then
      echo "There is no '$1'" >&2
      exit 1
    fi
    ;;
esac
if [ $# -eq 0 ]; then
  demo=$root/build-run/demo
  [ -e "$demo/cell.mcap" ] ||
    bash "$root/tools/run.sh" demo --sensors 6 --frames 200 --law quadratic --output "$demo" >&2
  set -- "$demo/cell.mcap"
fi
exec bash "$root/tools/run.sh" view "$@"
