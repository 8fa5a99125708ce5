# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Changes that a decoder tells add up to what another one decodes as a whole."""

import numpy as np

import pcl_ext


def voxels_of(cloud):
    """Positions with all that the points have."""
    return {(p["x"], p["y"], p["z"]): p.tolist()[3:] for p in cloud}


def test_changes_add_up(room):
    random = np.random.default_rng(3)
    colours = random.integers(0, 256, (len(room), 3)).astype(np.uint8)
    for rgb in (None, colours):
        encoder = pcl_ext.Encoder(0.1, law="count", effort="fast", i_frame_rate=5)
        whole = pcl_ext.Decoder()
        decoder = pcl_ext.Decoder()
        voxels = {}
        for i in range(12):
            kept = random.random(len(room)) < (0.9 if i % 4 == 3 else 0.999)
            frame = encoder.encode(room[kept], colour=None if rgb is None else rgb[kept])
            changes = decoder.decode_changes(frame)
            assert changes.is_from_nothing == (i == 0)
            gone = voxels_of(changes.gone)
            assert {key: voxels.get(key) for key in gone} == gone
            for key in gone:
                del voxels[key]
            came = voxels_of(changes.came)
            assert not voxels.keys() & came.keys()
            voxels.update(came)
            assert voxels == voxels_of(whole.decode(frame))
            assert decoder.status.code == "Ok"


def test_bytes_that_are_no_frame_have_no_changes():
    decoder = pcl_ext.Decoder()
    assert decoder.decode_changes(b"something else") is None
    assert decoder.status.code == "NoFrame"


def test_scores_are_of_the_frame_that_changed(room):
    frame = pcl_ext.Encoder(0.1, law="count").encode(room)
    whole = pcl_ext.Decoder()
    whole.decode(frame)
    decoder = pcl_ext.Decoder()
    decoder.decode_changes(frame)
    np.testing.assert_array_equal(
        pcl_ext.OutlierRemoval().score(decoder), pcl_ext.OutlierRemoval().score(whole)
    )
