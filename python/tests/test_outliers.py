# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Outlier removal with frames of a decoder or an encoder."""

import numpy as np
import pytest

import pcl_ext


def noisy_wall(random):
    """A dense wall, and single points in front of it: the cloud and which are noise."""
    wall = np.column_stack(
        (random.uniform(-1, 1, 30000), random.uniform(-1, 1, 30000), np.full(30000, 2.02))
    )
    noise = random.uniform((-1, -1, 0.5), (1, 1, 1.8), (40, 3))
    return np.vstack((wall, noise)).astype("f4")


@pytest.mark.parametrize("min_log_odds", [-2.0, 0.0, 2.5])
@pytest.mark.parametrize("keep_points", [False, True])
def test_scores_decide_what_stays(random, min_log_odds, keep_points):
    encoder = pcl_ext.Encoder(0.04, law="count", keep_points=keep_points)
    scoring = pcl_ext.OutlierRemoval("points")
    removal = pcl_ext.OutlierRemoval("points", min_log_odds=min_log_odds)
    decoder = pcl_ext.Decoder()
    filtering = pcl_ext.Decoder()
    for _ in range(3):
        frame = encoder.encode(noisy_wall(random))
        cloud = decoder.decode(frame)
        log_odds = scoring.score(decoder)
        assert log_odds.dtype == np.float32 and log_odds.shape == cloud.shape
        assert scoring.removed == 0
        kept = filtering.decode(frame, outliers=removal)
        np.testing.assert_array_equal(kept, cloud[log_odds >= min_log_odds])


@pytest.mark.parametrize("keep_points", [False, True])
def test_rays_begin_at_the_sensor(random, keep_points):
    encoder = pcl_ext.Encoder(0.04, law="count", keep_points=keep_points)
    frame = encoder.encode(noisy_wall(random))
    voxels = {}
    for name, settings in {
        "near": {},
        "far": {"sensor_position": (0.0, 0.0, -60.0)},
        "dense": {"azimuth_step": 0.001, "elevation_step": 0.001},
        "counts": {"intensities_are_counts": True},
    }.items():
        removal = pcl_ext.OutlierRemoval("rays", **settings)
        assert removal.unit == "rays"
        decoder = pcl_ext.Decoder()
        decoder.decode(frame)
        voxels[name] = removal.score(decoder)
        assert removal.status.ok and removal.status.message == ""
    assert (voxels["far"] >= voxels["near"]).all()
    assert (voxels["far"] > 0).all() and (voxels["near"] < 0).any()
    assert (voxels["dense"] <= voxels["near"]).all()
    same = np.array_equal(voxels["counts"], voxels["near"])
    assert same == keep_points


def test_unit_is_that_of_the_last_frame(random):
    removal = pcl_ext.OutlierRemoval()
    assert removal.unit == "automatic"
    frame = pcl_ext.Encoder(0.04, law="none").encode(noisy_wall(random))
    pcl_ext.Decoder().decode(frame, outliers=removal)
    assert removal.unit == "voxels"


def test_removal_before_encoding_saves_bytes(random):
    cloud = noisy_wall(random)
    removal = pcl_ext.OutlierRemoval("points")
    frame = pcl_ext.Encoder(0.04, law="count").encode(cloud, outliers=removal)
    assert removal.removed > 0
    decoded = pcl_ext.Decoder().decode(frame)
    complete = pcl_ext.Encoder(0.04, law="count").encode(cloud)
    assert len(frame) < len(complete)
    at_receiver = pcl_ext.Decoder().decode(complete, outliers=pcl_ext.OutlierRemoval("points"))
    np.testing.assert_array_equal(decoded, at_receiver)


def test_minimum_after_outliers(random):
    frame = pcl_ext.Encoder(0.04, law="count").encode(noisy_wall(random))
    kept = pcl_ext.Decoder().decode(frame, outliers=pcl_ext.OutlierRemoval("points"))
    both = pcl_ext.Decoder().decode(
        frame, outliers=pcl_ext.OutlierRemoval("points"), min_intensity=10
    )
    np.testing.assert_array_equal(both, kept[kept["intensity"] >= 10])
    assert 0 < len(both) < len(kept)


def test_what_cannot_be_judged_stays(random):
    cloud = noisy_wall(random)
    removal = pcl_ext.OutlierRemoval("points")
    coarse = pcl_ext.Encoder(0.5, law="none").encode(cloud)
    everything = pcl_ext.Decoder().decode(coarse)
    np.testing.assert_array_equal(pcl_ext.Decoder().decode(coarse, outliers=removal), everything)
    assert removal.status.code == "UnsupportedResolution" and removal.status.message
    assert not removal.status.ok
    frame = pcl_ext.Encoder(0.04, law="none").encode(cloud)
    decoder = pcl_ext.Decoder()
    assert len(decoder.decode(frame, outliers=removal)) == decoder.statistics.voxels
    assert removal.status.code == "NoDensities"
    assert np.isposinf(removal.score(decoder)).all()


def test_history_and_reset(random):
    """A place that was occupied before helps a point there, until it is forgotten."""
    cloud = noisy_wall(random)
    encoder = pcl_ext.Encoder(0.04, law="count", i_frame_rate=1)
    decoder = pcl_ext.Decoder()
    removal = pcl_ext.OutlierRemoval("points")
    decoder.decode(encoder.encode(cloud))
    fresh = removal.score(decoder)
    decoder.decode(encoder.encode(cloud))
    used = removal.score(decoder)
    assert len(used) == len(fresh)
    removal.reset()
    np.testing.assert_array_equal(removal.score(decoder), fresh)


def test_before_any_frame():
    removal = pcl_ext.OutlierRemoval()
    assert removal.status == pcl_ext.Status() and removal.removed == 0
    assert removal.score(pcl_ext.Decoder()).shape == (0,)


def test_wrong_objects(room):
    with pytest.raises(TypeError):
        pcl_ext.Encoder().encode(room, outliers=5)
    with pytest.raises(TypeError):
        pcl_ext.OutlierRemoval().score(None)
