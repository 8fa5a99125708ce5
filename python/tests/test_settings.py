# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Settings: those of the library, by their names; wrong ones are refused."""

import inspect
import re
import typing

import numpy as np
import pytest

import pcl_ext
from pcl_ext import _native, codec, outliers

BAD_SETTINGS = [
    ({"resolution": 0}, ValueError, r"resolution is 0; it must be 1e-06 to 1e\+06 m"),
    ({"resolution": "fine"}, TypeError, "resolution is 'fine'; it must be a number"),
    ({"resolution": None}, TypeError, "resolution is None"),
    ({"resolution": True}, TypeError, "resolution is True"),
    ({"resolution": 10**400}, ValueError, r"resolution is 10+\.\.\.0+; it must be a number of"),
    ({"resolution": 10**5000}, ValueError, "resolution is an object of type int; it must be"),
    ({"resolution": np.array("1")}, TypeError, r"resolution is array\('1'.*\); it must be a num"),
    ({"resolution": np.eye(2)}, TypeError, r"resolution is array\(\[\[1.*; it must be a number"),
    ({"effort": "\ud800"}, ValueError, r"effort is '\\ud800'; it must be a text that UTF-8 has"),
    ({"effort": "great"}, ValueError, "effort is 'great'; it must be one of fast, balanced, small"),
    ({"effort": 1}, TypeError, "effort is 1; it must be a text"),
    ({"i_frame_rate": -1}, ValueError, "i_frame_rate is -1; it must be a whole number of 0"),
    ({"threads": -1}, ValueError, "threads is -1; it must be a whole number of 1 to 256"),
    ({"i_frame_rate": 2**40}, ValueError, "i_frame_rate is 1099511627776"),
    ({"i_frame_rate": 2**80}, ValueError, "i_frame_rate is 1208925819614629174706176"),
    ({"i_frame_rate": 2.0}, TypeError, "i_frame_rate is 2.0; it must be a whole number"),
    ({"i_frame_rate": np.array([4])}, TypeError, r"i_frame_rate is array\(\[4\]\); it must be a w"),
    ({"threads": np.array([])}, TypeError, "threads is array.*; it must be a whole number"),
    ({"law": "loud"}, ValueError, "law is 'loud'; it must be one of automatic, count, quadr"),
    ({"law": "quadratic"}, ValueError, "the law 'quadratic' needs a sensor"),
    ({"sensor": "d435"}, ValueError, r"sensor is 'd435'; it must be its name \(kinect_v2, "),
    ({"sensor": (70, 60, 512)}, ValueError, r"sensor is \(70, 60, 512\); it must be 4 numbers"),
    ({"sensor": (700, 60, 512, 424)}, ValueError, "sensor: field of view must be between 0"),
    ({"sensor": (70, 60, 1e9, 424)}, ValueError, "1 to 65536 whole columns"),
    ({"sensor": (70, 60, 512.9, 424)}, ValueError, "1 to 65536 whole columns"),
    ({"sensor": 5}, ValueError, "sensor is 5; it must be 4 numbers"),
    ({"sensor_pose": np.full((4, 4), np.nan)}, ValueError, "sensor_pose is not a rotation"),
    ({"sensor_pose": [1, 2]}, ValueError, "sensor_pose must be an array of 4 x 4 numbers"),
    ({"bounding_box": 5}, ValueError, r"bounding_box is 5; it must be two corners"),
    ({"bounding_box": ((0, 0, 0), (1, 1))}, ValueError, "upper corner of bounding_box is"),
    ({"bounding_box": np.float32(1)}, ValueError, "bounding_box is 1.0; it must be two corners"),
    ({"depth_law": (3, 14.0, 255.0)}, ValueError, r"depth_law is \(3, 14.0, 255.0\); it must be"),
    ({"depth_law": (1.5, 3, 255)}, ValueError, r"depth_law is \(1.5, 3, 255\); .* of 1 or 2"),
    ({"depth_law": 2}, ValueError, "depth_law is 2; it must be 3 numbers"),
    ({"keep_points": 1}, TypeError, "keep_points is 1; it must be True or False"),
    ({"temporal_filter": 8.0}, TypeError, "temporal_filter is 8.0; it must be a whole"),
    (
        {"temporal_filter": 8, "keep_points": True},
        ValueError,
        "keep_points is on; it must be off with temporal_filter",
    ),
    ({"origin": (1, 2)}, ValueError, r"origin is \(1, 2\); it must be 3 numbers"),
    ({"origin": np.array(["1", "2", "3"])}, ValueError, "origin is array.*; it must be 3 numbers"),
    ({"fields": "\ud800"}, ValueError, r"fields is '\\ud800'; it must be 'all', a name"),
    ({"frame_id": 5}, TypeError, "frame_id is 5; it must be a text"),
    ({"frame_id": "\ud800"}, ValueError, r"frame_id is '\\ud800'; it must be a text that UTF-8"),
    (
        {"frame_id": "a", "format": "published"},
        ValueError,
        "frame_id is 'a'; it must be None in the published layout",
    ),
    *(
        ({name: 0.4}, ValueError, f"{name} is 0.4; it must be left out without max_rate$")
        for name in ("rate_buffer", "rate_sent_share")
    ),
    (
        {"rate_doublings": 1},
        ValueError,
        "rate_doublings is 1; it must be left out without max_rate or max_encode_ms",
    ),
    *(
        (
            {"law": "none", **other},
            ValueError,
            f"{next(iter(other))} is .*; it must be left out with the law 'none'",
        )
        for other in (
            {"intensity_bits": 4},
            {"intensity_range": 9.0},
            {"intensity_curve": "companded"},
            {"aggregation": "sum"},
        )
    ),
    (
        {"law": "count", "depth_law": (2, 14.0, 255.0)},
        ValueError,
        "depth_law is .*; it must be None with the law 'count'",
    ),
    (
        {"aggregation": "mean", "law": "count"},
        ValueError,
        "aggregation is mean; it must be sum or automatic with law count, whose "
        "intensities are sums over the points of a voxel",
    ),
    (
        {"keep_order": True, "law": "count"},
        ValueError,
        "law is count; it must be native or none with keep_order",
    ),
    *(
        (
            {"use_coordinate_step": True, **other},
            ValueError,
            f"use_coordinate_step is True; it must be False with .*{next(iter(other))}",
        )
        for other in (
            {"law": "linear", "sensor": "kinect_v2"},
            {"origin": (0, 0, 0)},
            {"bounding_box": ((0, 0, 0), (1, 1, 1))},
            {"keep_order": True},
            {"format": "published"},
        )
    ),
]


