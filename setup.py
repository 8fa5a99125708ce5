# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Builds the Python package with CMake, for pip and `python3 -m build`; see python/README.md.

CMAKE_ARGS may have arguments for CMake. With SOURCE_DATE_EPOCH source distribution and wheel are
the same bytes each time.
"""

import gzip
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
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

# The modules and the program have the codec in them.
SETTINGS = {
    "CMAKE_BUILD_TYPE": "Release",
    "BUILD_SHARED_LIBS": "OFF",
    "PCL_EXT_BUILD_PYTHON": "ON",
    "PCL_EXT_BUILD_TOOLS": "ON",
    "PCL_EXT_INSTALL": "OFF",
    "PCL_EXT_UNITY_BUILD": "ON",
    "PCL_EXT_WITH_PCL": "OFF",
    "Python3_EXECUTABLE": sys.executable,
}

# Libraries that are linked in, by CMake's names, where there is an archive of them.
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
    """Settings of CMake by which modules and program need no libraries but those of C that
    have no archive, which they find in the package."""
    if not sys.platform.startswith("linux"):
        return {}
    compiler = os.environ.get("CC", "cc").split()
    # Without symbols of these libraries, which those of another module would replace. The old
    # tag of paths holds for what a library needs in turn, too.
    flags = "-static-libstdc++ -static-libgcc -Wl,--exclude-libs,ALL -s -Wl,--disable-new-dtags"
    settings = {
        "CMAKE_MODULE_LINKER_FLAGS": flags,
        "CMAKE_EXE_LINKER_FLAGS": flags,
        "CMAKE_BUILD_RPATH": "$ORIGIN/libs;$ORIGIN/../libs",
    }
    for name, archive in ARCHIVES.items():
        ask = [*compiler, f"-print-file-name={archive}"]
        path = subprocess.run(ask, stdout=subprocess.PIPE, text=True).stdout.strip()
        if os.path.isabs(path):
            settings[name] = path
    return settings


def copy_libraries(binaries, folder):
    """Copies the libraries that binaries need, but those of the C library, with what Debian
    says of their licences."""
    for binary in binaries:
        listing = subprocess.run(["ldd", binary], stdout=subprocess.PIPE, text=True).stdout
        for name, path in re.findall(r"^\s*(\S+) => (/\S+)", listing, re.M):
            if C_LIBRARY.fullmatch(name) or (folder / name).exists():
                continue
            folder.mkdir(exist_ok=True)
            shutil.copy(path, folder / name)
            if shutil.which("dpkg-query") is None:
                continue
            ask = ["dpkg-query", "-S", "*/" + os.path.basename(os.path.realpath(path))]
            owner = subprocess.run(ask, stdout=subprocess.PIPE, text=True).stdout
            licence = pathlib.Path("/usr/share/doc", owner.partition(":")[0], "copyright")
            if owner and licence.exists():
                shutil.copy(licence, folder / f"{name}.copyright")


def oldest_platform(package):
    """The platform "manylinux" of the oldest C library with the symbols that a package needs.

    None if it needs libraries that it has not, or that is not known.
    """
    if shutil.which("objdump") is None:
        return None
    ask = ["objdump", "-p", *package.rglob("*.so*"), *package.glob("bin/*")]
    listing = subprocess.run(
        ask, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ).stdout
    libraries = set(re.findall(r"^ +NEEDED +(\S+)", listing, re.M))
    libraries -= {path.name for path in package.glob("libs/*")}
    symbols = re.findall(r"\bGLIBC_(\d+)\.(\d+)", listing)
    if not symbols or "GLIBC_ABI" in listing or not all(map(C_LIBRARY.fullmatch, libraries)):
        return None
    major, minor = max((int(major), int(minor)) for major, minor in symbols)
    return f"manylinux_{major}_{minor}_{os.uname().machine}"


class BuildWithCMake(build_ext):
    """Builds the modules and the program with CMake instead of the compiler."""

    def build_extension(self, extension):
        if shutil.which("cmake") is None:
            sys.exit(
                "CMake is missing; on Debian: tools/install_packages.sh program python"
            )
        settings = {**SETTINGS, **linked_in()}
        if pybind11 is not None:
            settings["pybind11_DIR"] = pybind11.get_cmake_dir()
        build = pathlib.Path(self.build_temp).resolve()
        definitions = [f"-D{name}={value}" for name, value in settings.items()]
        definitions += shlex.split(os.environ.get("CMAKE_ARGS", ""))
        tell("pcl_ext: compiling, which takes some minutes")
        configure = ["cmake", "-S", ROOT, "-B", build, *definitions]
        try:
            run(configure)
        except subprocess.CalledProcessError:
            tell("pcl_ext: without the program, as CMake has not found all that it needs")
            run([*configure, "-DPCL_EXT_BUILD_TOOLS=OFF"])
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count()))
        run(["cmake", "--build", build, "--config", "Release", "--parallel", jobs])
        package = pathlib.Path(self.get_ext_fullpath(extension.name)).parent
        (package / "bin").mkdir(parents=True, exist_ok=True)
        binaries = []
        for path in [
            *(build / "python" / "pcl_ext").glob("_*" + sysconfig.get_config_var("EXT_SUFFIX")),
            *(build / "tools").glob("bin/pcl_ext*"),
        ]:
            folder = package / "bin" if path.parent.name == "bin" else package
            binaries.append(pathlib.Path(shutil.copy(path, folder)))
        page = ROOT / "viewer" / "dist" / "viewer.html"
        if page.exists():
            (package / "share" / "pcl_ext").mkdir(parents=True, exist_ok=True)
            shutil.copy(page, package / "share" / "pcl_ext")
        if sys.platform.startswith("linux"):
            copy_libraries(binaries, package / "libs")


class WheelOfModule(bdist_wheel):
    """Names the oldest platform that the package runs on, and not that of this machine."""

    def get_tag(self):
        interpreter, abi, platform = super().get_tag()
        module = self.get_finalized_command("build_ext").get_ext_fullpath("pcl_ext._native")
        if not self.plat_name_supplied:
            platform = oldest_platform(pathlib.Path(module).parent) or platform
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
    options={"build": {"build_base": "build-python", "build_temp": "build-python"}},
)
