# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Builds source distribution and wheel, installs the wheel with pip into a virtual environment
and tests it there.

Usage: install_with_pip.py FOLDER, which is made anew; the wheel is in FOLDER/source/dist.
Needs no network: the virtual environment sees the packages of the system.
"""

import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
# What MANIFEST.in puts into a source distribution, from which the wheel is built.
FILES = ("CMakeLists.txt", "LICENSE", "MANIFEST.in", "pyproject.toml", "setup.py")
FOLDERS = ("clouds", "cmake", "include", "measuring", "python", "simulator", "src", "tools")
# They are slow, and look at what lies in the source folder, as the test before has done.
OF_SOURCES = ("test_notebook.py", "test_setup.py", "test_types.py")


def main(folder):
    shutil.rmtree(folder, ignore_errors=True)
    source = folder / "source"
    source.mkdir(parents=True)
    for name in FILES:
        shutil.copy(ROOT / name, source)
    for name in FOLDERS:
        shutil.copytree(ROOT / name, source / name)
    build = [sys.executable, "-m", "build", "--no-isolation"]
    # So that ccache, if it compiles, finds what it has from builds of the source folder.
    temporary = folder / "temporary"
    temporary.mkdir()
    alike = {"TMPDIR": temporary, "CCACHE_BASEDIR": temporary, "CMAKE_GENERATOR": "Ninja"}
    subprocess.check_call(build, cwd=source, env={**os.environ, **alike})
    (wheel,) = (source / "dist").glob("*.whl")
    python = folder / "venv" / "bin" / "python"
    venv = [sys.executable, "-m", "venv", "--system-site-packages", folder / "venv"]
    subprocess.check_call(venv)
    subprocess.check_call([python, "-m", "pip", "install", "--quiet", "--no-index", wheel])
    where = "import pathlib, pcl_ext; print(pathlib.Path(pcl_ext.__file__).parent)"
    package = subprocess.check_output([python, "-c", where], cwd=folder, text=True)
    package = pathlib.Path(package.strip())
    if package.parents[3] != python.parents[1]:
        sys.exit(f"the package was found in {package}")
    subprocess.check_call([python.parent / "pcl_ext", "--version"], cwd=folder)
    subprocess.check_call([python, "-c", "import pcl_ext.link"], cwd=folder)
    tests = pathlib.Path(__file__).resolve().parent
    pytest = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", tests]
    pytest += [f"--ignore={tests / name}" for name in OF_SOURCES]
    subprocess.check_call(pytest, cwd=folder)
    assert all((package / name).exists() for name in ("py.typed", "_native.pyi"))


main(pathlib.Path(sys.argv[1]).resolve())