@pytest.mark.parametrize("settings, error, message", BAD_SETTINGS)
def test_bad_settings(settings, error, message):
    with pytest.raises(error, match=message) as raised:
        pcl_ext.Encoder(**settings)
    assert "\n" not in str(raised.value)


def test_settings_are_those_that_an_encoder_was_made_with():
    encoder = pcl_ext.Encoder(0.04)
    with pytest.raises(AttributeError, match="resolution of Encoder cannot be set"):
        encoder.resolution = 0.5


def test_flags_of_numpy_are_flags(room):
    assert len(pcl_ext.Encoder(keep_points=np.True_).encode(room)) == len(
        pcl_ext.Encoder(keep_points=True).encode(room)
    )


def test_coordinates_that_are_too_large():
    with pytest.raises(pcl_ext.Error, match="set origin amid the points, or leave out"):
        pcl_ext.Encoder(0.1).encode(np.full((3, 3), 1e300))


def test_settings_are_named():
    with pytest.raises(TypeError):
        pcl_ext.Encoder(0.04, "fast")
    with pytest.raises(TypeError):
        pcl_ext.Encoder(brightness=1)


def test_a_long_frame_id(room):
    encoder = pcl_ext.Encoder(frame_id="x" * 1025)
    with pytest.raises(pcl_ext.Error, match="frame_id has 1025 bytes"):
        encoder.encode(room)


@pytest.mark.parametrize(
    "limits, error, message",
    [
        ({"max_voxels": 0}, ValueError, "^max_voxels is 0; it must be a whole number of 1 to"),
        ({"max_points": 0}, ValueError, "max_points is 0"),
        ({"max_field_values": 0}, ValueError, "max_field_values is 0"),
        ({"max_field_values": 1.5}, TypeError, "max_field_values is 1.5"),
        ({"max_frame_bytes": 0}, ValueError, "max_frame_bytes is 0"),
        ({"max_voxels": -1}, ValueError, "max_voxels is -1"),
        ({"max_voxels": 2**70}, ValueError, "max_voxels is 1180591620717411303424"),
        ({"max_voxels": 2**28 + 1}, ValueError, "it must be a whole number of 1 to 268435456"),
        ({"max_voxels": 1.5}, TypeError, "max_voxels is 1.5"),
    ],
)
def test_bad_limits(limits, error, message):
    with pytest.raises(error, match=message):
        pcl_ext.Decoder(**limits)
    with pytest.raises(error, match=message):
        pcl_ext.frame_size(b"", **limits)


@pytest.mark.parametrize(
    "settings, error, message",
    [
        ({"unit": "litres"}, ValueError, "unit is 'litres'; it must be one of automatic, fa"),
        ({"min_log_odds": float("nan")}, ValueError, "min_log_odds is nan"),
        ({"min_log_odds": "low"}, TypeError, "min_log_odds is 'low'"),
        ({"min_log_odds": None}, TypeError, "min_log_odds is None"),
        ({"use_history": 0}, TypeError, "use_history is 0"),
        ({"unit": "rays", "sensor_position": (1, 2)}, ValueError, r"position is \(1, 2\)"),
        ({"max_blocks": -1}, ValueError, "max_blocks is -1"),
        (
            {"unit": "points", "full_intensity": 255.0},
            ValueError,
            "full_intensity is 255.0; it must be left out, as the unit points does not have it",
        ),
    ],
)
def test_bad_outlier_removals(settings, error, message):
    with pytest.raises(error, match=message):
        pcl_ext.OutlierRemoval(**settings)


