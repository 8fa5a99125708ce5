# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks that object files compiled with AVX2 hand no such function to other files.

Of inline functions and templates of the same name the linker keeps one, from any object
file. So every function that uses the registers of AVX has to be an instantiation with
Avx2Lanes, which no other file has, or a specialization for it.

Usage: check_avx2_objects.py OBJECT ...
"""

import re
import subprocess
import sys


def functions(path):
    """Yields the name of each function of an object file, and its instructions."""
    listing = subprocess.run(
        ["objdump", "--disassemble", "--no-show-raw-insn", path],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    for part in re.split(r"^(?=[0-9a-f]+ <)", listing, flags=re.M)[1:]:
        name = re.match(r"[0-9a-f]+ <(.+)>:", part)[1]
        yield name, part


def main(paths):
    avx_functions = 0
    failed = False
    for path in paths:
        for name, instructions in functions(path):
            if not re.search(r"\tv[a-z0-9]+ +.*%[xy]mm|%ymm|\tvzero", instructions):
                continue
            avx_functions += 1
            if "Avx2" not in name:
                print(f"{path}: {name} needs AVX, and may replace that of another file")
                failed = True
    print(f"{avx_functions} functions of {len(paths)} files need AVX")
    return 1 if failed or avx_functions == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
