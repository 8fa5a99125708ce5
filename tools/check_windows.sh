#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the libraries as DLLs for Windows, by CMake with the toolchain file of mingw, and
# runs programs that use them as users do, under wine: what the macros of
# pcl_ext/export.h export must be all that they need. Public headers are compiled after
# windows.h with its macros. Needs the groups `build` and `platforms` of tools/packages.txt.
#
# Debian has no zstd, lz4 and LZF for mingw. Where a folder has them, in include and lib,
#   PCL_EXT_MINGW_PREFIX=FOLDER tools/check_windows.sh
# builds recordings and the program, too, runs the tests of recordings, and the program's info
# and verify; PCL_EXT_PROGRAM is a native one, which must print the same. With
# PCL_EXT_WINDOWS_PYTHON, a folder with include and libs of a Python for Windows, and pybind11-dev
# the Python module is built for it, too, and not run.
# PCL_EXT_JOBS (2) at a time.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mktemp -d)
export WINEPREFIX=$out/wine WINEDEBUG=-all
cleanUp() {
  # Wine's server outlives its programs by seconds, and writes in the folder.
  if [ -d "$WINEPREFIX" ]; then /usr/lib/wine/wineserver64 -k -w || true; fi
  rm -rf "$out"
}
trap cleanUp EXIT
wine=/usr/lib/wine/wine64
compiler=x86_64-w64-mingw32-g++-posix
gtest=/usr/src/googletest/googletest # comes as source with Debian
prefix=$out/prefix
with_recording=OFF
if [ -n "${PCL_EXT_MINGW_PREFIX:-}" ]; then with_recording=ON; fi

# Headers that need no library. Not /usr/include itself: the rest of it is not for Windows.
copy_headers() {
  mkdir -p "$prefix"/{include,share/cmake,share/eigen3}
  cp -r /usr/include/{eigen3,nlohmann,CLI} "$prefix/include"
  ln -s /usr/include/boost "$prefix/include/boost"
  cp -r /usr/share/cmake/{nlohmann_json,CLI11} "$prefix/share/cmake"
  cp -r /usr/share/eigen3/cmake "$prefix/share/eigen3"
}

copy_pybind11() {
  cp -r /usr/include/pybind11 "$prefix/include"
  cp -rL "$(pybind11-config --cmakedir)" "$prefix/share/cmake"
}

check_headers() {
  local header source=$out/header.cpp flags
  flags="-std=c++17 -pedantic-errors -Wall -Wextra -Werror -fsyntax-only -Iinclude"
  while read -r header; do
    # The standard library and Eigen take care of these macros themselves.
    printf '#include <%s>\n' Eigen/Geometry algorithm chrono functional limits map memory \
      optional set string vector windows.h > "$source"
    printf '%s\n' '#define min(a, b) windows_min' '#define max(a, b) windows_max' \
      "#include \"${header#include/}\"" >> "$source"
    # shellcheck disable=SC2086
    $compiler $flags -isystem "$prefix/include/eigen3" "$source"
  done < <(grep -rLE 'pcl/|(point|octree_pointcloud)_intensity\.h|nodes/' include --include='*.h' | grep -v /nodes/)
  echo "public headers compile after windows.h"
}

build() {
  cmake -S "$1" -B "$out/$2" -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/mingw64.cmake" \
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix;${PCL_EXT_MINGW_PREFIX:-}" \
    "${@:3}" > "$out/$2.log" &&
    cmake --build "$out/$2" -j "${PCL_EXT_JOBS:-2}" >> "$out/$2.log" && return
  cat "$out/$2.log"
  return 1
}

check_consumer() {
  build "test/package/$1" "$1"
  (cd "$out/$1" && $wine "$1.exe")
  echo "a program uses the DLL: $1"
}

