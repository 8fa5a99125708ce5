# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Checks where an object file has the functions of the class with PCL's interface from.

Usage: check_instances.py (library|program) OBJECT ...
With `library` the files define none of them, with `program` each defines its own, and
those of the octree.
"""

import re
import subprocess
import sys


def own_functions(path):
    """The names of the functions of templates that an object file defines."""
    listing = subprocess.run(
        ["nm", "--demangle", "--defined-only", path],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    return re.findall(r"^[0-9a-f]+ W (.+)$", listing, flags=re.M)


def main(source, paths):
    failed = not paths
    for path in paths:
        functions = own_functions(path)
        of_class = [
            name
            for name in functions
            if re.match(r"pcl_ext::\w+::io::OctreePointCloudIntensityCompression<", name)
        ]
        of_octree = [
            name for name in functions if "OctreePointCloud<" in name and "::addPoint" in name
        ]
        print(f"{path} defines {len(of_class)} functions of the class")
        if source == "library":
            failed |= bool(of_class or of_octree)
        else:
            failed |= not of_class or not of_octree
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
