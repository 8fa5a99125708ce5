# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Several threads: others run while one codes, and an object may be shared."""

import sys
import threading

import numpy as np
import pytest

import pcl_ext


@pytest.fixture
def large(random):
    return random.uniform(-5, 5, (200000, 3)).astype("f4")


def runs_meanwhile(work):
    """True if this thread runs while another is within a call of work().

    Threads take turns only where one lets the others run: the interval after which Python
    makes them is an hour.
    """
    state = []

    def run():
        state.append("begun")
        work()
        state.append("done")

    interval = sys.getswitchinterval()
    sys.setswitchinterval(3600)
    try:
        thread = threading.Thread(target=run)
        thread.start()
        # Only runs once the other thread waits, ends, or lets others run.
        seen = list(state)
        thread.join()
    finally:
        sys.setswitchinterval(interval)
    return seen == ["begun"]


def is_seen_to_run(work):
    """The operating system decides when a thread runs, so that one trial may miss it."""
    return any(runs_meanwhile(work) for _ in range(200))


def test_a_loop_does_not_let_others_run():
    """What the following tests rely on."""
    assert not any(runs_meanwhile(lambda: sum(range(100000))) for _ in range(20))


def test_others_run_while_encoding(large):
    encoder = pcl_ext.Encoder(0.02)
    assert is_seen_to_run(lambda: encoder.encode(large))


def test_others_run_while_decoding(large):
    frame = pcl_ext.Encoder(0.02, i_frame_rate=1).encode(large)
    decoder = pcl_ext.Decoder()
    assert is_seen_to_run(lambda: decoder.decode(frame))
    removal = pcl_ext.OutlierRemoval("voxels")
    decoder.decode(frame)
    assert is_seen_to_run(lambda: removal.score(decoder))


def test_threads_of_an_encoder_do_not_change_its_bytes(large):
    one = pcl_ext.Encoder(0.02)
    four = pcl_ext.Encoder(0.02, threads=4)
    for cloud in (large, large[::-1], large[:1000]):
        assert one.encode(cloud) == four.encode(cloud)


def in_threads(count, work):
    failures = []

    def run(number):
        try:
            work(number)
        except BaseException as failure:  # to be raised by the test
            failures.append(failure)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if failures:
        raise failures[0]


def test_an_encoder_of_several_threads(room):
    """One stream: each frame has a number of its own, and I-frames decode alone."""
    encoder = pcl_ext.Encoder(0.1, bounding_box=((-2, -2, 0), (2, 2, 3)), i_frame_rate=7)
    frames = []

    def encode(number):
        for turn in range(30):
            frames.append(encoder.encode(room[number * 500 + turn :]))
            assert encoder.statistics.voxels > 0
            if turn == 10:
                encoder.request_i_frame()

    in_threads(4, encode)
    assert encoder.statistics.frame_number == 120
    decoded_alone = {}
    for frame in frames:
        decoder = pcl_ext.Decoder()
        if decoder.decode(frame) is None:
            assert decoder.status.code == "MissingReference"
        else:
            decoded_alone[decoder.statistics.frame_number] = frame
    # Those of the rate, except for what the requests of I-frames moved.
    assert 120 // 7 <= len(decoded_alone) <= 120 // 7 + 5


def test_a_decoder_and_a_filter_of_several_threads(room):
    encoder = pcl_ext.Encoder(0.1, law="count", i_frame_rate=1)
    frames = [encoder.encode(room[number * 100 :]) for number in range(20)]
    expected = {len(pcl_ext.Decoder().decode(frame, min_intensity=2)): frame for frame in frames}
    decoder = pcl_ext.Decoder()
    removal = pcl_ext.OutlierRemoval("points", min_log_odds=-1e30)

    def decode(number):
        for frame in frames[number % 3 :: 2] * 5:
            cloud = decoder.decode(frame, outliers=removal, min_intensity=2)
            assert cloud is None or len(cloud) in expected
            assert removal.score(decoder).dtype == np.float32
            assert removal.status.code
            removal.reset()
            assert decoder.statistics.voxels >= 0 and decoder.stamp is None

    in_threads(4, decode)


def test_streams_in_threads_of_their_own(room):
    """Instances share nothing: the same frames as one after the other."""

    def stream(number):
        encoder = pcl_ext.Encoder(0.05 + 0.01 * number)
        return [encoder.encode(room + np.float32(0.01 * turn)) for turn in range(10)]

    results = [None] * 6

    def work(number):
        results[number] = stream(number)

    in_threads(6, work)
    assert results == [stream(number) for number in range(6)]


def test_a_recording_of_several_threads(room, tmp_path):
    """Each frame comes once, to one of the threads; writers may share a file, too."""
    path = tmp_path / "cell.mcap"
    with pcl_ext.RecordingWriter(path) as writer:

        def write(number):
            encoder = pcl_ext.Encoder(0.1)
            stream = writer.add_stream(f"/sensor_{number}")
            for turn in range(25):
                writer.append(stream, encoder.encode(room[turn:]), turn + 0.1 * number)

        in_threads(4, write)
    recording = pcl_ext.open(path)
    assert [stream.frames for stream in recording.streams] == [25] * 4
    seen = []

    def read(number):
        for frame in recording:
            assert recording.frame(frame.stream, frame.number) is not None
            seen.append((frame.time, frame.stream, frame.number))

    in_threads(4, read)
    assert len(set(seen)) == len(seen) == 100
