#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, builds the library and the ROS package on it, and runs the
# package's tests, each with a ROS master of its own.
# Usage: tools/test_ros.sh [ctest arguments]
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)

"$root/tools/build_ros.sh" -DPCL_EXT_ROS1_BUILD_TESTS=ON
cd "$root/build-ros"
exec ctest --output-on-failure -j "${PCL_EXT_JOBS:-2}" "$@"
