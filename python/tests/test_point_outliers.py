# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Noise in the air in the clouds of a lidar."""

import numpy as np
import pytest

import pcl_ext


def room(random, flakes=60):
    """A round room seen by a lidar, and flakes in front of its wall: the cloud in rows and
    columns, and which points are flakes."""
    azimuth, slope = np.meshgrid(np.linspace(-3.1, 3.1, 512), np.linspace(-0.4, 0.4, 16))
    distance = 9.0 + np.cos(3 * azimuth) + random.normal(0, 0.005, azimuth.shape)
    is_flake = np.zeros(azimuth.shape, bool)
    is_flake.reshape(-1)[random.choice(azimuth.size, flakes, replace=False)] = True
    distance[is_flake] = random.uniform(1.5, 5, flakes)
    x, y = distance * np.cos(azimuth), distance * np.sin(azimuth)
    return np.stack((x, y, distance * slope), axis=-1).astype("f4"), is_flake


def structured(cloud, order, rings=True):
    points = np.empty(
        cloud.shape[:2],
        [("x", "f4"), ("y", "f4"), ("z", "f4")] + ([("ring", "u2")] if rings else []),
    )
    points["x"], points["y"], points["z"] = np.moveaxis(cloud, -1, 0)
    if rings:
        points["ring"] = np.arange(cloud.shape[0])[:, None]
    return points.reshape(-1)[order]


def test_flakes_are_told_from_walls(random):
    cloud, is_flake = room(random)
    removal = pcl_ext.PointOutlierRemoval()
    log_odds = removal.score(cloud)
    assert removal.status.ok and log_odds.dtype == np.float32
    assert log_odds.shape == is_flake.shape
    assert removal.removed == np.count_nonzero(log_odds < 0)
    np.testing.assert_array_equal(log_odds < 0, is_flake)


def test_rows_by_ring_or_by_direction_are_those_of_the_array(random):
    cloud, _ = room(random)
    expected = pcl_ext.PointOutlierRemoval().score(cloud).reshape(-1)
    order = random.permutation(expected.size)
    for rings in (True, False):
        removal = pcl_ext.PointOutlierRemoval()
        log_odds = removal.score(structured(cloud, order, rings))
        assert removal.status.ok
        np.testing.assert_array_equal(log_odds, expected[order])


def test_clouds_without_rows_are_not_judged(random):
    removal = pcl_ext.PointOutlierRemoval()
    log_odds = removal.score(random.normal(0, 3, (5000, 3)))
    assert np.isposinf(log_odds).all() and removal.removed == 0
    assert removal.status.code == "NoImage"
    assert removal.status.message == (
        "no point was judged: neither rows and columns, nor a field 'ring', nor the directions "
        "of the points tell the rows of a lidar that turns around z; points must be in the "
        "sensor's coordinates"
    )


def test_settings_are_checked():
    with pytest.raises(ValueError, match="min_log_odds is nan; it must be a finite number"):
        pcl_ext.PointOutlierRemoval(min_log_odds=float("nan"))


def test_encoders_take_what_judges_voxels(random):
    cloud, _ = room(random)
    with pytest.raises(TypeError, match="score\\(xyz\\) < 0 to NaN before encoding"):
        pcl_ext.Encoder().encode(cloud, outliers=pcl_ext.PointOutlierRemoval())
