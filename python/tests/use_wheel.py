# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Uses the package where there is neither compiler nor PCL; see wheel_in_clean_debian.sh."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import pcl_ext

for program in ("cc", "gcc", "g++", "clang", "cmake", "ninja", "pcl_ext"):
    assert shutil.which(program) is None, program
installed = subprocess.check_output(["dpkg-query", "-W", "-f", "${Package}\n"], text=True).split()
assert "python3-numpy" in installed
assert not [name for name in installed if re.search(r"pcl|^(g\+\+|gcc)(-\d+)?$|-dev$", name)]
module = pcl_ext._native.__file__
assert module.startswith(sys.prefix + "/"), module
libraries = subprocess.check_output(["ldd", module], text=True)
print(f"{len(installed)} packages; {pathlib.Path(module).name} needs\n{libraries}")
assert "not found" not in libraries

with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder, "cell.mcap")
    decoder, decoded = pcl_ext.Decoder(), []
    with pcl_ext.RecordingWriter(path) as writer:
        stream, encoder = writer.add_stream("/sensor"), pcl_ext.Encoder(0.05)
        for number in range(10):
            frame = encoder.encode(np.random.default_rng(number).random((5000, 3)))
            writer.append(stream, frame, 100 + number)
            decoded.append(decoder.decode(frame))
    clouds = list(pcl_ext.open(path).clouds())
    assert [time for time, _, _ in clouds] == list(range(100, 110))
    for (*_, cloud), expected in zip(clouds, decoded):
        np.testing.assert_array_equal(cloud, expected)

# What is not in the wheel, or not installed, says so.
for call, message in (
    (lambda: __import__("pcl_ext.link"), "built without libnats"),
    (lambda: pcl_ext.encode_bag("a.bag", "a.mcap"), "pcl_ext"),
    (clouds[0][2].to_pandas, "pip install pandas"),
    (clouds[0][2].to_open3d, "pip install open3d"),
    (clouds[0][2].plot, "pip install matplotlib"),
):
    try:
        call()
    except (ImportError, FileNotFoundError, pcl_ext.Error) as error:
        print(f"{type(error).__name__}: {error}")
        assert message in str(error)
    else:
        sys.exit(f"nothing is missing of what needs {message}")
