# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Arrays of rows and columns, which come back as such where that takes hardly more bytes."""

import numpy as np
import pytest

import pcl_ext


def depth_image(rows=90, columns=120):
    """Points of a camera, depths in whole millimetres; one in ten is missing."""
    random = np.random.default_rng(5)
    row, column = np.mgrid[0:rows, 0:columns]
    depth = 0.001 * (1500 + 2 * column + random.integers(0, 3, (rows, columns)))
    points = np.zeros((rows, columns), [*((axis, "f4") for axis in "xyz"), ("label", "u2")])
    points["x"] = (column - columns / 2) / 100 * depth
    points["y"] = (row - rows / 2) / 100 * depth
    points["z"] = depth
    points["label"] = row // 9 * 100 + column
    points["x"][random.random((rows, columns)) < 0.1] = np.nan
    return points


def rings():
    """Points of a lidar of 16 rings, ring by ring."""
    ring, column = np.mgrid[0:16, 0:400]
    angle = 2 * np.pi / 400 * column + 0.01 * (ring % 4)
    distance = 4 + np.cos(3 * angle)
    columns = [*((axis, "f4") for axis in "xyz"), ("ring", "u2"), ("number", "u4")]
    points = np.zeros(ring.size, columns)
    points["x"] = (distance * np.cos(angle)).ravel()
    points["y"] = (distance * np.sin(angle)).ravel()
    points["z"] = (distance * (0.02 * ring - 0.11)).ravel()
    points["ring"] = ring.ravel()
    points["number"] = np.arange(ring.size)
    return points


def test_rows_and_columns_come_back():
    points = depth_image()
    encoder = pcl_ext.Encoder(0.001, law="none", keep_points=True, fields="all")
    decoder = pcl_ext.Decoder()
    for _ in range(3):
        decoded = decoder.decode(encoder.encode(points))
        assert decoded.shape == points.shape
        missing = np.isnan(points["x"])
        for axis in "xyz":
            np.testing.assert_array_equal(np.isnan(decoded[axis]), missing)
            error = np.abs(decoded[axis] - points[axis])[~missing]
            assert error.max() <= 0.000501
        np.testing.assert_array_equal(decoded["label"], np.where(missing, 0, points["label"]))
        assert pcl_ext.positions(decoded).shape == (*points.shape, 3)


@pytest.mark.parametrize("shape, line", [((400, 1), "column"), ((1, 400), "row")])
def test_one_row_or_column_loses_its_shape_with_a_warning(shape, line):
    points = np.random.default_rng(3).uniform(1, 2, (*shape, 3)).astype("f4")
    points[points[..., 0] < 1.1] = np.nan
    encoder = pcl_ext.Encoder(0.001, law="none", keep_order=True)
    words = rf"the one {line} of xyz is kept as \(400,\), without what is NaN"
    with pytest.warns(pcl_ext.CompressionWarning, match=words):
        frame = encoder.encode(points)
    finite = points[np.isfinite(points[..., 0])]
    np.testing.assert_allclose(
        pcl_ext.positions(pcl_ext.Decoder().decode(frame)), finite, atol=0.0006
    )


def test_outliers_that_are_removed_take_rows_and_columns_with_them():
    encoder = pcl_ext.Encoder(0.01, law="none", keep_points=True, fields="label")
    words = "the rows and columns of xyz are not kept, as outliers are removed from voxels"
    with pytest.warns(pcl_ext.CompressionWarning, match=words):
        encoder.encode(depth_image(), outliers=pcl_ext.OutlierRemoval())
    encoder = pcl_ext.Encoder(0.01, law="none", keep_points=True, fields="label")
    encoder.encode(depth_image())
    assert words not in encoder.warning


def test_scores_have_the_shape_of_the_cloud():
    points = depth_image()
    encoder = pcl_ext.Encoder(0.001, keep_points=True, fields="all")
    decoder = pcl_ext.Decoder()
    decoded = decoder.decode(encoder.encode(points))
    assert decoded.shape == points.shape
    scores = pcl_ext.OutlierRemoval().score(decoder)
    assert scores.shape == decoded.shape
    np.testing.assert_array_equal(np.isnan(scores), np.isnan(decoded["x"]))


def test_points_too_far_away_for_voxels_have_no_scores():
    points = rings()
    for axis in "xyz":
        points[axis][::100] *= 1000
    encoder = pcl_ext.Encoder(0.001, law="none", keep_points=True, fields="all")
    frames = [encoder.encode(points) for _ in range(2)]
    decoder = pcl_ext.Decoder()
    decoded = decoder.decode(frames[0])
    assert decoded.shape == points.shape
    expected = points[decoded["number"]]
    for axis in "xyz":
        np.testing.assert_allclose(decoded[axis], expected[axis], atol=0.0006, rtol=1e-6)
    is_far = decoded["number"] % 100 == 0
    scores = pcl_ext.OutlierRemoval("voxels").score(decoder)
    np.testing.assert_array_equal(np.isnan(scores), is_far)
    assert decoder.status.message == ""
    outliers = pcl_ext.OutlierRemoval("voxels")
    words = f"{is_far.sum()} points of the scan are outside its grid of voxels"
    decoder = pcl_ext.Decoder()
    with pytest.warns(pcl_ext.CompressionWarning, match=words) as warned:
        kept = decoder.decode(frames[0], outliers=outliers)
        assert decoder.decode(frames[1], outliers=outliers) is not None  # warns once
    assert [warning.filename for warning in warned] == [__file__]
    assert decoder.status.ok and decoder.status.message.startswith(words)
    assert not np.isnan(kept["x"]).any()
    assert len(kept) <= len(decoded) - is_far.sum()


def test_points_have_their_own_intensities_and_outliers_are_missing():
    image = depth_image()
    points = np.zeros(image.shape, [*((axis, "f4") for axis in "xyz"), ("intensity", "f4")])
    for axis in "xyz":
        points[axis] = image[axis]
    points["intensity"] = np.random.default_rng(7).integers(0, 200, image.shape)
    frame = pcl_ext.Encoder(0.001, law="native", keep_points=True).encode(points)
    decoder = pcl_ext.Decoder()
    decoded = decoder.decode(frame)
    there = ~np.isnan(points["x"])
    np.testing.assert_allclose(decoded["intensity"][there], points["intensity"][there], atol=0.5)
    scores = pcl_ext.OutlierRemoval("voxels").score(decoder)
    np.testing.assert_array_equal(np.isnan(scores), ~there)
    least = float(np.nanmedian(scores))
    removal = pcl_ext.OutlierRemoval("voxels", min_log_odds=least)
    kept = pcl_ext.Decoder().decode(frame, outliers=removal)
    stays = scores >= least
    assert kept.shape == decoded.shape
    assert 0 < stays.sum() < there.sum()
    np.testing.assert_array_equal(np.isnan(kept["x"]), ~stays)
    np.testing.assert_array_equal(kept[stays], decoded[stays])
