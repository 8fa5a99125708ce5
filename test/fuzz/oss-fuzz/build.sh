#!/bin/bash -eu
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the fuzz targets as OSS-Fuzz asks for it: with $CXX, $CXXFLAGS and
# $LIB_FUZZING_ENGINE, the source in $SRC/pcl_ext, into $OUT.

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT

# Nothing of the targets is in PCL's or Boost's libraries, which $OUT would have to hold,
# and which are not instrumented; zlib is linked in.
cmake -S "$SRC/pcl_ext" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=None \
  -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_CXX_FLAGS="$CXXFLAGS" \
  -DCMAKE_EXE_LINKER_FLAGS="-Wl,--as-needed" \
  -DZLIB_LIBRARY="$(find /usr/lib -name libz.a | head -n 1)" \
  -DPCL_EXT_FUZZ=ON -DPCL_EXT_FUZZING_ENGINE="$LIB_FUZZING_ENGINE" \
  -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF
cmake --build "$build" --target fuzz_targets write_fuzz_seeds

# Of programs that the build runs itself, leaks do not matter.
ASAN_OPTIONS=detect_leaks=0 \
  "$build/test/fuzz/write_fuzz_seeds" "$SRC/pcl_ext/test/data" "$build/seeds"

for program in "$build"/test/fuzz/fuzz_*; do
  name=$(basename "$program")
  target=${name#fuzz_}
  cp "$program" "$OUT/"
  (cd "$build/seeds/$target" && zip -q -r "$OUT/${name}_seed_corpus.zip" .)
  printf '[libfuzzer]\nmax_len = 1024\n' > "$OUT/$name.options"
done
cp "$SRC/pcl_ext/test/fuzz/frames.dict" "$OUT/fuzz_decode_any_bytes.dict"
