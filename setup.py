"""Builds the Python package with CMake, for `pip install .`; see python/README.md."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent

# The module has the codec in it and needs no library beside it but zlib.
SETTINGS = {
    "CMAKE_BUILD_TYPE": "Release",
    "BUILD_SHARED_LIBS": "OFF",
    "PCL_EXT_BUILD_PYTHON": "ON",
    "PCL_EXT_INSTALL": "OFF",
    "PCL_EXT_UNITY_BUILD": "ON",
    "PCL_EXT_WITH_PCL": "OFF",
    "PCL_EXT_WITH_LINK": "OFF",
    "PCL_EXT_WITH_VIEW": "OFF",
    "Python3_EXECUTABLE": sys.executable,
}


def version():
    """The version, which stands in CMakeLists.txt."""
    return re.search(r"^  VERSION (\S+)$", (ROOT / "CMakeLists.txt").read_text(), re.M)[
        1
    ]


def tell(text):
    """Prints a line, and on the terminal, too, as pip shows what is printed with -v only."""
    print(text, flush=True)
    if sys.stdout.isatty():
        return
    try:
        with open("/dev/tty", "w") as terminal:
            print(text, file=terminal)
    except OSError:
        pass  # There is no terminal.


def run(command):
    """Runs a step of the build, and tells each quarter of it that is done."""
    print(shlex.join(map(str, command)), flush=True)
    told = 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, errors="replace") as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            # Of ninja, and of make.
            if found := re.match(r"\[ *(?:(\d+)/(\d+)|(\d+)%)\]", line):
                done, total, percent = found.groups()
                percent = int(percent or 100 * int(done) // int(total))
                if percent >= told + 25:
                    told = percent // 25 * 25
                    tell(f"pcl_ext: {told} % compiled")
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)


class BuildWithCMake(build_ext):
    """Builds the module with CMake instead of the compiler."""

    def build_extension(self, extension):
        if shutil.which("cmake") is None:
            sys.exit(
                "CMake is missing; on Debian: tools/install_packages.sh codec python"
            )
        settings = dict(SETTINGS)
        try:
            import pybind11

            settings["pybind11_DIR"] = pybind11.get_cmake_dir()
        except ImportError:
            pass  # CMake finds that of the system, Debian's pybind11-dev.
        build = pathlib.Path(self.build_temp).resolve()
        definitions = [f"-D{name}={value}" for name, value in settings.items()]
        tell("pcl_ext: compiling, which takes some minutes")
        run(["cmake", "-S", ROOT, "-B", build, *definitions])
        run(
            ["cmake", "--build", build, "--target", "pcl_ext_python"]
            + [
                "--parallel",
                os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count())),
            ]
        )
        module = pathlib.Path(self.get_ext_fullpath(extension.name))
        module.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python" / "pcl_ext" / module.name, module)


setup(
    version=version(),
    packages=["pcl_ext"],
    package_dir={"": "python"},
    package_data={"pcl_ext": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("pcl_ext._native", sources=[])],
    cmdclass={"build_ext": BuildWithCMake},
    # Not `build`, where a build by CMake may be.
    options={"build": {"build_base": "build-python"}},
)
