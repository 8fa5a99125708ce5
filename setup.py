# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Builds the Python package with CMake, for pip and `python3 -m build`; see python/README.md.

With SOURCE_DATE_EPOCH source distribution and wheel are the same bytes each time.
"""

import gzip
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tarfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.sdist import sdist

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # setuptools before 70.1
    from wheel.bdist_wheel import bdist_wheel
try:
    import pybind11
except ImportError:
    pybind11 = None  # CMake finds that of the system, Debian's pybind11-dev.

ROOT = pathlib.Path(__file__).resolve().parent

# The module has the codec in it.
SETTINGS = {
    "CMAKE_BUILD_TYPE": "Release",
    "BUILD_SHARED_LIBS": "OFF",
    "PCL_EXT_BUILD_PYTHON": "ON",
    "PCL_EXT_INSTALL": "OFF",
    "PCL_EXT_UNITY_BUILD": "ON",
    # Debian's archive of it cannot be a part of a module.
    "PCL_EXT_WITH_BZIP2": "OFF",
    "PCL_EXT_WITH_PCL": "OFF",
    "PCL_EXT_WITH_LINK": "OFF",
    "PCL_EXT_WITH_VIEW": "OFF",
    "Python3_EXECUTABLE": sys.executable,
}

# Libraries that are linked into the module, by CMake's names, where there is an archive of them.
ARCHIVES = {
    "ZLIB_LIBRARY": "libz.a",
    "PCL_EXT_ZSTD_LIBRARY": "libzstd.a",
    "PCL_EXT_LZ4_LIBRARY": "liblz4.a",
    "SQLite3_LIBRARY": "libsqlite3.a",
}
# Of the C library, which all of a platform "manylinux" have.
C_LIBRARY = re.compile(r"lib(c|m|pthread|dl|rt)\.so\.\d|ld-linux.*\.so\.\d")


def version():
    """The version, which stands in CMakeLists.txt."""
    return re.search(r"^  VERSION (\S+)$", (ROOT / "CMakeLists.txt").read_text(), re.M)[
        1
    ]


def dependencies():
    """Modules that were compiled with pybind11 before 2.12 cannot read arrays of numpy 2."""
    old = pybind11 is None or pybind11.version_info[:2] < (2, 12)
    return ["numpy<2"] if old else ["numpy"]


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


def linked_in():
    """Settings of CMake by which the module needs no library but the C library."""
    if not sys.platform.startswith("linux"):
        return {}
    compiler = os.environ.get("CC", "cc").split()
    settings = {
        # Without symbols of these libraries, which those of another module would replace.
        "CMAKE_MODULE_LINKER_FLAGS": "-static-libstdc++ -static-libgcc -Wl,--exclude-libs,ALL -s"
    }
    for name, archive in ARCHIVES.items():
        ask = [*compiler, f"-print-file-name={archive}"]
        path = subprocess.run(ask, stdout=subprocess.PIPE, text=True).stdout.strip()
        if os.path.isabs(path):
            settings[name] = path
    return settings


def oldest_platform(module):
    """The platform "manylinux" of the oldest C library with the symbols that a module needs.

    None if it needs other libraries, or that is not known.
    """
    if shutil.which("objdump") is None:
        return None
    ask = ["objdump", "-p", module]
    listing = subprocess.run(ask, stdout=subprocess.PIPE, text=True).stdout
    libraries = re.findall(r"^ +NEEDED +(\S+)", listing, re.M)
    symbols = re.findall(r"\bGLIBC_(\d+)\.(\d+)", listing)
    if not symbols or "GLIBC_ABI" in listing or not all(map(C_LIBRARY.fullmatch, libraries)):
        return None
    major, minor = max((int(major), int(minor)) for major, minor in symbols)
    return f"manylinux_{major}_{minor}_{os.uname().machine}"


class BuildWithCMake(build_ext):
    """Builds the module with CMake instead of the compiler."""

    def build_extension(self, extension):
        if shutil.which("cmake") is None:
            sys.exit(
                "CMake is missing; on Debian: tools/install_packages.sh codec python"
            )
        settings = {**SETTINGS, **linked_in()}
        if pybind11 is not None:
            settings["pybind11_DIR"] = pybind11.get_cmake_dir()
        build = pathlib.Path(self.build_temp).resolve()
        definitions = [f"-D{name}={value}" for name, value in settings.items()]
        tell("pcl_ext: compiling, which takes some minutes")
        run(["cmake", "-S", ROOT, "-B", build, *definitions])
        run(
            ["cmake", "--build", build, "--config", "Release", "--target", "pcl_ext_python"]
            + [
                "--parallel",
                os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count())),
            ]
        )
        module = pathlib.Path(self.get_ext_fullpath(extension.name))
        module.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(build / "python" / "pcl_ext" / module.name, module)


class WheelOfModule(bdist_wheel):
    """Names the oldest platform that the module runs on, and not that of this machine."""

    def get_tag(self):
        interpreter, abi, platform = super().get_tag()
        module = self.get_finalized_command("build_ext").get_ext_fullpath("pcl_ext._native")
        if not self.plat_name_supplied:
            platform = oldest_platform(module) or platform
        return interpreter, abi, platform


class SameSdist(sdist):
    """An archive without times, owners and modes of this machine."""

    def make_archive(self, base_name, format, root_dir=None, base_dir=None, **options):
        if format != "gztar" or "SOURCE_DATE_EPOCH" not in os.environ:
            return super().make_archive(base_name, format, root_dir, base_dir, **options)
        time = int(os.environ["SOURCE_DATE_EPOCH"])

        def without_machine(member):
            member.mtime = time
            member.uid = member.gid = 0
            member.uname = member.gname = ""
            member.mode = 0o755 if member.isdir() or member.mode & 0o100 else 0o644
            return member

        path = f"{base_name}.tar.gz"
        with gzip.GzipFile(path, "wb", mtime=time) as file:
            with tarfile.open(fileobj=file, mode="w") as archive:
                archive.add(base_dir, filter=without_machine)
        return path


os.umask(0o022)  # Modes are part of the wheel.
setup(
    version=version(),
    install_requires=dependencies(),
    packages=["pcl_ext"],
    package_dir={"": "python"},
    package_data={"pcl_ext": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("pcl_ext._native", sources=[])],
    cmdclass={
        "bdist_wheel": WheelOfModule,
        "build_ext": BuildWithCMake,
        "sdist": SameSdist,
    },
    # Not `build`, where a build by CMake may be.
    options={"build": {"build_base": "build-python"}},
)
