# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Frames are byte for byte those of the C++ class for the same clouds."""

import os
import struct
import subprocess

import numpy as np
import pytest

import pcl_ext


def stream_of(room, random, has_colours):
    """Clouds that move, with points that are left out, and an empty one."""
    clouds = []
    for frame in range(6):
        xyz = room + np.float32(0.01 * frame)
        xyz[7 * frame] = np.nan
        xyz[7 * frame + 1, 1] = np.inf
        if frame == 4:
            xyz = xyz[:0]
        count = len(xyz)
        intensity = random.integers(0, 256, count).astype(np.float32)
        colour = (random.integers(0, 256, (count, 3), dtype=np.uint8) if has_colours else None)
        clouds.append((xyz, intensity, colour))
    return clouds


def bytes_of_cpp(clouds, *arguments):
    given = b""
    for xyz, intensity, colour in clouds:
        given += struct.pack("=II", len(xyz), colour is not None)
        packed = np.zeros(len(xyz), "u4")
        if colour is not None:
            for channel in range(3):
                packed = packed << np.uint32(8) | colour[:, channel]
        points = np.zeros(len(xyz), "f4, f4, f4, f4, u4")
        for axis in range(3):
            points[f"f{axis}"] = xyz[:, axis]
        points["f3"] = intensity
        points["f4"] = packed
        given += points.tobytes()
    program = [os.environ["PCL_EXT_ENCODE_WITH_PCL"], *map(str, arguments)]
    output = subprocess.run(program, input=given, stdout=subprocess.PIPE, check=True).stdout
    frames = []
    while output:
        (size,) = struct.unpack("=I", output[:4])
        frames.append(output[4 : 4 + size])
        output = output[4 + size :]
    return frames


# Intensities beyond the scale of the published layout.
@pytest.mark.filterwarnings("ignore::pcl_ext.CompressionWarning")
@pytest.mark.parametrize("law", pcl_ext.laws())
@pytest.mark.parametrize(
    "effort, format, has_colours",
    [
        ("fast", "version1", False),
        ("balanced", "version1", False),
        ("small", "version1", True),
        ("balanced", "published", False),
    ],
)
def test_frames_are_those_of_cpp(room, random, law, effort, format, has_colours):
    clouds = stream_of(room, random, has_colours)
    expected = bytes_of_cpp(clouds, law, effort, format, 0.05, 0.25)
    pose = np.eye(4)
    pose[0, 3] = 0.25
    encoder = pcl_ext.Encoder(
        0.05,
        effort=effort,
        format=format,
        law=law,
        sensor="kinect_v2",
        sensor_pose=pose,
        i_frame_rate=4,
    )
    frames = [
        encoder.encode(xyz, intensity if law == "native" else None, colour)
        for xyz, intensity, colour in clouds
    ]
    assert [len(frame) for frame in frames] == [len(frame) for frame in expected]
    assert frames == expected
    assert len(frames) == 6
