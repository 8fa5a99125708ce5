#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Makes what a release consists of, from a clone without changes, in build-release-files:
#   pcl_ext-VERSION.tar.gz       the source, the same bytes each time
#   debian/                      Debian source package (.dsc), and of it packages for the
#                                distribution that this runs on
#   pcl_ext-VERSION-*.whl, pcl_ext-VERSION.tar.gz in python/: wheel and source distribution
#   pcl_ext-codec-*.tgz          the codec in WebAssembly for npm
#   viewer.html, pcl_ext-*.foxe  the viewer's page; the extension for Foxglove and Lichtblick
#   abi/                         what the shared libraries export; abi.txt: what has changed
#   contents.spdx.json           every file of the source, and what is compiled into the others
#   SHA256SUMS
# Packages of Debian and npm are fetched once; later runs on the machine, also from another clone,
# need no network.
# Usage, as root or where the packages are installed: bash tools/release.sh PREVIOUS | --first
#   PREVIOUS   the folder abi of the last release, which this one must not break
#   --first    there is none
# Who gets a release checks it with: sha256sum --check SHA256SUMS
set -euo pipefail
case ${1:-} in
  --help | -h)
    sed -n '4,/^set /s/^# \{0,1\}//p' "$0" | grep -v '^set '
    exit 0
    ;;
esac
root=$(cd "$(dirname "$0")/.." && pwd)
previous=
case ${1:-} in
  --first) ;;
  '')
    echo "release: name the folder abi of the last release, or --first; see --help" >&2
    exit 2
    ;;
  *)
    previous=$(cd "$1" && pwd)
    ls "$previous"/*.abi.xz > /dev/null
    ;;
esac
cd "$root"
version=$(sed -n 's/^  VERSION \(.*\)$/\1/p' CMakeLists.txt)
out=$root/build-release-files
if [ -n "$(git status --porcelain)" ]; then
  echo "release: the clone has changes that are not committed" >&2
  exit 1
fi
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
bash tools/install_packages.sh build program package viewer python release
rm -rf "$out"
mkdir -p "$out/python"

bash tools/package.sh
cp -r build-package/packages "$out/debian"
# The source package's first archive is that of the release. Made again it must be the same bytes.
cp "$out/debian/pcl-ext_$version.orig.tar.gz" "$out/pcl_ext-$version.tar.gz"
git -c tar.umask=0022 archive --format=tar --prefix="pcl_ext-$version/" HEAD | gzip -9 -n |
  cmp - "$out/pcl_ext-$version.tar.gz"

# Of a copy of the source, as setuptools leaves files there.
mkdir build-release-files/source
tar -xzf "$out/pcl_ext-$version.tar.gz" -C "$out/source" --strip-components=1
(cd "$out/source" && /usr/bin/python3 -m build --no-isolation --outdir "$out/python" > "$out/python.log") ||
  { cat "$out/python.log"; exit 1; }
rm -rf "$out/source" "$out/python.log"

tar -xOf "$out"/debian/*.orig-page.tar.gz page/viewer.html > "$out/viewer.html"
npm pack ./viewer/codec --pack-destination "$out" --silent > /dev/null
npm --prefix viewer/foxglove run --silent build
cp viewer/foxglove/dist/*.foxe "$out"

mkdir "$out/abi"
bash tools/check_abi.sh build-package/pcl-ext-*/obj-*/src "$out/abi" ${previous:+"$previous"}
python3 tools/list_contents.py "$version" "$out"
(cd "$out" && find . -type f ! -name SHA256SUMS -printf '%P\n' | LC_ALL=C sort | xargs sha256sum > SHA256SUMS)
ls -lR "$out"
# What no script can decide.
if grep -q "^## $version (unreleased)" CHANGELOG.md; then
  echo "release: CHANGELOG.md says that $version is unreleased: this is a trial"
fi
if ! git tag --points-at HEAD | grep -q .; then
  echo "release: the commit has no tag yet"
fi
