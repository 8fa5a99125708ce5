#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Writes the man page: pcl_ext.1.in with the commands and options of the program's help.
# Usage: man_page.sh PROGRAM OUTPUT
set -eu
program=$1
output=$2
template=$(dirname "$0")/pcl_ext.1.in

# The help of a command, whose text is wrapped, as roff.
command_section() {
  printf '.SS %s\n' "$1"
  "$program" "$1" --help | sed 's/\\/\\e/g; s/-/\\-/g; s/'"'"'/\\(aq/g' | awk '
    function put(text) { print (text ~ /^\./ ? "\\&" : "") text }
    NR == 1 { put($0 "."); next }
    /^Exit status/ { exit }
    /^Usage: / { print ".PP\n.B " substr($0, 8) }
    /^      / { sub(/^ +/, ""); put($0) }
    /^  [^ ]/ {
      gap = match(substr($0, 3), /  +/)
      print ".TP\n.B " (gap ? substr($0, 3, gap - 1) : substr($0, 3))
      if (gap) put(substr($0, 2 + gap + RLENGTH))
    }'
}

sed -n '/^@COMMANDS@/q; p' "$template" \
  | sed "s/@VERSION@/$("$program" --version)/" > "$output"
"$program" --help | sed -n '/^Subcommands:/,/^$/s/^  \([^ ]*\).*/\1/p' \
  | while read -r command; do command_section "$command"; done >> "$output"
sed '1,/^@COMMANDS@/d' "$template" >> "$output"
