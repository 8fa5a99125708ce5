# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks where an object file has the functions of the class and its octree from.

Usage: check_instances.py (library|program) OBJECT ...
With `library` the files define none of them, with `program` each defines its own.
"""

import subprocess
import sys

OF_CLASS = ("::OctreePointCloudIntensityCompression<", " pcl::octree::Octree")


def own_functions(path):
    """The names of functions that an object file defines."""
    listing = subprocess.run(
        ["nm", "--demangle", "--defined-only", path], check=True, capture_output=True, text=True
    ).stdout
    functions = (line.split(" ", 2)[2] for line in listing.splitlines() if " W " in line)
    return [name for name in functions if any(of in f" {name}" for of in OF_CLASS)]


def main(source, paths):
    failed = False
    for path in paths:
        functions = own_functions(path)
        print(f"{path} defines {len(functions)} functions of the class and its octree")
        if source == "library":
            failed |= bool(functions)
            print("\n".join(functions[:5]))
        else:
            failed |= not any("::encodePointCloud(" in name for name in functions)
            failed |= not any(name.startswith("pcl::octree::OctreeP") for name in functions)
    return 1 if failed or not paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
