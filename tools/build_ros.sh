#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, builds the library and the ROS package on it, in build-ros/.
# After `source build-ros/devel/setup.bash` roslaunch finds the nodes.
# Usage: tools/build_ros.sh [CMake arguments for the ROS package]
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build-ros
library=$root/build-ros-library # beside the others, so that ccache knows its files
jobs=${PCL_EXT_JOBS:-2}

"$root/tools/install_packages.sh" build ros
cmake -S "$root" -B "$library" -G Ninja -DPCL_EXT_BUILD_TESTS=OFF -DPCL_EXT_UNITY_BUILD=ON \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF \
  -DPCL_EXT_BUILD_TOOLS=OFF ${PCL_EXT_CMAKE_ARGUMENTS:-} > /dev/null
cmake --build "$library" -j "$jobs"
cmake --install "$library" --prefix "$build/prefix" > /dev/null
# Debian's catkin is for Debian's Python; another one may come first in the PATH.
cmake -S "$root/ros" -B "$build" -G Ninja -DCMAKE_PREFIX_PATH="$build/prefix" \
  -DPYTHON_EXECUTABLE=/usr/bin/python3 ${PCL_EXT_CMAKE_ARGUMENTS:-} "$@" > /dev/null
cmake --build "$build" -j "$jobs"
