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
package = pathlib.Path(pcl_ext.__file__).parent
assert sys.prefix in map(str, package.parents), package
for binary in (*package.glob("*.so"), package / "bin" / "pcl_ext"):
    libraries = subprocess.check_output(["ldd", binary], text=True)
    print(f"{len(installed)} packages; {binary.name} needs\n{libraries}")
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
    program = pathlib.Path(sys.prefix, "bin", "pcl_ext")
    subprocess.check_call([program, "decode", path, "-o", path.with_suffix("")])
    encoded = pcl_ext.encode_bag(path.with_suffix(""), path.with_suffix(".pcxi"), resolution=0.1)
    assert encoded.ok and encoded.frames == 10, encoded

import pcl_ext.link

# What is not in the wheel, or not installed, says so.
for call, message in (
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
