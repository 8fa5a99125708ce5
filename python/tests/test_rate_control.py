# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Rate control: the budget over the stamps of the clouds is kept, and what is said of it."""

import numpy as np
import pytest

import pcl_ext

RATE = 100e3  # bits a second


def noisy_wall(random, size):
    return np.column_stack(
        (random.uniform(-1, 1, size), random.uniform(-1, 1, size), random.normal(2, 0.02, size))
    ).astype(np.float32)


@pytest.mark.filterwarnings("ignore:the cloud was left out")
def test_no_second_takes_more_than_the_rate(random):
    encoder = pcl_ext.Encoder(resolution=0.02, max_rate=RATE, frame_id="lidar")
    decoder = pcl_ext.Decoder()
    sent = []
    for i in range(150):
        size = 20000 if i % 50 == 49 else 3000 if i < 100 else 500
        frame = encoder.encode(noisy_wall(random, size), stamp=1 + i / 10)
        if not frame:
            assert frame == b""
            assert "the cloud was left out, as max_rate of 100 kbit/s has room for" in (
                encoder.warning
            )
            continue
        decoder.decode(frame)
        sent.append((i, 8 * len(frame)))
        assert sum(bits for j, bits in sent if j > i - 10) <= RATE
    status = encoder.rate_control
    assert status.max_rate == RATE
    assert 0 < status.used_rate <= RATE
    assert status.clouds_left_out == 150 - len(sent) > 0
    assert status.changes > 0
    assert status.step <= status.last_step
    assert status.choice.startswith(f"voxels of {status.resolution:g} m, effort ")


def test_a_rate_set_before_the_first_cloud_holds(room):
    encoder = pcl_ext.Encoder(max_rate=1e9)
    encoder.set_max_rate(1e3)
    assert encoder.rate_control.max_rate == 1e3
    with pytest.warns(pcl_ext.CompressionWarning, match="the cloud was left out, as max_rate"):
        assert encoder.encode(room) == b""
    assert encoder.rate_control.clouds_left_out == 1


def test_a_rate_needs_one_to_change():
    encoder = pcl_ext.Encoder(max_encode_ms=5)
    with pytest.raises(ValueError, match="the Encoder has no max_rate"):
        encoder.set_max_rate(1e6)
    with pytest.raises(TypeError, match="bits_per_second is 'x'; it must be a number"):
        pcl_ext.Encoder(max_rate=RATE).set_max_rate("x")


@pytest.mark.parametrize("rate", [0, 999, -1e6, 1e13, float("nan")])
def test_bad_rates_are_refused(rate):
    encoder = pcl_ext.Encoder(max_rate=RATE)
    with pytest.raises(
        ValueError,
        match=f"bits_per_second is {rate}; it must be a number from 1e3 to 1e12",
    ):
        encoder.set_max_rate(rate)
    assert encoder.rate_control.max_rate == RATE
