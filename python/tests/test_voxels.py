"""What is decoded is what numpy computes from the points."""

import numpy as np
import pytest

import pcl_ext


def voxels_of(xyz, resolution):
    """Lattice indices of the points, of all occupied voxels, and of each point's voxel."""
    finite = np.isfinite(xyz).all(axis=1)
    lattice = np.floor(xyz[finite].astype(float) / resolution).astype(int)
    voxels, index = np.unique(lattice, axis=0, return_inverse=True)
    return voxels, np.ravel(index), finite


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


@pytest.mark.parametrize("effort", ["fast", "balanced", "small"])
@pytest.mark.parametrize("resolution", [0.2, 0.04, 0.013])
def test_count_is_the_number_of_points(room, effort, resolution):
    room[5] = np.nan
    room[6, 1] = -np.inf
    voxels, index, finite = voxels_of(room, resolution)
    lattice, cloud = decoded_by_lattice(
        code(room, resolution, law="count", effort=effort), resolution
    )
    np.testing.assert_array_equal(lattice, voxels)
    np.testing.assert_array_equal(
        cloud["intensity"], np.minimum(np.bincount(index), 255)
    )
    assert finite.sum() == len(room) - 2


def test_points_on_faces_belong_to_the_upper_voxel():
    xyz = np.array([[0.0, 0.0, 0.0], [0.25, 0.0, -0.25], [0.5, -0.5, 0.75]])
    lattice, _ = decoded_by_lattice(code(xyz, 0.25), 0.25)
    np.testing.assert_array_equal(lattice, [[0, 0, 0], [1, 0, -1], [2, -2, 3]])


def test_native_is_the_mean(room, random):
    intensity = random.integers(0, 256, len(room))
    voxels, index, _ = voxels_of(room, 0.1)
    encoder = pcl_ext.Encoder(0.1)
    decoded = pcl_ext.Decoder().decode(encoder.encode(room, intensity))
    assert encoder.law == "native"
    lattice, cloud = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)
    mean = np.bincount(index, intensity) / np.bincount(index)
    # Whole numbers of 8 bits are coded in steps of 1.
    assert np.abs(cloud["intensity"] - mean).max() <= 0.5


@pytest.mark.parametrize("law, exponent", [("linear", 1), ("quadratic", 2)])
def test_shares_are_those_of_the_paper(room, law, exponent):
    """I_v = 255 min(1, sum of (z / z_c)^n), z_c = d / sqrt(4 tan tan / (W H))."""
    fov_x, fov_y, columns, rows = pcl_ext.sensors()["kinect_v2"]
    half = np.tan(np.radians((fov_x, fov_y)) / 2)
    resolution = 0.05
    cut_off = resolution / np.sqrt(4 * half[0] * half[1] / (columns * rows))
    # The sensor looks along the world's x, its x along the world's y.
    pose = np.array([[0, 0, 1, -0.5], [1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 0, 1.0]])
    depth = room[:, 0].astype(float) + 0.5
    share = np.clip(depth / cut_off, 0, 1) ** exponent
    voxels, index, _ = voxels_of(room, resolution)
    expected = 255 * np.minimum(1, np.bincount(index, share))
    for sensor in ("kinect_v2", (fov_x, fov_y, columns, rows)):
        encoder = pcl_ext.Encoder(
            resolution, law=law, sensor=sensor, sensor_pose=pose, colour_bits=0
        )
        with pytest.warns(pcl_ext.CompressionWarning, match="behind the sensor"):
            decoded = pcl_ext.Decoder().decode(encoder.encode(room))
        lattice, cloud = decoded_by_lattice(decoded, resolution)
        np.testing.assert_array_equal(lattice, voxels)
        # Half a step of 8 bits, and what floats round.
        assert np.abs(cloud["intensity"] - expected).max() < 0.502
        assert encoder.cloud_statistics.points_behind_sensor == np.sum(depth < 0)


def test_a_pose_for_each_cloud(room):
    pose = np.eye(4)
    pose[2, 3] = -1.0
    fixed = pcl_ext.Encoder(law="linear", sensor="kinect_v2", sensor_pose=pose)
    moving = pcl_ext.Encoder(law="linear", sensor="kinect_v2")
    still = pcl_ext.Encoder(law="linear", sensor="kinect_v2")
    frame = fixed.encode(room)
    assert moving.encode(room, sensor_pose=pose) == frame
    assert still.encode(room) != frame


def test_none_is_positions_alone(room):
    voxels, _, _ = voxels_of(room, 0.1)
    decoded = code(room, 0.1, law="none")
    assert decoded.dtype.names == ("x", "y", "z")
    assert decoded.dtype.itemsize == 12
    lattice, _ = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)


def test_colours_are_means(room, random):
    colour = random.integers(0, 256, (len(room), 3), dtype=np.uint8)
    voxels, index, _ = voxels_of(room, 0.1)
    decoded = code((room, None, colour), 0.1, colour_bits=8)
    assert decoded.dtype.names == ("x", "y", "z", "r", "g", "b")
    assert decoded.dtype.itemsize % 4 == 0
    lattice, cloud = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)
    for channel, name in enumerate("rgb"):
        mean = np.bincount(index, colour[:, channel]) / np.bincount(index)
        assert np.abs(cloud[name] - mean).max() <= 0.5


def test_colours_without_intensity(room, random):
    colour = random.integers(0, 256, (len(room), 3), dtype=np.uint8)
    decoded = code((room, None, colour), 0.1, law="none", colour_bits=8)
    assert decoded.dtype.names == ("x", "y", "z", "r", "g", "b")
    with_intensity = code((room, None, colour), 0.1, colour_bits=8)
    for name in decoded.dtype.names:
        np.testing.assert_array_equal(decoded[name], with_intensity[name])


def test_keep_points_decodes_as_many(room):
    voxels, index, _ = voxels_of(room, 0.1)
    decoded = code(room, 0.1, keep_points=True)
    assert len(decoded) == len(room)
    lattice, cloud = decoded_by_lattice(decoded, 0.1)
    kept, counts = np.unique(lattice, axis=0, return_counts=True)
    np.testing.assert_array_equal(kept, voxels)
    np.testing.assert_array_equal(counts, np.bincount(index))


def test_box_and_origin(room):
    box = ((-1.0, -0.5, 0.0), (1.0, 0.5, 3.0))
    inside = ((room >= box[0]) & (room <= box[1])).all(axis=1)
    voxels, _, _ = voxels_of(room[inside], 0.1)
    encoder = pcl_ext.Encoder(0.1, bounding_box=box)
    with pytest.warns(pcl_ext.CompressionWarning, match="outside"):
        decoded = pcl_ext.Decoder().decode(encoder.encode(room))
    lattice, _ = decoded_by_lattice(decoded, 0.1)
    np.testing.assert_array_equal(lattice, voxels)
    assert encoder.cloud_statistics.points_outside_box == np.sum(~inside)
    far = np.float32(4096.0)
    shifted = code(room + far, 0.125, origin=(4096.0, 4096.0, 4096.0))
    expected, _, _ = voxels_of(room + far, 0.125)
    lattice = np.floor(pcl_ext.positions(shifted).astype(float) / 0.125).astype(int)
    np.testing.assert_array_equal(np.unique(lattice, axis=0), expected)


def test_what_is_decoded_encodes_to_the_same_voxels(room, random):
    colour = random.integers(0, 256, (len(room), 3), dtype=np.uint8)
    first = code((room, None, colour), 0.1, colour_bits=8)
    again = code(first, 0.1, colour_bits=8)
    np.testing.assert_array_equal(again, first)
