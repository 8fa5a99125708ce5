#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the package @pcl_ext/codec in viewer/codec/dist: codec.wasm from the library's
# sources, and the wrapper from TypeScript. Needs the group `viewer` of tools/packages.txt,
# and `npm ci` in viewer.
set -euo pipefail
cd "$(dirname "$0")/../.."
package=viewer/codec
out=$package/dist
objects=$(mktemp -d)
trap 'rm -rf "$objects"' EXIT

require() { # package, and what of it must be there
  if ! [ -e "$2" ] && ! command -v "$2" > /dev/null; then
    echo "$0: install the Debian package $1, which has $2" >&2
    exit 1
  fi
}
require clang clang++
require lld wasm-ld
require libeigen3-dev /usr/include/eigen3/Eigen/Core
require wasi-libc /usr/include/wasm32-wasi/wasi/api.h
require libc++-dev-wasm32 /usr/lib/wasm32-wasi/libc++.a
require libclang-rt-dev-wasm32 "$(clang++ --target=wasm32-wasi -print-libgcc-file-name)"
if ! [ -e viewer/node_modules/.bin/tsc ]; then
  echo "$0: run 'npm ci' in viewer, which installs TypeScript" >&2
  exit 1
fi

# Without virtual functions that nobody calls there is no encoder. Vectors (Safari 16.4,
# Firefox 89, Chrome 91) make the filter of outliers four times as fast.
flags="--target=wasm32-wasi -std=c++17 -fno-exceptions -fno-rtti -DNDEBUG -mbulk-memory
  -msimd128 -flto -fvisibility=hidden -fwhole-program-vtables -fvirtual-function-elimination
  -D_LIBCPP_DISABLE_EXTERN_TEMPLATE
  -Wall -Wextra -I. -Isrc -Iinclude -Isrc/platforms -isystem /usr/include/eigen3"

# Units of many sources, as else most of the time would go into the standard library's
# headers. Prints nothing, unless it fails.
compile() { # optimisation, name of the unit, sources
  local optimisation=$1 unit=$objects/$2
  shift 2
  printf '#include "%s"\n' "$@" > "$unit.cpp"
  # shellcheck disable=SC2086
  clang++ $flags $optimisation -c "$unit.cpp" -o "$unit.o"
}
mapfile -t coders < <(find src/{bytes,voxels,codec} -name '*.cpp' | sort)
# Loops that the compiler unrolls or vectorises make the coders larger, but not faster.
compile "-O2 -fno-unroll-loops -fno-vectorize" coders "${coders[@]}" &
compile -O2 outliers src/outliers/*.cpp
compile -Os others \
  src/stream/{field_table,foreign_bytes}.cpp \
  src/stream/frame_{decoder,description,preparation,search,size}.cpp \
  src/stream/scan_table.cpp \
  src/stream/{stream_state,version1_decoder,version1_header}.cpp \
  $package/src/*.cpp
wait $!

mkdir -p $out
# A stack that overflows ends at address 0, and traps.
clang++ --target=wasm32-wasi -mexec-model=reactor -flto "$objects"/{coders,outliers,others}.o \
  -Wl,--strip-all,--gc-sections,--stack-first,--import-memory -Wl,-z,stack-size=262144 \
  -o "$objects/codec.wasm"
mv "$objects/codec.wasm" $out/codec.wasm
viewer/node_modules/.bin/tsc -p $package
echo "$out: codec.wasm has $(stat -c %s $out/codec.wasm) bytes"
