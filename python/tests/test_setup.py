"""What `pip install .` tells, with a stand-in for CMake."""

import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

# It makes the module at once.
CMAKE = """#!/bin/sh
[ "$1" = --build ] || exit 0
mkdir -p "$2/python/pcl_ext"
touch "$2/python/pcl_ext/$MODULE"
printf '[1/8] Building\\n[2/8] Building\\n[ 50%%] Building\\n[8/8] Linking\\n'
"""


def test_progress_reaches_the_terminal(tmp_path):
    for name in ("setup.py", "pyproject.toml", "CMakeLists.txt"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / "python/pcl_ext").mkdir(parents=True)
    (tmp_path / "python/README.md").touch()
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/cmake").write_text(CMAKE)
    (tmp_path / "bin/cmake").chmod(0o755)
    suffix = subprocess.run(
        [sys.executable, "-c", "import sysconfig; print(sysconfig.get_config_var('EXT_SUFFIX'))"],
        check=True, capture_output=True, text=True).stdout.strip()
    environment = {**os.environ, "MODULE": f"_native{suffix}",
                   "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}"}
    # As pip runs it: the output goes elsewhere, but there is a terminal.
    command = f"{sys.executable} setup.py build_ext > log 2>&1"
    subprocess.run(["script", "-qec", command, "typescript"], cwd=tmp_path, env=environment,
                   check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    told = (tmp_path / "typescript").read_text()
    assert [line for line in told.splitlines() if line.startswith("pcl_ext: ")] == [
        "pcl_ext: compiling, which takes some minutes",
        "pcl_ext: 25 % compiled",
        "pcl_ext: 50 % compiled",
        "pcl_ext: 100 % compiled",
    ]
    assert "[2/8] Building" in (tmp_path / "log").read_text()
