#!/usr/bin/env bash
# Writes the golden streams with the codec built in several ways, for other compilers,
# optimisations, contractions of floating point and word sizes, and compares the bytes
# with those in test/data/golden.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# The codec needs of PCL nothing and of Eigen headers only.
# GoogleTest, which the writer shares makers of frames with, comes as source with Debian.
gtest=/usr/src/googletest/googletest
eigen=$(pkg-config --cflags eigen3 2> /dev/null || echo -I/usr/include/eigen3)
includes="-Iinclude -Isrc -Itest -I$gtest $eigen"

# fused multiply-add where the processor at hand has it, else there is nothing to contract
fma=
if grep -qw fma /proc/cpuinfo; then fma=-mfma; fi

check() {
  local name=${*// /} compiler=$1
  shift
  mkdir -p "$out/$name/objects" "$out/$name/golden"
  # shellcheck disable=SC2086
  printf '%s\n' src/bytes/*.cpp src/voxels/*.cpp src/voxelizing/*.cpp src/codec/*.cpp src/codec/*/*.cpp src/stream/*.cpp test/write_test_streams.cpp \
    $gtest/src/gtest-all.cc |
    xargs -P 2 -I{} sh -c 'compiler=$1; target=$2; source=$3; shift 3
      exec $compiler "$@" -c "$source" -o "$target/$(basename "$source" .cpp).o"' \
      sh "$compiler" "$out/$name/objects" {} -std=c++17 $includes "$@"
  $compiler "$@" "$out/$name"/objects/*.o -lz -lpthread -o "$out/$name/write_test_streams"
  "$out/$name/write_test_streams" golden "$out/$name/golden"
  rm -r "$out/$name/objects"
  diff -r test/data/golden "$out/$name/golden"
  echo "same bytes: $compiler $*"
}

check g++ -O0
check g++ -O3 -ffp-contract=off
# shellcheck disable=SC2086
check g++ -O3 -ffp-contract=fast $fma
check g++ -O2 -m32
check clang++ -O0
# shellcheck disable=SC2086
check clang++ -O3 -ffp-contract=fast $fma
