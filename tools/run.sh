#!/bin/sh
# Installs what is missing, builds, and runs a stream of clouds through the pipeline.
# Usage: tools/run.sh [options] [PCD file or folder ...]
#   --output FOLDER      for the decoded and the denoised clouds (out)
#   --frames N           of the robot cell (100), or of each input at most
#   --resolution METRES  voxel edge (0.04)
#   --intensity LAW      count, quadratic, linear or native
#   --effort EFFORT      fast, balanced or small
# After the first run --help lists all options.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
# A folder of its own, so that a build by hand in build/ is not disturbed.
build=$root/build-run
program=$build/tools/pcl_ext_stream

case " $* " in
  *" --help "* | *" -h "*)
    if [ -x "$program" ]; then exec "$program" --help; fi
    sed -n '2,9s/^# //p' "$0"
    exit 0
    ;;
esac

"$root/tools/install_packages.sh" build
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF > /dev/null
cmake --build "$build" --target pcl_ext_stream -j "${PCL_EXT_JOBS:-2}"
exec "$program" "$@"
