# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Metadata that agree, and the scripts that install, build and run, with stand-ins for the commands
that change the machine."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Nothing is installed, and the user is root.
DPKG_QUERY = "exit 1"
ID = "echo 0"
# Calls are listed in $LOG. The first ones fail as often as $LOCKED says.
APT_GET = """echo "apt-get $*" | tee -a "$LOG"
if [ "$1" = -qq ] && [ "$(grep -c -- "-qq $2" "$LOG")" -le "${LOCKED:-0}" ]; then
  echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt)" >&2
  exit 100
fi
case $* in *"${BROKEN:-nothing}"*) echo "E: Unable to locate package" >&2; exit 100 ;; esac"""
CMAKE = """echo "ninja: no work to do."
mkdir -p "$HERE/build-run/tools/bin" "$HERE/build-run/demo"
touch "$HERE/build-run/demo/cell.mcap"
printf '#!/bin/sh\\necho "output of $*"\\n' > "$HERE/build-run/tools/bin/pcl_ext"
chmod +x "$HERE/build-run/tools/bin/pcl_ext" """
BUILD_VIEWER = """echo "a page" | tee -a "$LOG"
mkdir -p "$HERE/viewer/dist"
touch "$HERE/viewer/dist/viewer.html" """


# Files with this project's version, and where it stands there.
VERSIONS = {
    "package.xml": "<version>(.*)</version>",
    "debian/changelog": r"^pcl-ext \((.*)-",
    "ros/package.xml": "<version>(.*)</version>",
    "ros2/pcl_ext_ros/CMakeLists.txt": "^project.* VERSION (\\S*)",
    "ros2/pcl_ext_ros/package.xml": "<version>(.*)</version>",
    "ros2/pcl_ext_ros_common/CMakeLists.txt": "^project.* VERSION (\\S*)",
    "ros2/pcl_ext_ros_common/package.xml": "<version>(.*)</version>",
    "ros2/pcl_ext_point_cloud_transport/CMakeLists.txt": "^project.* VERSION (\\S*)",
    "ros2/pcl_ext_point_cloud_transport/package.xml": "<version>(.*)</version>",
    "viewer/package.json": '^  "version": "(.*)"',
    "viewer/codec/package.json": '^  "version": "(.*)"',
    "viewer/foxglove/package.json": '^  "version": "(.*)"',
    "CHANGELOG.md": "^## (\\S*)",
}


class Metadata(unittest.TestCase):
    def first(self, pattern, name):
        found = re.search(pattern, (ROOT / name).read_text(), re.MULTILINE)
        self.assertIsNotNone(found, name)
        return found[1]

    def test_all_files_have_the_same_version(self):
        version = self.first(r"^  VERSION (\S*)$", "CMakeLists.txt")
        for name, pattern in VERSIONS.items():
            with self.subTest(name):
                self.assertEqual(self.first(pattern, name), version)

    def test_debian_package_of_the_libraries_has_the_number_of_their_soname(self):
        major, minor, _ = self.first(r"^  VERSION (\S*)$", "CMakeLists.txt").split(".")
        package = f"libpcl-ext{major}.{minor}"
        self.assertEqual(self.first("^Package: (libpcl-ext[0-9.]+)$", "debian/control"), package)
        self.assertEqual(self.first("library,(.*)[)]$", "debian/rules"), package)

    def test_what_debian_packages_are_built_with_is_in_the_list_of_packages(self):
        needed = self.first(r"^Build-Depends:\n((?: .*\n)+)", "debian/control")
        listed = (ROOT / "tools/packages.txt").read_text().split()
        for package in re.findall(r"^ ([a-z0-9-]+)", needed, re.MULTILINE):
            # Other packages provide these two.
            if not package.startswith(("debhelper-compat", "dh-sequence")):
                self.assertIn(package, listed)


