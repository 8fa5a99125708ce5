#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Installs what is missing, makes the Debian source package of the last commit, builds the binary
# packages of it, for the distribution that this runs on, and checks all with lintian. They lie in
# build-package/packages afterwards, and are the same bytes each time.
# Usage: bash tools/package.sh
set -euo pipefail
case ${1:-} in
  --help | -h)
    sed -n '4,7s/^# //p' "$0"
    exit 0
    ;;
esac
cd "$(dirname "$0")/.."
root=$PWD
version=$(sed -n 's/^  VERSION \(.*\)$/\1/p' CMakeLists.txt)
packages=$root/build-package/packages
source=$root/build-package/pcl-ext-$version

if [ -n "$(git status --porcelain)" ]; then
  echo "package: the clone has changes that are not committed" >&2
  exit 1
fi
bash tools/install_packages.sh build package viewer
umask 022
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
rm -rf build-package
mkdir -p "$packages" "$source/page"
git -c tar.umask=0022 archive --format=tar --prefix="pcl_ext-$version/" HEAD | gzip -9 -n > \
  "$packages/pcl-ext_$version.orig.tar.gz"
tar -xzf "$packages/pcl-ext_$version.orig.tar.gz" -C "$source" --strip-components=1
bash viewer/build.sh "$source/page/viewer.html"
tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" \
  -C "$source" -c page | gzip -9 -n > "$packages/pcl-ext_$version.orig-page.tar.gz"

# What is built is what is in the source package.
cd "$packages"
dpkg-source -b "$source"
rm -r "$source"
dpkg-source -x ./*.dsc "$source"
cd "$source"
log=$root/build-package/build.log
if ! DEB_BUILD_OPTIONS="noautodbgsym parallel=${PCL_EXT_JOBS:-2}" \
  dpkg-buildpackage -b -us -uc > "$log" 2>&1; then
  tail -n 60 "$log"
  exit 1
fi
mv ../*.deb "$packages"
# Root may run it, too, as a container has no one else.
lintian --allow-root --fail-on error,warning "$packages"/*.dsc "$packages"/*.deb
ls -l "$packages"
