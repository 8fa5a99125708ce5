#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Writes what shared libraries export, with the types of the public headers, and compares it with
# that of the last release.
# Usage: bash tools/check_abi.sh LIBRARIES OUTPUT [PREVIOUS]
#   LIBRARIES  folder with libpcl_ext*.so that have debug information
#   OUTPUT     folder for a file LIBRARY.abi.xz of each, as abidw writes it, and for abi.txt
#   PREVIOUS   folder with the .abi.xz of the last release
# Exit status 1 if a symbol or a public type is gone or has changed, unless the number of the ABI in
# the libraries' names is another one; also if a library is gone, has no types or cannot be compared.
# CONTRIBUTING.md, "Versions", has what each number promises.
set -euo pipefail
if [ $# -lt 2 ]; then
  sed -n '4,/^set /s/^# \{0,1\}//p' "$0" | grep -v '^set ' >&2
  exit 2
fi
libraries=$1 out=$2 previous=${3:-}
headers=$(dirname "$0")/../include/pcl_ext
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
broken=no
: > "$out/abi.txt"
soname() { sed -n "s/.*soname='\([^']*\)'.*/\1/p" "$1" | head -n 1; }
for library in "$libraries"/libpcl_ext*.so; do
  name=$(basename "$library" .so)
  # Of types only what a change of an exported function or a public class shows.
  abidw --no-corpus-path --no-comp-dir-path --no-show-locs --no-parameter-names \
    --exported-interfaces-only --headers-dir "$headers" --drop-private-types \
    --out-file "$work/now" "$library"
  grep -q '<class-decl' "$work/now" || { echo "check_abi: $library has no types" >&2; exit 1; }
  xz -c "$work/now" > "$out/$name.abi.xz"
  if [ -z "$previous" ] || ! [ -e "$previous/$name.abi.xz" ]; then
    echo "$name: nothing to compare with" >> "$out/abi.txt"
    continue
  fi
  xz -dc "$previous/$name.abi.xz" > "$work/before"
  # abidiff also returns another status than 0 if it cannot compare.
  if abidiff --no-added-syms "$work/before" "$work/now" > "$work/difference" 2>&1; then
    echo "$name: compatible" >> "$out/abi.txt"
  elif [ "$(soname "$work/before")" != "$(soname "$work/now")" ]; then
    echo "$name: different, and so is its SONAME" >> "$out/abi.txt"
  else
    { echo "$name: INCOMPATIBLE"; cat "$work/difference"; } >> "$out/abi.txt"
    broken=yes
  fi
done
for before in ${previous:+"$previous"/*.abi.xz}; do
  [ -e "$out/$(basename "$before")" ] && continue
  echo "$(basename "$before" .abi.xz): GONE" >> "$out/abi.txt"
  broken=yes
done
cat "$out/abi.txt"
[ "$broken" = no ]