# All tests of recordings but those of pipes and of limits of the system. Left out are: what
# copies over a file, which libstdc++ refuses on Windows; what needs /dev/full; what removes
# a folder whose file is open.
test_recordings() {
  local tests=(test/recording/test_{damaged_recordings,hostile_files,recording_outputs}.cpp
    test/recording/test_{point_cloud_messages,recordings,rosbag2_metadata}.cpp)
  printf '%s\n' '#include "support/test_memory.h" // which knows memory of glibc only' \
    'namespace pcl_ext::test { MemoryUse::MemoryUse() {} MemoryUse::~MemoryUse() {}' \
    'std::size_t MemoryUse::peak() const { return 0; }' \
    'std::size_t MemoryUse::live() const { return 0; } }' > "$out/memory.cpp"
  # shellcheck disable=SC2046
  $compiler -std=c++17 -w -O1 -static -I. -Iinclude -Isrc -Itest -I"$gtest" -I"$gtest/include" \
    -isystem "$prefix/include/eigen3" -isystem "$PCL_EXT_MINGW_PREFIX/include" \
    -Dpcl_ext_recording_EXPORTS "${tests[@]}" "$out/memory.cpp" "$gtest"/src/gtest{-all,_main}.cc $(find "$out/libraries/src" -path '*recording_objects*.obj') \
    "$out/libraries/src/libpcl_ext_codec.dll.a" -L"$PCL_EXT_MINGW_PREFIX/lib" -lzstd -llz4 -lz \
    -o "$out/test_recording.exe"
  $wine "$out/test_recording.exe" --gtest_brief=1 \
    --gtest_filter='-*QosOfChannelsIsWrittenAndRead:*AFullDiskIsReported*:*AFailureOfFinishIsKept'
}

# Prints the output and the status of a command of the program.
run_program() {
  local status=0
  "$@" 2>&1 | tr -d '\r' || status=$?
  echo "status $status"
}

check_program() {
  local program=$1 input command
  head -c 3000 consumer.mcap > damaged.mcap
  for input in consumer.mcap damaged.mcap missing.mcap; do
    for command in info verify; do
      run_program "$wine" "$program" "$command" "$input" > windows.txt
      if [ -n "${PCL_EXT_PROGRAM:-}" ]; then
        run_program "$PCL_EXT_PROGRAM" "$command" "$input" | diff - windows.txt
      fi
    done
    cat windows.txt # of verify
  done
  for command in view send receive keep; do
    run_program "$wine" "$program" "$command" consumer.mcap | grep "this program was built without"
  done
}

copy_headers
check_headers
python=()
if [ -n "${PCL_EXT_WINDOWS_PYTHON:-}" ]; then
  if [ $with_recording = OFF ]; then
    echo "check_windows: the Python module needs PCL_EXT_MINGW_PREFIX, too" >&2
    exit 2
  fi
  copy_pybind11
  python=(-DPCL_EXT_BUILD_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3
    -DPython3_INCLUDE_DIR="$PCL_EXT_WINDOWS_PYTHON/include"
    -DPython3_LIBRARY="$(echo "$PCL_EXT_WINDOWS_PYTHON"/libs/python3?*.lib)")
fi
build . libraries -DCMAKE_INSTALL_PREFIX="$prefix" -DPCL_EXT_WITH_PCL=OFF \
  -DPCL_EXT_WITH_RECORDING=$with_recording -DPCL_EXT_BUILD_TOOLS=$with_recording \
  -DPCL_EXT_WITH_VIEW=OFF -DPCL_EXT_WITH_LINK=OFF -DPCL_EXT_UNITY_BUILD=ON \
  -DPCL_EXT_WARNINGS_AS_ERRORS=ON ${python[@]+"${python[@]}"}
cmake --install "$out/libraries" > /dev/null
if [ ${#python[@]} -gt 0 ]; then
  x86_64-w64-mingw32-objdump -p "$out"/libraries/python/pcl_ext/_native.cpython* | grep PyInit__native
  echo "the Python module is linked with DLLs"
fi
export WINEPATH="Z:$prefix/bin;Z:/usr/x86_64-w64-mingw32/lib"
check_consumer codec_consumer
if [ $with_recording = ON ]; then
  check_consumer recording_consumer
  test_recordings
  (cd "$out/recording_consumer" && check_program "$prefix/bin/pcl_ext.exe")
fi
