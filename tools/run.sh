#!/usr/bin/env bash
# Installs what is missing, builds, and runs a stream of clouds through the pipeline.
# Usage: tools/run.sh [options] [PCD file or folder ...]     (--help tells the options)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)

"$root/tools/install_packages.sh" build
# A folder of its own, so that a build by hand in build/ is not disturbed.
build=$root/build-run
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF > /dev/null
cmake --build "$build" --target pcl_ext_stream -j "${PCL_EXT_JOBS:-2}"
exec "$build/tools/pcl_ext_stream" "$@"
