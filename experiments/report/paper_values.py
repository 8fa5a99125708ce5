# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Values that the paper reports, to stand beside what is measured.

Source: J. Dybedal, A. Aalerud, G. Hovland, "Embedded Processing and Compression of 3D Sensor
Data for Large Scale Industrial Environments", Sensors 2019, 19(3), 636 (CC BY 4.0). A pair is
mean and standard deviation. KiB and MiB are 1024 and 1024^2 bytes, MB is 10^6 bytes. The paper
calls a decoded voxel a point.
"""

FRAMES = 1000  # of each experiment, section 3

# Section 3.1, Table 2: one Kinect V2, which of the six is not stated.
CROPPING = {
    "points": 217088,
    "KiB": 3392,
    "cropped points": (37108, 293),
    "cropped KiB": (579.8, 4.6),
    "ratio": (5.85, 0.05),
}

# Section 3.2, Tables 3 and 4, by voxel edge in cm: the point count as intensity. Table 4 is of
# another recording than Tables 2 and 3.
COMPRESSION = {
    4: {
        "cropped points": (37108, 293),
        "cropped KiB": (579.8, 4.6),
        "voxels": (17771, 118),
        "KiB": (14.31, 0.20),
        "bytes per voxel": (0.82, 0.01),
        "ratio": (40.5, 0.5),
        "points per voxel": 2.09,  # in the text
    },
    2: {
        "cropped points": (37574, 313),
        "cropped KiB": (587.1, 4.9),
        "voxels": (33321, 243),
        "KiB": (26.08, 0.17),  # 26.06 in the text
        "bytes per voxel": (0.80, 0.01),
        "ratio": (22.5, 0.1),
        "points per voxel": None,
    },
}

# Section 3.2, in the text: mean size of a depth image.
DEPTH_IMAGE = {"raw MB": 0.43, "compressed MB": 0.22}

# Section 3.3, Table 5, 4 cm. Compression: one core of a Jetson TX2's Arm A57; decompression:
# one core of an Intel Core i5-2500. Memory is that of the whole process.
PERFORMANCE = {
    "compression at the highest rate": {
        "frames per second": 26.9, "KiB/s": 384.9, "cycle ms": (36, 4),
        "processor % of a core": 100, "memory MiB": 63.5},
    "compression at 20 Hz": {
        "frames per second": 20.0, "KiB/s": 286.2, "cycle ms": (36, 4),
        "processor % of a core": 80, "memory MiB": 60},
    "decompression at 20 Hz": {
        "frames per second": 20.0, "KiB/s": 286.2, "cycle ms": (13, 2),
        "processor % of a core": 14, "memory MiB": 35.7},
    # In the text: the streams of all six Kinect V2.
    "decompression of all sensors": {
        "frames per second": None, "KiB/s": None, "cycle ms": None,
        "processor % of a core": 65, "memory MiB": 51.3},
}

# Section 4.
UNCOMPRESSED_KIB_PER_SECOND = 11596  # cropped, 20 Hz
SENSORS_IN_A_GIGABIT = 440

# Section 2.5.3: depth from which on one point fills a voxel's face, 4 cm, metres.
CUT_OFF_DEPTH = 14.57

# Figures 10 and 11: decoded voxels below these intensities (0 to 255) are removed.
FIGURE_10_COUNT = 2
FIGURE_11 = {"count": 2, "linear": 64, "quadratic": 64}
