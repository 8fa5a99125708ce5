#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, builds everything and runs all tests.
# Usage: bash tools/test.sh [ctest arguments]
set -eu
case ${1:-} in
  --help | -h)
    sed -n '4,5s/^# //p' "$0"
    exit 0
    ;;
esac
root=$(cd "$(dirname "$0")/.." && pwd)

bash "$root/tools/install_packages.sh" build python
# Not another Python that comes first in the path, without the packages.
cmake -S "$root" -B "$root/build-test" -G Ninja \
  -DPCL_EXT_UNITY_BUILD=ON -DPCL_EXT_BUILD_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3 \
  ${PCL_EXT_CMAKE_ARGUMENTS:-} > /dev/null
# What tests need of the machine and the network is told before the build, which takes long.
bash "$root/tools/fetch_node_packages.sh" "$root/build-test/test/mcap_core" ||
  echo "test.sh: the test mcap_core will fail" >&2
bash "$root/tools/fetch_nats_server.sh" > /dev/null ||
  echo "test.sh: the tests of Link, ProgramSite and ProgramCentres will fail" >&2
script -qec true /dev/null > /dev/null 2>&1 < /dev/null ||
  echo "test.sh: no /dev/pts is mounted; tests of ProgramOptions that need a terminal will fail" >&2
jobs=${PCL_EXT_JOBS:-2}
cmake --build "$root/build-test" -j "$jobs"
cd "$root/build-test"
# One more than there are processors, as some tests wait for programs.
exec ctest --output-on-failure -j $((jobs + 1)) "$@"
