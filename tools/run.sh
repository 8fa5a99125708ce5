#!/bin/sh
# Installs what is missing, builds, and runs a stream of clouds through the pipeline.
# Usage: bash tools/run.sh [options] [PCD file or folder ...]
#   --output FOLDER      for the decoded and the denoised clouds (out)
#   --frames N           of the robot cell (100), or of each input at most
#   --resolution METRES  voxel edge (0.04)
#   --intensity LAW      count, quadratic, linear or native
#   --sensor SENSOR      for quadratic and linear: kinect_v2, kinect_v1, azure_kinect_nfov, or
#                        field of view and image: degrees,degrees,columns,rows
#   --effort EFFORT      fast, balanced or small
#   --crop BOX           x0,y0,z0,x1,y1,z1 to keep, m
#   --threshold I        remove voxels of lower intensity, instead of outliers
# Without input: the simulated robot cell. Each folder is a stream; all single files together
# are one. After the first run --help lists all options.
# The first run takes about 6 minutes on a fresh Debian 12 with two cores: it installs about
# 720 packages (3.4 GB with PCL) and builds in build-run. Later runs take seconds.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
# A folder of its own, so that a build by hand in build/ is not disturbed.
build=$root/build-run
program=$build/tools/pcl_ext_stream

case " $* " in
  *" --help "* | *" -h "*)
    if [ -x "$program" ]; then exec "$program" --help; fi
    sed -n '2,/^set /s/^# //p' "$0"
    exit 0
    ;;
esac

# Before the packages and the build, which take minutes. All options have a value.
is_value=no
for argument; do
  case $is_value$argument in
    no--*=*) ;;
    no--* | no-?) is_value=yes ;;
    no-*) ;;
    no*)
      if [ ! -e "$argument" ]; then
        echo "There is no '$argument'" >&2
        exit 1
      fi
      ;;
    *) is_value=no ;;
  esac
done

bash "$root/tools/install_packages.sh" build
[ -x "$program" ] || echo "Building in $build; this takes a few minutes the first time"
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF > /dev/null
cmake --build "$build" --target pcl_ext_stream -j "${PCL_EXT_JOBS:-2}"
exec "$program" "$@"
