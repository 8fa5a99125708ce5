# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Streams: I-frames and P-frames, losses, headers, warnings, sizes."""

import warnings

import numpy as np
import pytest

import pcl_ext


def clouds_of(room, count):
    return [room + np.float32(0.02 * frame) for frame in range(count)]


def test_i_frames_are_sent_on_request(room):
    box = ((-2, -2, 0), (3, 2, 4))
    encoder = pcl_ext.Encoder(0.1, bounding_box=box)
    kinds = ""
    for frame, cloud in enumerate(clouds_of(room, 5)):
        if frame == 3:
            encoder.request_i_frame()
        encoder.encode(cloud)
        kinds += "I" if encoder.statistics.is_i_frame else "P"
    assert kinds == "IPPIP"


def test_bytes_that_are_no_frame_are_a_status(room, random):
    frame = pcl_ext.Encoder(0.1).encode(room)
    changed = bytearray(frame)
    changed[-1] ^= 1
    decoder = pcl_ext.Decoder()
    for data, code in (
        (b"", "EndOfStream"),
        (random.bytes(1000), "NoFrame"),
        (frame[:-5], "Truncated"),
        (changed, "Corrupt"),
    ):
        assert decoder.decode(data) is None
        assert decoder.status.code == code and decoder.status.message
    assert decoder.decode(frame) is not None


@pytest.mark.parametrize(
    "made_of",
    [
        bytes,
        bytearray,
        memoryview,
        lambda data: np.frombuffer(data, np.uint8),
        lambda data: np.frombuffer(data, np.int8),
        lambda data: memoryview(bytearray(data)).toreadonly(),
    ],
)
def test_kinds_of_bytes(room, made_of):
    frame = pcl_ext.Encoder(0.1).encode(room)
    expected = pcl_ext.Decoder().decode(frame)
    np.testing.assert_array_equal(pcl_ext.Decoder().decode(made_of(frame)), expected)
    assert pcl_ext.frame_size(made_of(frame)).known == len(frame)


@pytest.mark.parametrize(
    "data",
    ["text", 5, None, [1, 2], np.zeros(4), np.zeros((2, 2), "u1"), memoryview(b"abcd")[::2]],
)
def test_what_is_not_bytes(data):
    with pytest.raises(TypeError, match="it must be bytes, bytearray, memoryview or a uint8"):
        pcl_ext.Decoder().decode(data)
    with pytest.raises(TypeError):
        pcl_ext.frame_size(data)


def test_decoded_clouds_are_the_callers_own(room):
    encoder = pcl_ext.Encoder(0.1)
    frames = [encoder.encode(cloud) for cloud in clouds_of(room, 2)]
    decoder = pcl_ext.Decoder()
    first = decoder.decode(frames[0])
    copy = first.copy()
    decoder.decode(frames[1])
    np.testing.assert_array_equal(first, copy)
    xyz = pcl_ext.positions(first)
    assert xyz.shape == (len(first), 3) and np.shares_memory(xyz, first)
    xyz[:] = 7
    assert (first["z"] == 7).all()
    del decoder
    assert (first["x"] == 7).all()


def test_positions_of_other_arrays():
    points = np.zeros((4, 5), [("t", "f8"), ("x", "f4"), ("y", "f4"), ("z", "f4")])
    points["y"] = 2
    np.testing.assert_array_equal(pcl_ext.positions(points[1:, ::2])[2, 1], (0, 2, 0))
    assert pcl_ext.positions(points[:0, 0]).shape == (0, 3)
    with pytest.raises(ValueError, match="not floats of one type side by side"):
        pcl_ext.positions(np.zeros(4, [("x", "f8"), ("y", "f4"), ("z", "f8")]))


@pytest.mark.parametrize("layout", ["columns", "fields", "big-endian", "reversed"])
def test_float64_keeps_the_precision_of_far_coordinates(layout):
    # UTM: floats are 0.5 m apart there. At 4 cm each point is alone in its voxel.
    rng = np.random.default_rng(5)
    points = np.array([6e5, 5.2e6, 400.0]) + rng.uniform(0, 60, (2000, 3))
    points = points[np.unique(np.floor(points / 0.04), axis=0, return_index=True)[1]]
    cloud = {
        "columns": points,
        "fields": points.copy().view([("x", "f8"), ("y", "f8"), ("z", "f8")])[:, 0],
        "big-endian": points.astype(">f8"),
        "reversed": points[::-1],
    }[layout]
    encoder = pcl_ext.Encoder(0.04)
    decoded = pcl_ext.Decoder().decode(encoder.encode(cloud))
    assert encoder.statistics.voxels == len(points)
    xyz = pcl_ext.positions(decoded)
    assert xyz.dtype == np.float64 and xyz.flags.aligned
    order = np.lexsort(np.floor(xyz / 0.04).T), np.lexsort(np.floor(points / 0.04).T)
    assert np.abs(xyz[order[0]] - points[order[1]]).max() <= 0.02 + 1e-6


