#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the codec with the tests of its golden streams for each platform below, and runs
# them there: the bytes in test/data/golden must be written and read everywhere. With them
# run tests of what differs between processors: vectors, bits, the order of bytes.
# Needs the groups `build`, `check` and `platforms` of tools/packages.txt.
#
# tools/check_windows.sh follows, where the expression does not leave it out.
#
# Usage: tools/check_determinism.sh [regular expression]
# Only platforms whose line the expression matches; PCL_EXT_JOBS (2) at a time.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mktemp -d)
cleanUp() {
  # Wine's server outlives its programs by seconds, and writes in the folder.
  if [ -d "$out/wine" ]; then
    WINEPREFIX=$out/wine /usr/lib/wine/wineserver64 -k -w || true
  fi
  rm -rf "$out"
}
trap cleanUp EXIT

# fused multiply-add where this processor has it; else there is nothing to contract
fma=
if grep -qw fma /proc/cpuinfo; then fma=-mfma; fi
arm=aarch64-linux-gnu
big_endian=s390x-linux-gnu
wine="env WINEPREFIX=$out/wine WINEDEBUG=-all /usr/lib/wine/wine64"
node="node --no-warnings --experimental-wasi-unstable-preview1 test/platforms/run_wasm.mjs"

# The vectors that src/simd/lanes.h must choose | what runs the program | compiler and flags
platforms="\
Sse2Lanes   | | g++ -O3 -ffp-contract=fast $fma
ScalarLanes | | g++ -O2 -m32
Sse2Lanes   | | clang++ -O0
Sse2Lanes   | | clang++ -O3 -ffp-contract=fast $fma
NeonLanes   | qemu-aarch64 -L /usr/$arm | clang++ --target=$arm -O2 -ffp-contract=fast
ScalarLanes | qemu-s390x -L /usr/$big_endian | clang++ --target=$big_endian -O2 -ffp-contract=fast
Sse2Lanes   | $wine | x86_64-w64-mingw32-g++-posix -O2 -static
ScalarLanes | $node | clang++ --target=wasm32-wasi -O2 -fno-exceptions"

tests="test/stream/test_golden_streams.cpp test/bytes/test_byte_io.cpp
  test/simd/test_lanes.cpp
  test/voxelizing/test_point_blocks.cpp test/voxelizing/test_point_locator.cpp"
gtest=/usr/src/googletest/googletest # comes as source with Debian
eigen=$(pkg-config --cflags eigen3 2> /dev/null || echo -I/usr/include/eigen3)

# One unit of all sources and one of all tests, as else most of the time would go into the
# standard library's headers; GoogleTest in another, not optimised; files for AVX2 by
# themselves.
avx2="src/voxelizing/locate_points_avx2.cpp test/simd/lanes_computation_avx2.cpp"
{
  printf '#include "%s"\n' $(find src/{bytes,voxels,voxelizing,codec,rate,stream,outliers} \
    -name '*.cpp' ! -name '*_avx2.cpp' | sort)
  echo 'static_assert(std::is_same_v<pcl_ext::NativeLanes, pcl_ext::LANES>);'
} > "$out/codec.cpp"
{
  echo '#define PCL_EXT_TEST_DATA "test/data"'
  # shellcheck disable=SC2086
  printf '#include "%s"\n' $tests
} > "$out/tests.cpp"
printf '#include "src/%s"\n' gtest-all.cc gtest_main.cc > "$out/googletest.cpp"

check() {
  local lanes=$1 runner=$2 compiler=$3 program=$out/$BASHPID start=$SECONDS
  local zlib=-lz flags="-std=c++17 -w -DPCL_EXT_STATIC -I. -Iinclude -Isrc -Itest -I$gtest -I$gtest/include $eigen"
  case $compiler in # Debian has no zlib for them
    *--target=*) zlib= flags+=" -Isrc/platforms" ;;
  esac
  case $compiler in # has no dup(), which only GoogleTest's own tests need
    *wasm*) flags+=" -DGTEST_HAS_STREAM_REDIRECTION=0" ;;
  esac
  # shellcheck disable=SC2086
  $compiler $flags -O0 -c "$out/googletest.cpp" -o "$program.googletest.o" &&
    $compiler $flags -DLANES="$lanes" -c "$out/codec.cpp" -o "$program.codec.o" &&
    $compiler $flags -c "$out/tests.cpp" -o "$program.tests.o" &&
    for file in $avx2; do
      $compiler $flags -c "$file" -o "$program.${file//\//.}.o" || return 1
    done &&
    $compiler "$program".*.o $zlib -o "$program.exe" &&
    $runner "$program.exe" --gtest_brief=1 || return 1
  echo "same bytes: $compiler ($lanes, $((SECONDS - start)) s)"
}

# Prints one line, or the whole output if something failed.
report() {
  local log=$out/$BASHPID.log
  if "$@" > "$log" 2>&1; then
    tail -n 1 "$log"
  else
    cat "$log"
    echo "FAILED: $*"
    touch "$out/failed"
  fi
}

while IFS='|' read -r lanes runner compiler; do
  while [ "$(jobs -rp | wc -l)" -ge "${PCL_EXT_JOBS:-2}" ]; do wait -n; done
  read -r lanes <<< "$lanes"
  report check "$lanes" "$runner" "${compiler# }" &
done < <(grep -E "${1:-}" <<< "$platforms")
wait
if grep -qE "${1:-}" <<< "check_windows"; then report tools/check_windows.sh; fi
[ ! -e "$out/failed" ]