class Scripts(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="of a user "))
        self.addCleanup(shutil.rmtree, self.folder)
        self.log = self.folder / "log"
        for name in ("tools/run.sh", "tools/view.sh", "tools/install_packages.sh",
                     "tools/packages.txt", "doc/build.sh"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            shutil.copy(ROOT / name, self.folder / name)
        for name in ("viewer/page", "viewer/codec/src", "src", "include"):
            (self.folder / name).mkdir(parents=True)
        (self.folder / "doc/Doxyfile").touch()
        (self.folder / "x.pcxi").touch()
        stand_ins = {"bin/dpkg-query": DPKG_QUERY, "bin/id": ID, "bin/apt-get": APT_GET,
                     "bin/cmake": CMAKE, "bin/sleep": "", "bin/doxygen": "cat > /dev/null",
                     "bin/python3": "", "viewer/build.sh": BUILD_VIEWER}
        (self.folder / "bin").mkdir()
        for name, script in stand_ins.items():
            (self.folder / name).write_text(f"#!/bin/sh\n{script}\n")
            (self.folder / name).chmod(0o755)

    def run_script(self, *command, status=0, **variables):
        environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}",
                       "HERE": str(self.folder), "LOG": str(self.log), **variables}
        result = subprocess.run(["bash", *command], cwd=self.folder, env=environment,
                                capture_output=True, text=True)
        self.assertEqual(result.returncode, status, result.stderr)
        return result

    def calls(self, beginning):
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        return [line for line in lines if line.startswith(beginning)]

    def test_only_the_program_writes_to_the_standard_output(self):
        result = self.run_script("tools/run.sh", "info", "x.pcxi", "--json")
        self.assertEqual(result.stdout, "output of info x.pcxi --json\n")
        self.assertIn("ninja: no work to do.", result.stderr)
        (self.folder / "build-run/demo/cell.mcap").unlink()
        result = self.run_script("tools/view.sh")
        self.assertRegex(result.stdout, r"\Aoutput of view .*/cell.mcap\n\Z")

    def test_running_the_program_installs_nothing_for_tests_or_the_viewer(self):
        self.run_script("tools/run.sh", "info", "x.pcxi")
        installed = self.calls("apt-get -qq install -y")[0].split()
        self.assertIn("libcli11-dev", installed)
        self.assertFalse({"libpcl-dev", "npm", "nodejs", "libgtest-dev"} & set(installed), installed)

    def test_the_page_is_built_where_it_is_missing_or_old(self):
        self.run_script("tools/run.sh", "info", "x.pcxi")
        self.run_script("tools/run.sh", "receive", "--map", "map.ot")
        self.assertEqual(len(self.calls("a page")), 0)
        for _ in range(2):
            self.run_script("tools/run.sh", "view", "x.pcxi")
            self.assertEqual(len(self.calls("a page")), 1)
        for built, source in enumerate(("src/decoder.cpp", "include/decoder.h"), 1):
            os.utime(self.folder / "viewer/dist/viewer.html", (1, 1))
            (self.folder / source).touch()
            self.run_script("tools/run.sh", "view", "x.pcxi", "--page=mine.html")
            self.assertEqual(len(self.calls("a page")), built, "the user has a page")
            command = ("view", "x.pcxi") if built == 1 else ("receive", "--view")
            self.run_script("tools/run.sh", *command)
            self.assertEqual(len(self.calls("a page")), built + 1)
            (self.folder / source).unlink()

    def test_the_installation_waits_for_the_locks_of_apt(self):
        result = self.run_script("tools/install_packages.sh", "documentation", LOCKED="2")
        self.assertEqual(len(self.calls("apt-get -qq update")), 3)
        self.assertEqual(len(self.calls("apt-get -qq install -y")), 3)
        self.assertEqual(result.stdout.count("Waiting for another program: E: Could not get lock"
                                             " /var/lib/apt/lists/lock"), 2, result.stdout)

    def test_other_failures_of_apt_are_told_at_once(self):
        result = self.run_script("tools/install_packages.sh", "documentation", status=2,
                                 BROKEN="install -y")
        self.assertIn("apt-get install failed: E: Unable to locate package", result.stderr)
        self.assertEqual(len(self.calls("apt-get -qq install -y")), 1)

    def test_building_the_documentation_installs_doxygen(self):
        self.run_script("doc/build.sh")
        self.assertRegex(self.calls("apt-get -qq install -y")[0], r"\bdoxygen graphviz\b")


if __name__ == "__main__":
    unittest.main()