def test_depth_of_far_clouds():
    # A wall 2 m in front of a sensor far from the origin has the intensities of one near.
    wall = np.stack(np.meshgrid(*2 * [np.linspace(-0.5, 0.5, 100)], [2.0]), -1)
    wall = wall.reshape(-1, 3) + 0.001
    decoded = []
    for place in [0, 0, 0], [6e5, 5.2e6, 400.0]:
        pose = np.eye(4)
        pose[:3, 3] = place
        encoder = pcl_ext.Encoder(0.04, law="quadratic", sensor="kinect_v2", sensor_pose=pose)
        decoded.append(pcl_ext.Decoder().decode(encoder.encode(wall + place)))
    np.testing.assert_array_equal(decoded[0]["intensity"], decoded[1]["intensity"])


def test_stamp_and_frame_id(room):
    encoder = pcl_ext.Encoder(0.1, frame_id="cell")
    decoder = pcl_ext.Decoder()
    assert decoder.stamp is None and decoder.frame_id is None
    # 0 is no time.
    for stamp in (0.0, 12.000001, None, 1700000000.123456, np.float64(3.25)):
        decoder.decode(encoder.encode(room, stamp=stamp))
        assert decoder.stamp == (stamp or None)
        assert decoder.frame_id == "cell"
    # To the nearest microsecond.
    decoder.decode(encoder.encode(room, stamp=1.4999996))
    assert decoder.stamp == 1.5
    plain = pcl_ext.Encoder(0.1)
    decoder = pcl_ext.Decoder()
    decoder.decode(plain.encode(room))
    assert decoder.stamp is None and decoder.frame_id is None
    decoder.decode(plain.encode(room, stamp=2))
    assert decoder.stamp == 2.0 and decoder.frame_id is None


def test_clouds_without_a_time_are_counted_only(room):
    for first, times in ((0.0, [0.5, 1.5]), (10.0, [10.0, 11.0])):
        encoder = pcl_ext.Encoder(0.1, i_frame_every=1.0)
        of_i_frames = []
        for number in range(4):
            encoder.encode(room, stamp=first + number / 2)
            if encoder.statistics.is_i_frame:
                of_i_frames.append(first + number / 2)
        # The first frame is one in any case; the time that counts is that of the first stamp.
        assert of_i_frames == [first, times[1]]


def test_the_published_layout_has_no_header(room):
    encoder = pcl_ext.Encoder(0.1, format="published", colour_bits=0)
    with pytest.raises(pcl_ext.Error, match="no fields for stamp") as raised:
        encoder.encode(room, stamp=1.0)
    assert raised.value.code == "InvalidInput"
    assert isinstance(raised.value, RuntimeError)
    assert pcl_ext.Decoder().decode(encoder.encode(room)) is not None


def test_warnings_come_once_for_each_kind(room):
    encoder = pcl_ext.Encoder(0.1, bounding_box=((-1, -1, 0), (1, 1, 3)))
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        for cloud in clouds_of(room, 3):
            encoder.encode(cloud)
            assert "outside" in encoder.warning
        encoder.encode(room[:0])
    assert encoder.warning == ""
    assert [warning.category for warning in seen] == [pcl_ext.CompressionWarning]
    # The line that is shown is the caller's.
    assert seen[0].filename == __file__


def test_a_warning_that_is_an_error_loses_no_frame(room):
    box = ((-1, -1, 0), (1, 1, 3))
    encoder = pcl_ext.Encoder(0.1, bounding_box=box)
    with warnings.catch_warnings():
        warnings.simplefilter("error", pcl_ext.CompressionWarning)
        with pytest.raises(pcl_ext.CompressionWarning):
            encoder.encode(room)
    decoder = pcl_ext.Decoder()
    assert decoder.decode(encoder.encode(room)) is not None


def test_statistics(room):
    encoder = pcl_ext.Encoder(0.1)
    assert encoder.statistics == pcl_ext.FrameStatistics()
    assert encoder.cloud_statistics == pcl_ext.CloudStatistics()
    room[3] = np.nan
    frame = encoder.encode(room)
    decoder = pcl_ext.Decoder()
    assert decoder.statistics == pcl_ext.FrameStatistics()
    cloud = decoder.decode(frame)
    statistics = encoder.statistics
    assert statistics == decoder.statistics
    assert statistics.bytes == len(frame)
    assert statistics.voxels == len(cloud)
    assert statistics.bytes == (
        statistics.header_bytes
        + statistics.occupancy_bytes
        + statistics.intensity_bytes
        + statistics.attribute_bytes
    )
    assert encoder.cloud_statistics == pcl_ext.CloudStatistics(
        resolution=0.1, points=len(room), points_used=len(room) - 1, points_not_finite=1
    )
    # What fails leaves them as they were.
    assert decoder.decode(b"") is None
    assert decoder.statistics == statistics