def test_a_unit_has_its_settings_alone():
    settings = {
        "use_history": (False, ["automatic", "faces", "points", "voxels"]),
        "full_intensity": (16.0, ["faces"]),
        "sensor_position": ((1, 2, 3), ["rays"]),
        "azimuth_step": (0.01, ["rays"]),
        "elevation_step": (0.01, ["rays"]),
        "intensities_are_counts": (True, ["automatic", "rays"]),
    }
    for unit in typing.get_args(outliers.Unit):
        for name, (value, units) in settings.items():
            if unit in units:
                pcl_ext.OutlierRemoval(unit, **{name: value})
                continue
            with pytest.raises(ValueError, match=f"{name} is .*as the unit {unit} does not"):
                pcl_ext.OutlierRemoval(unit, **{name: value})


def test_defaults_are_those_of_the_library():
    defaults = {}
    for of_class in (
        pcl_ext.Encoder,
        pcl_ext.Decoder,
        pcl_ext.OutlierRemoval,
        pcl_ext.TemporalVoxelFilter,
    ):
        for name, parameter in inspect.signature(of_class).parameters.items():
            defaults[name] = parameter.default
    for name, default in _native.default_settings().items():
        assert defaults[name] == default, name


def test_keywords_are_the_settings_of_the_library():
    """Each has its default and its words, and is documented with its range."""
    keywords = dict(inspect.signature(pcl_ext.Encoder).parameters)
    parameters = inspect.getdoc(pcl_ext.Encoder).split("Parameters\n---")[1].split("\nRaises\n")[0]
    documents = {
        entry[1]: " ".join(entry[2].split())
        for entry in re.finditer(r"^(\w+) : .*\n((?:    .*\n)+)", parameters, re.MULTILINE)
    }
    assert list(documents) == list(keywords)
    for setting in _native.encoder_settings():
        name = setting["name"]
        if setting["not_offered"]:
            assert name not in keywords
            continue
        keyword = keywords.pop(name)
        document = documents[name]
        assert keyword.default == setting["default"], name
        if setting["words"]:
            annotation = eval(keyword.annotation, vars(codec))
            assert list(typing.get_args(annotation)) == setting["words"]
            assert all(f'"{word}"' in document for word in setting["words"]), name
        if setting["zero"]:
            assert f"0: {setting['zero']}" in document, name
        ends = (setting["lowest"], setting["highest"])
        if ends[0] > 0 or 0 < ends[1] < 1e6:
            ranges = re.findall(r"([\d.e-]*\d) to ([\d.e]*\d)", document)
            assert ends in [(float(low), float(high)) for low, high in ranges], name
    assert set(keywords) == {"law", "sensor", "sensor_pose", "depth_law", "frame_id"}


def test_settings_reach_the_library(room):
    """Each of them changes the frame."""
    intensity = np.linspace(0, 300, len(room), dtype="f4")
    colour = np.full((len(room), 3), 77, "u1")
    plain = pcl_ext.Encoder(0.1).encode(room, intensity, colour)
    pose = np.eye(4)
    pose[2, 3] = -0.5
    for settings in (
        {"effort": "balanced"},
        {"effort": "small"},
        {"bounding_box": ((-3, -3, -3), (3, 3, 3))},
        {"intensity_bits": 5},
        {"intensity_range": 400.0},
        {"intensity_curve": "companded"},
        {"aggregation": "sum"},
        {"depth_law": (2, 14.0, 255.0), "intensity_range": 400.0},
        {"colour_bits": 3},
        {"keep_points": True},
        {"temporal_filter": 8},
        {"origin": (0.5, 0.0, 0.0)},
        {"frame_id": "cell"},
    ):
        frame = pcl_ext.Encoder(0.1, **settings).encode(room, intensity, colour)
        assert frame != plain, settings
        assert pcl_ext.Decoder().decode(frame) is not None


def test_wide_clouds():
    cloud = np.zeros((100, 3))
    cloud[:, 0] = np.linspace(0, 3000, 100)
    fine = pcl_ext.Encoder(0.001)
    with pytest.warns(pcl_ext.CompressionWarning, match="grid"):
        fine.encode(cloud)
    assert fine.cloud_statistics.points_outside_grid > 0
    coarser = pcl_ext.Encoder(0.001, coarsen_wide_clouds=True)
    with pytest.warns(pcl_ext.CompressionWarning, match="too wide"):
        coarser.encode(cloud)
    assert coarser.cloud_statistics.points_used == 100
    assert coarser.cloud_statistics.resolution == 0.002
