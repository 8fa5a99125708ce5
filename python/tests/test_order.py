# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The order in which a lidar measured its points."""

import numpy as np
import pytest

import pcl_ext

ROWS, COLUMNS = 16, 90
PERIOD = 1e-4


def measured_points(delay=0.0):
    """Column after column; each fifth point and columns 40 to 44 are missing."""
    column, row = np.mgrid[0:COLUMNS, 0:ROWS].reshape(2, -1)
    random = np.random.default_rng(8)
    kept = (random.random(len(row)) > 0.2) & ((column < 40) | (column > 44))
    column, row = column[kept], row[kept]
    dtype = [*((axis, "f4") for axis in "xyz"), ("ring", "u2"), ("timestamp", "f8")]
    points = np.zeros(len(row), dtype)
    angle = 2 * np.pi / COLUMNS * column
    distance = 4 + 0.001 * random.integers(0, 1000, len(row))
    points["x"] = distance * np.cos(angle)
    points["y"] = distance * np.sin(angle)
    points["z"] = 0.1 * row
    points["ring"] = row
    points["timestamp"] = 1.6e9 + PERIOD * column + delay * row
    return points


def received(points):
    encoder = pcl_ext.Encoder(0.001, law="none", keep_points=True, fields="all")
    return pcl_ext.Decoder().decode(encoder.encode(points))


def test_points_are_sorted_as_they_were_measured():
    sent = measured_points(delay=2e-6)
    ordered = pcl_ext.sort_by_time(received(sent))
    for name in ("ring", "timestamp"):
        np.testing.assert_array_equal(ordered[name], sent[name])
    np.testing.assert_allclose(ordered["x"], sent["x"], atol=0.000501)


@pytest.mark.parametrize("shape", [None, (20, 100)])
def test_rows_are_rings_and_columns_are_times(shape):
    sent = measured_points()
    arranged = pcl_ext.arrange_by_ring(received(sent), shape)
    assert arranged.shape == (shape or (ROWS, COLUMNS))
    columns = np.round((sent["timestamp"] - 1.6e9) / PERIOD).astype(int)
    found = arranged[sent["ring"], columns]
    for name in ("ring", "timestamp"):
        np.testing.assert_array_equal(found[name], sent[name])
    np.testing.assert_allclose(found["y"], sent["y"], atol=0.000501)
    assert np.isfinite(arranged["x"]).sum() == len(sent)
    assert arranged["ring"][3, 42] == 0
    np.testing.assert_array_equal(
        pcl_ext.sort_by_time(arranged)["timestamp"], np.sort(sent["timestamp"])
    )


def test_an_empty_cloud_has_no_rows():
    assert pcl_ext.arrange_by_ring(measured_points()[:0]).shape == (0, 0)


def without_ring(points):
    return points[["x", "y", "z", "timestamp"]]


@pytest.mark.parametrize(
    ("points", "options", "message"),
    [
        (without_ring(measured_points()), {}, "no field 'ring', 'channel', 'line'"),
        (measured_points(), {"time": "t"}, "no field 't'"),
        (measured_points(), {"shape": (8, 90)}, "need 16 rows and 90 columns"),
    ],
)
def test_clouds_that_do_not_tell_it(points, options, message):
    with pytest.raises(ValueError, match=message):
        pcl_ext.arrange_by_ring(points, **options)


def test_what_is_no_cloud_or_no_shape():
    for call in (pcl_ext.sort_by_time, pcl_ext.arrange_by_ring, pcl_ext.positions):
        for cloud in (np.zeros((5, 3)), [[0.0, 0.0, 0.0]]):
            with pytest.raises(TypeError, match="points of dtype float64 have no fields x, y, z"):
                call(cloud)
    for shape in ("a", 5, (16, 90.0), (16, 90, 1)):
        with pytest.raises(TypeError, match=r"^shape is .*; it must be two whole numbers"):
            pcl_ext.arrange_by_ring(measured_points(), shape)
