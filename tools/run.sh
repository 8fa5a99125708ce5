#!/bin/sh
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, builds, and runs the program pcl_ext.
# Usage: bash tools/run.sh [COMMAND options]
#   encode IN... -o OUT   clouds of files or a bag -> a recording
#   decode IN -o OUT      a recording -> PCD or PLY files, or a bag of clouds
#   info IN...            what is in recordings
#   verify IN...          decodes all frames, and tells which are lost
#   cut IN -o OUT         a part of a recording
#   merge IN... -o OUT    the streams of several recordings
#   view IN | --cell      a recording, or the robot cell live, in a browser
#   send IN               streams to a site, over a NATS server
#   receive               the streams of a site: to record, show, merge or map them
#   keep                  makes the server keep the frames of a site
#   advise IN...          which voxel edge and effort suit clouds
#   benchmark [IN...]     how long frames take on this machine
#   demo                  frames of a simulated robot cell through all of it, into out/
# Without arguments: demo --overwrite. After the first run COMMAND --help lists the options.
# The first run takes about 2.5 minutes on a bare Debian 12 with two cores: it installs 96
# packages, no PCL among them, and builds in build-run (0.9 GB in all). Later runs take seconds.
# The first view builds the viewer's page, too, for which it installs more (0.3 GB).
# Only what pcl_ext prints goes to the standard output.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
# A folder of its own, so that a build by hand in build/ is not disturbed.
build=$root/build-run
program=$build/tools/bin/pcl_ext

[ $# -gt 0 ] || set -- demo --overwrite

case " $* " in
  *" --help "* | *" -h "*)
    if [ -x "$program" ]; then exec "$program" "$@"; fi
    sed -n '4,/^set /s/^# //p' "$0"
    exit 0
    ;;
esac

# Before the packages and the build, which take minutes.
case $1 in
  encode | decode | info | verify | cut | merge | view | send | receive | keep | advise | benchmark | demo) ;;
  --version) ;;
  *)
    echo "There is no command '$1'; see bash tools/run.sh --help" >&2
    exit 2
    ;;
esac
# Its inputs come first; standard input and patterns are left to the program.
is_command=yes
for argument; do
  case $is_command$argument in
    yes*) is_command=no ;;
    no-?*) break ;;
    no- | no*[*?[]*) ;;
    *)
      if [ ! -e "$argument" ]; then
        echo "There is no '$argument'" >&2
        exit 1
      fi
      ;;
  esac
done

# Only what the program prints goes to the standard output: it may be frames or JSON.
exec 3>&1 >&2
bash "$root/tools/install_packages.sh" program
[ -x "$program" ] || echo "Building in $build; this takes a few minutes the first time"
cmake -S "$root" -B "$build" -G Ninja -DPCL_EXT_WITH_PCL=OFF -DPCL_EXT_BUILD_TOOLS=ON \
  -DPCL_EXT_UNITY_BUILD=ON \
  ${PCL_EXT_CMAKE_ARGUMENTS:-} > /dev/null
cmake --build "$build" --target pcl_ext_program -j "${PCL_EXT_JOBS:-2}"
case "$1 $*" in
  "view "*" --page"* | "receive "*" --page"*) ;; # the user has one
  "view "* | "receive "*" --view"*)
    page=$root/viewer/dist/viewer.html
    if ! [ -e "$page" ] ||
      [ -n "$(find "$root/viewer/page" "$root/viewer/codec/src" "$root/src" "$root/include" \
        -type f -newer "$page" -print -quit)" ]; then
      echo "Building the viewer's page"
      bash "$root/viewer/build.sh"
    fi
    ;;
esac
export PCL_EXT_COMMAND="bash $0" # what the demonstration tells to call
exec "$program" "$@" >&3 3>&-
