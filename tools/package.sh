#!/bin/sh
# Installs what is missing, builds the Debian packages and checks them with lintian. They are
# for the distribution that this runs on, and lie in build-package/packages afterwards.
# Usage: bash tools/package.sh
set -eu
case ${1:-} in
  --help | -h)
    sed -n '2,4s/^# //p' "$0"
    exit 0
    ;;
esac
root=$(cd "$(dirname "$0")/.." && pwd)
build=$root/build-package

bash "$root/tools/install_packages.sh" build package viewer
# The packages are the same bytes each time: their files have the time of the last commit.
umask 022
if time=$(git -C "$root" log -1 --format=%ct 2> /dev/null); then
  export SOURCE_DATE_EPOCH="$time"
fi
# The compiler gets the flags that the tests run with, the linker those of the distribution.
linker_flags=$(DEB_BUILD_MAINT_OPTIONS=hardening=+bindnow dpkg-buildflags --get LDFLAGS)
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr \
  -DCMAKE_SHARED_LINKER_FLAGS="$linker_flags" -DCMAKE_MODULE_LINKER_FLAGS="$linker_flags" \
  -DCMAKE_EXE_LINKER_FLAGS="$linker_flags" -DPCL_EXT_BUILD_TESTS=OFF \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF \
  -DPCL_EXT_BUILD_VIEWER=ON -DPCL_EXT_UNITY_BUILD=ON \
  -DPCL_EXT_BUILD_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3 \
  ${PCL_EXT_CMAKE_ARGUMENTS:-} > /dev/null
cmake --build "$build" -j "${PCL_EXT_JOBS:-2}"
rm -f "$build"/packages/*.deb
cd "$build"
if ! cpack > cpack.log 2>&1; then
  cat cpack.log
  exit 1
fi
# Root may run it, too, as a container has no one else.
lintian --allow-root --fail-on error packages/*.deb
ls -l packages/*.deb