def test_limits(room):
    frame = pcl_ext.Encoder(0.1, keep_points=True).encode(room)
    voxels = len(np.unique(np.floor(room.astype(float) / 0.1), axis=0))
    for limits in (
        {"max_voxels": voxels - 1},
        {"max_points": 6499},
        {"max_frame_bytes": len(frame) - 1},
    ):
        decoder = pcl_ext.Decoder(**limits)
        assert decoder.decode(frame) is None
        assert decoder.status.code == "LimitExceeded"
        assert pcl_ext.frame_size(frame, **limits).status.code in ("Ok", "LimitExceeded")
    limits = {"max_voxels": voxels, "max_points": 6500, "max_frame_bytes": len(frame)}
    assert len(pcl_ext.Decoder(**limits).decode(frame)) == 6500


def test_frame_size_of_bytes_in_pieces(room):
    frame = pcl_ext.Encoder(0.1).encode(room)
    needed = 0
    while True:
        size = pcl_ext.frame_size(frame[:needed])
        if size.status.ok:
            break
        assert size.status.code == "Truncated"
        assert size.needed > needed
        needed = size.needed
    assert size.known == size.needed == len(frame) and needed <= 100
    assert pcl_ext.frame_size(frame + b"more").known == len(frame)
    text = pcl_ext.frame_size(b"x" * 50 + frame)
    assert text.status.code == "NoFrame"
    assert text.drop == 50


def test_min_intensity(room):
    frame = pcl_ext.Encoder(0.1, law="count").encode(room)
    complete = pcl_ext.Decoder().decode(frame)
    kept = pcl_ext.Decoder().decode(frame, min_intensity=3)
    np.testing.assert_array_equal(kept, complete[complete["intensity"] >= 3])
    assert 0 < len(kept) < len(complete)
    np.testing.assert_array_equal(pcl_ext.Decoder().decode(frame, min_intensity=-np.inf), complete)
    for wrong in (10**400, np.eye(2), "low", np.nan):
        with pytest.raises(ValueError, match="min_intensity is"):
            pcl_ext.Decoder().decode(frame, min_intensity=wrong)


def test_fields_that_are_left_out_are_named_once():
    cloud = np.zeros(4, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("ring", "u2"), ("time", "f8")])
    encoder = pcl_ext.Encoder(0.1)
    with pytest.warns(pcl_ext.CompressionWarning, match="left out: ring, time") as seen:
        encoder.encode(cloud)
        encoder.encode(cloud)
    assert len(seen) == 1
    assert "ring" in encoder.warning


@pytest.mark.parametrize("name", ["rgba", "rgb"])
@pytest.mark.parametrize("dtype", ["u4", "f4"])
def test_alpha_is_left_out_with_a_warning(name, dtype):
    whole = [("x", "f4"), ("y", "f4"), ("z", "f4"), (name, dtype), ("ring", "u2")]
    cloud = np.zeros((2, 3), whole)[:, ::2]  # not side by side
    words = "left out: the alpha of rgba, ring" if name == "rgba" else "left out: ring"
    for alpha in (255, 128):
        cloud[name] = np.array([alpha << 24 | 0x102030], "u4").view(dtype)
        encoder = pcl_ext.Encoder(0.1)
        with pytest.warns(pcl_ext.CompressionWarning):
            encoder.encode(cloud)
        expected = words if alpha < 255 else "left out: ring"
        assert encoder.warning.endswith(expected)
        for kept in (name, "all"):
            encoder = pcl_ext.Encoder(0.1, fields=[kept])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of ring
                encoder.encode(cloud)
            loses = alpha < 255 and name == "rgba" and kept == "all"
            assert ("alpha" in encoder.warning) == loses


def test_clouds_without_points_do_not_decide_on_the_law():
    points = np.zeros(2, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4")])
    points["intensity"] = 7
    encoder = pcl_ext.Encoder(0.1)
    frames = [encoder.encode(np.zeros((0, 3), "f4")) for _ in range(2)]
    assert encoder.law == "automatic"
    frames += [encoder.encode(cloud) for cloud in (points, points[:0], points)]
    assert encoder.law == "native"
    assert encoder.warning == ""
    decoder = pcl_ext.Decoder()
    clouds = [decoder.decode(frame) for frame in frames]
    assert [len(cloud) for cloud in clouds] == [0, 0, 1, 0, 1]
    assert clouds[-1]["intensity"] == 7
    assert encoder.statistics.frame_number == 5


def test_an_intensity_that_the_first_cloud_lacks_is_named_once():
    points = np.zeros(2, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("intensity", "f4")])
    encoder = pcl_ext.Encoder(0.1)
    encoder.encode(points[["x", "y", "z"]])
    with pytest.warns(pcl_ext.CompressionWarning, match="left out: intensity$") as seen:
        encoder.encode(points)
        encoder.encode(points)
    assert len(seen) == 1
    for wanted in (pcl_ext.Encoder(0.1, law="none"), pcl_ext.Encoder(0.1, fields="all")):
        wanted.encode(points[["x", "y", "z"]])
        wanted.encode(points)
        assert wanted.warning == ""
