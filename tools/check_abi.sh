#!/usr/bin/env bash
# Writes what shared libraries export, and compares it with that of the last release.
# Usage: bash tools/check_abi.sh LIBRARIES OUTPUT [PREVIOUS]
#   LIBRARIES  folder with libpcl_ext*.so
#   OUTPUT     folder for a file LIBRARY.symbols of each, as abidw writes it, and for abi.txt
#   PREVIOUS   folder with the .symbols of the last release
# Exit status 1 if a symbol is gone or has changed, unless the number of the ABI in the libraries'
# names is another one: CONTRIBUTING.md, "Versions", has what each number promises.
set -euo pipefail
libraries=$1 out=$2 previous=${3:-}
broken=no
: > "$out/abi.txt"
soname() { sed -n "s/.*soname='\([^']*\)'.*/\1/p" "$1" | head -n 1; }
for library in "$libraries"/libpcl_ext*.so; do
  name=$(basename "$library" .so)
  # Without types, which need debug information: names, versions and sizes.
  abidw --no-corpus-path --no-comp-dir-path --out-file "$out/$name.symbols" "$library"
  before=$previous/$name.symbols
  if [ -z "$previous" ] || ! [ -e "$before" ]; then
    echo "$name: nothing to compare with" >> "$out/abi.txt"
    continue
  fi
  # Bits of its status: 1 and 2 it failed, 4 different, 8 incompatible.
  status=0
  abidiff "$before" "$out/$name.symbols" > "$out/difference" 2>&1 || status=$?
  if [ $status -eq 0 ]; then
    echo "$name: compatible" >> "$out/abi.txt"
  elif [ $((status & 11)) -eq 0 ]; then
    echo "$name: compatible, with more symbols" >> "$out/abi.txt"
  elif [ "$(soname "$before")" != "$(soname "$out/$name.symbols")" ]; then
    echo "$name: different, and so is its SONAME" >> "$out/abi.txt"
  else
    { echo "$name: INCOMPATIBLE"; cat "$out/difference"; } >> "$out/abi.txt"
    broken=yes
  fi
done
for before in ${previous:+"$previous"/*.symbols}; do
  [ -e "$out/$(basename "$before")" ] && continue
  echo "$(basename "$before" .symbols): GONE" >> "$out/abi.txt"
  broken=yes
done
rm -f "$out/difference"
cat "$out/abi.txt"
[ "$broken" = no ]
