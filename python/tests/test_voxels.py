# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What is decoded is what numpy computes from the points."""

import numpy as np
import pytest

import pcl_ext


def voxels_of(xyz, resolution):
    """Lattice indices of all occupied voxels, and of each finite point its voxel."""
    finite = np.isfinite(xyz).all(axis=1)
    lattice = np.floor(xyz[finite].astype(float) / resolution).astype(int)
    voxels, index = np.unique(lattice, axis=0, return_inverse=True)
    return voxels, np.ravel(index)


def decoded_by_lattice(cloud, resolution):
    """The points of a decoded cloud by their voxel, which each must be the centre of."""
    centres = pcl_ext.positions(cloud).astype(float)
    lattice = np.floor(centres / resolution).astype(int)
    # A coordinate near 3 m is a float with steps of 2.4e-7 m.
    assert np.abs(centres - (lattice + 0.5) * resolution).max() < 2e-7
    order = np.lexsort(lattice.T[::-1])
    return lattice[order], cloud[order]


def code(cloud, resolution, **settings):
    arguments = cloud if isinstance(cloud, tuple) else (cloud,)
    frame = pcl_ext.Encoder(resolution, **settings).encode(*arguments)
    return pcl_ext.Decoder().decode(frame)


def test_count_is_the_number_of_points(room):
    room[5] = np.nan
    room[6, 1] = -np.inf
    voxels, index = voxels_of(room, 0.04)
    lattice, cloud = decoded_by_lattice(code(room, 0.04, law="count"), 0.04)
    np.testing.assert_array_equal(lattice, voxels)
    np.testing.assert_array_equal(cloud["intensity"], np.bincount(index))


def test_a_pose_for_each_cloud(room):
    pose = np.eye(4)
    pose[2, 3] = -1.0
    fixed = pcl_ext.Encoder(law="linear", sensor="kinect_v2", sensor_pose=pose)
    moving = pcl_ext.Encoder(law="linear", sensor="kinect_v2")
    still = pcl_ext.Encoder(law="linear", sensor="kinect_v2")
    frame = fixed.encode(room)
    assert moving.encode(room, sensor_pose=pose) == frame
    assert still.encode(room) != frame


def test_colours_are_means(room, random):
    colour = random.integers(0, 256, (len(room), 3), dtype=np.uint8)
    voxels, index = voxels_of(room, 0.1)
    decoded = code((room, None, colour), 0.1, colour_bits=8)
    assert decoded.dtype.names == ("x", "y", "z", "r", "g", "b")
    assert decoded.dtype.itemsize % 4 == 0
    assert code(room, 0.1, law="none").dtype.itemsize == 12  # x, y, z
    lattice, cloud = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)
    for channel, name in enumerate("rgb"):
        mean = np.bincount(index, colour[:, channel]) / np.bincount(index)
        assert np.abs(cloud[name] - mean).max() <= 0.5


def test_box_and_origin(room):
    box = ((-1.0, -0.5, 0.0), (1.0, 0.5, 3.0))
    inside = ((room >= box[0]) & (room <= box[1])).all(axis=1)
    voxels, _ = voxels_of(room[inside], 0.1)
    encoder = pcl_ext.Encoder(0.1, bounding_box=box)
    with pytest.warns(pcl_ext.CompressionWarning, match="outside"):
        decoded = pcl_ext.Decoder().decode(encoder.encode(room))
    lattice, _ = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)
    assert encoder.cloud_statistics.points_outside_box == np.sum(~inside)
    far = np.float32(4096.0)
    shifted = code(room + far, 0.125, origin=(4096.0, 4096.0, 4096.0))
    expected, _ = voxels_of(room + far, 0.125)
    lattice = np.floor(pcl_ext.positions(shifted).astype(float) / 0.125).astype(int)
    np.testing.assert_array_equal(np.unique(lattice, axis=0), expected)
