# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What `pip install .` tells and `python3 -m build` makes, with a stand-in for CMake."""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# It makes the module at once.
CMAKE = """#!/bin/sh
[ "$1" = --build ] || exit 0
mkdir -p "$2/python/pcl_ext"
touch "$2/python/pcl_ext/$MODULE"
printf '[1/8] Building\\n[2/8] Building\\n[ 50%%] Building\\n[8/8] Linking\\n'
"""


@pytest.fixture
def source(tmp_path):
    """A function that makes a source whose module is an empty file, and its environment."""

    def make(name):
        folder = tmp_path / name
        (folder / "python/pcl_ext").mkdir(parents=True)
        for file in ("setup.py", "pyproject.toml", "CMakeLists.txt", "MANIFEST.in", "LICENSE"):
            shutil.copy(ROOT / file, folder)
        (folder / "python/README.md").touch()
        (folder / "python/pcl_ext/__init__.py").touch()
        (folder / "bin").mkdir()
        (folder / "bin/cmake").write_text(CMAKE)
        (folder / "bin/cmake").chmod(0o755)
        module = f"_native{sysconfig.get_config_var('EXT_SUFFIX')}"
        path = f"{folder / 'bin'}:{os.environ['PATH']}"
        return folder, {**os.environ, "MODULE": module, "PATH": path}

    return make


def test_progress_reaches_the_terminal(source):
    folder, environment = source("source")
    # As pip runs it: the output goes elsewhere, but there is a terminal.
    command = f"{sys.executable} setup.py build_ext > log 2>&1"
    subprocess.run(["script", "-qec", command, "typescript"], cwd=folder, env=environment,
                   check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    told = (folder / "typescript").read_text()
    assert [line for line in told.splitlines() if line.startswith("pcl_ext: ")] == [
        "pcl_ext: compiling, which takes some minutes",
        "pcl_ext: 25 % compiled",
        "pcl_ext: 50 % compiled",
        "pcl_ext: 100 % compiled",
    ]
    assert "[2/8] Building" in (folder / "log").read_text()


def test_source_distribution_and_wheel_are_the_same_bytes_each_time(source):
    made = []
    for name, umask in (("first", 0o022), ("second", 0o077)):
        folder, environment = source(name)
        for path in folder.rglob("*"):
            os.utime(path, (1e9 + umask, 1e9 + umask))
            if umask == 0o077:
                path.chmod(path.stat().st_mode & 0o700)
        environment["SOURCE_DATE_EPOCH"] = "1700000000"
        build = [sys.executable, "-m", "build", "--no-isolation"]
        subprocess.run(build, cwd=folder, env=environment, check=True, umask=umask)
        files = sorted((folder / "dist").iterdir())
        assert [file.suffix for file in files] == [".whl", ".gz"]
        # What the module needs is not known, so the wheel is for this machine.
        platform = sysconfig.get_platform().replace("-", "_")
        assert files[0].name.endswith(f"-{platform}.whl")
        made.append([hashlib.sha256(file.read_bytes()).hexdigest() for file in files])
    assert made[0] == made[1]
