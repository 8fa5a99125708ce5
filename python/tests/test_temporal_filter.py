# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The temporal filter, before encoding and after decoding."""

import numpy as np
import pytest

import pcl_ext

SENSOR = np.array((4.0, -2.0, 1.0))


def clouds(random, frames, plate_frames=0):
    """What a sensor sees of a wall with noise; in the first frames of a plate before it."""
    rays = np.stack(np.meshgrid(*[np.arange(-0.36, 0.36, 0.006)] * 2), -1).reshape(-1, 2)
    for frame in range(frames):
        is_plate = (np.abs(rays) < 0.2).all(1) & (frame < plate_frames)
        depth = np.where(is_plate, 1.5, 3.0) + random.normal(0, 0.01, len(rays))
        yield SENSOR + np.column_stack((rays * depth[:, None], depth))


def pose():
    matrix = np.eye(4)
    matrix[:3, 3] = SENSOR
    return matrix


@pytest.mark.parametrize("hertz", [None, 2])
@pytest.mark.parametrize("pose_of", ["settings", "cloud"])
def test_both_ends_show_the_same(random, pose_of, hertz):
    """Also a filter over 64 frames hides at once what the sensor sees through."""
    of_settings = {"sensor_pose": pose()} if pose_of == "settings" else {}
    of_cloud = {"sensor_pose": pose()} if pose_of == "cloud" else {}
    plain = pcl_ext.Encoder(0.04, law="count", **of_settings)
    filtering = pcl_ext.Encoder(0.04, law="count", temporal_filter=64, **of_settings)
    receiver = pcl_ext.Decoder()
    decoder = pcl_ext.Decoder()
    temporal_filter = pcl_ext.TemporalVoxelFilter(64, sensor_position=SENSOR)
    for number, cloud in enumerate(clouds(random, 10, plate_frames=6)):
        if hertz:
            of_cloud["stamp"] = 100 + number / hertz
        shown = decoder.decode(filtering.encode(cloud, **of_cloud))
        frame = plain.encode(cloud, **of_cloud)
        filtered = receiver.decode(frame, temporal_filter=temporal_filter)
        np.testing.assert_array_equal(filtered, shown)
        assert temporal_filter.status.ok
        figures = filtering.cloud_statistics
        assert figures.voxels_hidden == temporal_filter.hidden
        assert figures.voxels_held == temporal_filter.held
        assert (
            len(filtered)
            == receiver.statistics.voxels - temporal_filter.hidden + temporal_filter.held
        )
    assert not (shown["z"] < 3.0).any()


def test_reset(random):
    frame = pcl_ext.Encoder(0.04, law="count").encode(next(clouds(random, 1)))
    temporal_filter = pcl_ext.TemporalVoxelFilter()
    first = pcl_ext.Decoder().decode(frame, temporal_filter=temporal_filter)
    for cloud in clouds(random, 5):
        other = pcl_ext.Encoder(0.04, law="count").encode(cloud)
        pcl_ext.Decoder().decode(other, temporal_filter=temporal_filter)
    later = pcl_ext.Decoder().decode(frame, temporal_filter=temporal_filter)
    assert not np.array_equal(later, first)
    temporal_filter.reset()
    again = pcl_ext.Decoder().decode(frame, temporal_filter=temporal_filter)
    np.testing.assert_array_equal(again, first)


@pytest.mark.parametrize(
    "settings, error, message",
    [
        ({"frames": 1}, ValueError, "frames is 1; it must be a whole number of 2 to 64"),
        ({"frames": 65}, ValueError, "frames is 65"),
        ({"frames": 8.0}, TypeError, "frames is 8.0"),
        ({"sensor_position": (1, 2)}, ValueError, r"sensor_position is \(1, 2\)"),
    ],
)
def test_bad_settings_of_the_filter(settings, error, message):
    with pytest.raises(error, match=message):
        pcl_ext.TemporalVoxelFilter(**settings)


def test_what_is_no_filter():
    with pytest.raises(TypeError, match="temporal_filter is a 'int', not a Temp"):
        pcl_ext.Decoder().decode(b"", temporal_filter=8)


def test_an_encoder_warns_where_most_voxels_are_hidden():
    random = np.random.default_rng(1)
    encoder = pcl_ext.Encoder(0.1, temporal_filter=8)
    for _ in range(29):
        encoder.encode(random.uniform(-5, 5, (500, 3)))
    with pytest.warns(pcl_ext.CompressionWarning, match="the temporal filter hid"):
        encoder.encode(random.uniform(-5, 5, (500, 3)))
