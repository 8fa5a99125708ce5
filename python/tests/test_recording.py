# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Recordings that are written and read, damaged ones, and wrong arguments."""

import os
import pathlib

import numpy as np
import pytest

import pcl_ext

EPOCH = 1700000000.123457


def frames_of(room, count, **settings):
    encoder = pcl_ext.Encoder(
        0.1,
        law="count",
        bounding_box=((-2, -2, 0), (3, 2, 4)),
        i_frame_rate=4,
        **settings,
    )
    return [
        encoder.encode(room + np.float32(0.02 * frame), stamp=EPOCH + frame)
        for frame in range(count)
    ]


def decoded(frames):
    decoder = pcl_ext.Decoder()
    return [decoder.decode(frame) for frame in frames]


@pytest.fixture
def two_streams(room, tmp_path):
    """An MCAP file of two streams, and their frames: the second's half as often."""
    path = tmp_path / "cell.mcap"
    frames = [frames_of(room, 12), frames_of(room * np.float32(0.5), 6, effort="fast")]
    with pcl_ext.RecordingWriter(path) as writer:
        first = writer.add_stream("/left", frame_id="cell", metadata={"side": "left"})
        second = writer.add_stream("/right")
        assert (first, second) == (0, 1)
        for number in range(12):
            writer.append(first, frames[0][number], EPOCH + 0.05 * number)
            if number % 2 == 0:
                writer.append(second, frames[1][number // 2], EPOCH + 0.05 * number + 0.01)
    return path, frames


def test_what_is_written_is_read(two_streams):
    path, frames = two_streams
    assert list(path.parent.iterdir()) == [path]
    with pcl_ext.open(path) as recording:
        left, right = recording.streams
        assert (left.name, left.frames, left.has_times) == ("/left", 12, True)
        assert left.metadata["side"] == "left"
        assert left.first_time == EPOCH and right.frames == 6
        assert left.last_time == pytest.approx(EPOCH + 0.55, abs=1e-6)
        seen = [[], []]
        times = []
        for frame in recording:
            assert frame.number == len(seen[frame.stream])
            assert frame.is_i_frame == (frame.number % 4 == 0)
            assert recording.time_of(frame.stream, frame.number) == frame.time
            seen[frame.stream].append(frame.data)
            times.append(frame.time)
        assert seen == frames
        assert times == sorted(times)
        assert next(recording, None) is None
        assert recording.damage == [] and not recording.is_unfinished
        assert recording.file_bytes == path.stat().st_size
        assert recording.read("/left", 3).frame_id == "cell"


def test_frames_in_any_order(two_streams, random):
    path, frames = two_streams
    expected = [decoded(of_stream) for of_stream in frames]
    recording = pcl_ext.open(path)
    places = [(0, number) for number in range(12)] + [(1, number) for number in range(6)]
    for index in [*range(18), *random.permutation(18)]:
        stream, number = places[index]
        cloud = recording.frame(stream, number)
        assert recording.status == pcl_ext.Status()
        np.testing.assert_array_equal(cloud, expected[stream][number])
        assert recording.read(stream, number).data == frames[stream][number]
    np.testing.assert_array_equal(recording.frame("/right", 5), expected[1][5])


def test_clouds_of_streams_by_time(two_streams):
    path, frames = two_streams
    expected = [decoded(of_stream) for of_stream in frames]
    in_order = [
        (place.time, ("/left", "/right")[place.stream], expected[place.stream][place.number])
        for place in pcl_ext.open(path)
    ]

    def assert_clouds(clouds, wanted):
        seen = list(clouds)
        assert [row[:2] for row in seen] == [row[:2] for row in wanted]
        for (*_, cloud), (*_, decoded_by_hand) in zip(seen, wanted):
            assert type(cloud) is pcl_ext.Cloud
            np.testing.assert_array_equal(cloud, decoded_by_hand)

    assert len(in_order) == 18
    assert_clouds(pcl_ext.open(path).clouds(), in_order)
    recording = pcl_ext.open(path)
    right = [row for row in in_order if row[1] == "/right"]
    assert_clouds(recording.clouds("/right"), right)
    assert_clouds(recording.clouds(1), right)
    assert_clouds(recording.clouds(["/right", 0, 1]), in_order)
    assert_clouds(recording.clouds([]), [])
    # From a P-frame on, and before the time of a frame.
    start, end = in_order[7][0], in_order[12][0]
    assert_clouds(recording.clouds(start=start, end=end), in_order[7:12])
    assert_clouds(recording.clouds(start=start + 2e-6, end=end + 2e-6), in_order[8:13])
    # Two at once, which an iteration over the recording does not disturb.
    pairs = list(zip(recording.clouds(), recording.clouds(), recording))
    assert [first[:2] for first, _, _ in pairs] == [row[:2] for row in in_order]
    assert_clouds((second for _, second, _ in pairs), in_order)


def test_clouds_of_the_same_time_follow_the_streams(room, tmp_path):
    frame = frames_of(room, 1)[0]
    with pcl_ext.RecordingWriter(tmp_path / "cell.mcap") as writer:
        streams = [writer.add_stream(name) for name in ("/b", "/a")]
        for time in (EPOCH, EPOCH + 1):
            for stream in reversed(streams):
                writer.append(stream, frame, time)
    clouds = pcl_ext.open(tmp_path / "cell.mcap").clouds(["/a", "/b"])
    assert [(time, name) for time, name, _ in clouds] == [
        (EPOCH, "/b"), (EPOCH, "/a"), (EPOCH + 1, "/b"), (EPOCH + 1, "/a")]


def test_clouds_that_are_damaged_are_left_out(room, tmp_path):
    """A P-frame of the first stream is missing, as if it had been lost before."""
    path = tmp_path / "cell.mcap"
    frames = frames_of(room, 8)
    with pcl_ext.RecordingWriter(path) as writer:
        streams = [writer.add_stream("/left"), writer.add_stream("/right")]
        for number, frame in enumerate(frames):
            if number != 1:
                writer.append(streams[0], frame, EPOCH + number)
            writer.append(streams[1], frame, EPOCH + number)
    with pytest.warns(pcl_ext.RecordingWarning) as warned:
        seen = [(time - EPOCH, name) for time, name, _ in pcl_ext.open(path).clouds()]
    assert [round(time) for time, name in seen if name == "/left"] == [0, 4, 5, 6, 7]
    assert [round(time) for time, name in seen if name == "/right"] == list(range(8))
    first, total = warned
    assert "frame 1 of /left at 1700000002.123457 s" in str(first.message)
    assert str(total.message) == "2 frames of /left were left out"
    assert {warning.filename for warning in warned} == {__file__}


def test_clouds_of_a_file_that_was_cut_off(two_streams):
    path, frames = two_streams
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.warns(pcl_ext.RecordingWarning, match="cell.mcap: .*the file ends"):
        seen = list(pcl_ext.open(path).clouds("/left"))
    assert 0 < len(seen) < 12
    for (*_, cloud), expected in zip(seen, decoded(frames[0])):
        np.testing.assert_array_equal(cloud, expected)


def test_times_of_streams_without_times(room, tmp_path):
    path = tmp_path / "frames.pcxi"
    encoder = pcl_ext.Encoder(0.1)
    path.write_bytes(b"".join(encoder.encode(room) for _ in range(3)))
    recording = pcl_ext.open(path)
    assert len(list(recording.clouds())) == 3
    for limits in ({"start": 1}, {"end": 1}):
        with pytest.raises(ValueError, match="frames has no times for start and end"):
            recording.clouds(**limits)


def test_a_stamp_of_0_is_no_time(room, tmp_path):
    """As without one, also beside the name of a coordinate frame, which frames carry then."""
    path = tmp_path / "frames.pcxi"
    for stamps in ([0.0, 0.0], [None, None], [None, 7.0, 0.0]):
        encoder = pcl_ext.Encoder(0.1, frame_id="cell")
        path.write_bytes(b"".join(encoder.encode(room, stamp=stamp) for stamp in stamps))
        recording = pcl_ext.open(path)
        frames = list(recording)
        assert [frame.stamp for frame in frames] == [stamp or None for stamp in stamps]
        assert [frame.frame_id for frame in frames] == ["cell"] * len(stamps)
        assert recording.streams[0].has_times == (7.0 in stamps)
        if 7.0 in stamps:
            assert [frame.time for frame in frames] == [0.0, 7.0, 7.0]
        else:
            with pytest.raises(ValueError, match="no times for start and end"):
                recording.clouds(start=1)


def test_clouds_of_streams_that_are_none(two_streams):
    recording = pcl_ext.open(two_streams[0])
    for streams, error in (("/middle", KeyError), (2, IndexError), (["/left", 1.5], TypeError),
                           (b"/left", TypeError)):
        with pytest.raises(error):
            recording.clouds(streams)
    for limit in ("start", "end"):
        with pytest.raises(ValueError, match=f"{limit} is -1"):
            recording.clouds(**{limit: -1})


def test_noise_is_removed(two_streams):
    path, frames = two_streams
    recording = pcl_ext.open(path)
    removal = pcl_ext.OutlierRemoval("points")
    same_removal = pcl_ext.OutlierRemoval("points")
    decoder = pcl_ext.Decoder()
    for number, frame in enumerate(frames[0]):
        cloud = recording.frame(0, number, outliers=removal, min_intensity=2)
        expected = decoder.decode(frame, outliers=same_removal, min_intensity=2)
        np.testing.assert_array_equal(cloud, expected)


@pytest.mark.parametrize(
    "metadata, unit",
    [
        ({"intensity_law": "count"}, "points"),
        ({"intensity_law": "count", "sensor": "lidar"}, "voxels"),
        ({"intensity_law": "quadratic"}, "faces"),
        ({"intensity_law": "?"}, "voxels"),
        ({}, "voxels"),
    ],
)
def test_noise_is_judged_by_the_law_of_the_recording(tmp_path, random, metadata, unit):
    encoder = pcl_ext.Encoder(0.04, law="count", colour_bits=0)
    path = tmp_path / "x.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        stream = writer.add_stream("/camera", metadata=metadata)
        for i in range(2):
            writer.append(stream, encoder.encode(random.uniform(0, 1, (5000, 3))), time=i)
    recording = pcl_ext.open(path)
    removal = pcl_ext.OutlierRemoval()
    named = pcl_ext.OutlierRemoval(unit)
    for i in range(2):
        cloud = recording.frame(0, i, outliers=removal)
        np.testing.assert_array_equal(cloud, recording.frame(0, i, outliers=named))
        assert removal.unit == unit
    removal.reset()
    assert removal.unit == "automatic"


def test_a_unit_that_does_not_fit_the_law_of_the_recording_is_refused(tmp_path, random):
    path = tmp_path / "x.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        stream = writer.add_stream("/camera", metadata={"intensity_law": "count"})
        encoder = pcl_ext.Encoder(0.04, law="count", colour_bits=0)
        writer.append(stream, encoder.encode(random.uniform(0, 1, (100, 3))), time=0)
    message = "unit is 'faces' and the intensity_law of the stream is count, whose intensities"
    with pytest.raises(ValueError, match=message):
        pcl_ext.open(path).frame(0, 0, outliers=pcl_ext.OutlierRemoval("faces"))


def test_seek(two_streams):
    path, _ = two_streams
    recording = pcl_ext.open(path)
    every = list(recording)
    for index, frame in enumerate(every):
        recording.seek(frame.time)
        assert list(recording) == every[index:]
        recording.seek(frame.time + 2e-6)
        assert list(recording) == every[index + 1 :]
    recording.seek(0)
    assert next(recording) == every[0]
    recording.seek(EPOCH + 100)
    assert list(recording) == []


def test_frame_at(two_streams):
    path, _ = two_streams
    recording = pcl_ext.open(path)
    for stream in (0, 1):
        for number in range(recording.streams[stream].frames):
            time = recording.time_of(stream, number)
            assert recording.frame_at(stream, time) == number
            assert recording.frame_at(stream, time + 0.001) == number
            before = recording.frame_at(stream, time - 3e-6)
            assert before == (number - 1 if number > 0 else None)
    assert recording.frame_at("/right", EPOCH + 1e6) == 5


def test_a_file_of_frames(room, tmp_path):
    """.pcxi: the frames one after the other, whoever writes them."""
    frames = frames_of(room, 6)
    path = tmp_path / "sensor.pcxi"
    with pcl_ext.RecordingWriter(path) as writer:
        stream = writer.add_stream("sensor")
        for frame in frames:
            writer.append(stream, frame, 0.0)
    assert path.read_bytes() == b"".join(frames)
    recording = pcl_ext.open(path)
    assert [frame.data for frame in recording] == frames
    assert recording.streams[0].frames == 6
    assert recording.read(0, 5).stamp == EPOCH + 5
    for number, expected in enumerate(decoded(frames)):
        np.testing.assert_array_equal(recording.frame(0, number), expected)


def test_damage_is_listed(two_streams):
    """What can be read of a file that was cut off, and where it broke."""
    path, frames = two_streams
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    recording = pcl_ext.open(path)
    read = [frame.data for frame in recording]
    assert 0 < len(read) < 18 and set(read) < set(frames[0] + frames[1])
    assert recording.is_unfinished
    (damage,) = recording.damage
    assert "the file ends" in damage.message and damage.offset <= len(whole)
    path.write_bytes(whole[:20])
    with pytest.raises(pcl_ext.Error, match="cell.mcap") as raised:
        pcl_ext.open(path)
    assert raised.value.code == "NotARecording"


@pytest.mark.filterwarnings("ignore::pcl_ext.CompressionWarning")
def test_limits_are_those_of_a_frame(tmp_path):
    random = np.random.default_rng(1)
    places = np.argwhere(random.random((130, 130, 130)) < 0.5).astype(np.float32)
    assert len(places) > 2**20
    frame = pcl_ext.Encoder(0.04, effort="fast", law="none").encode(0.04 * places + 0.02)
    with pcl_ext.RecordingWriter(tmp_path / "large.pcxi") as writer:
        writer.append(writer.add_stream("/large"), frame, EPOCH)
    assert len(pcl_ext.open(tmp_path / "large.pcxi").frame(0, 0)) == len(places)
    limited = pcl_ext.open(tmp_path / "large.pcxi", max_voxels=1000000)
    assert limited.frame(0, 0) is None
    assert limited.status.code == "LimitExceeded"


def test_files_that_are_none(tmp_path):
    with pytest.raises(FileNotFoundError, match="no_such.mcap"):
        pcl_ext.open(tmp_path / "no_such.mcap")
    for content in (b"", b"some text", b"# .PCD v0.7\nVERSION 0.7\n"):
        other = tmp_path / "other"
        other.write_bytes(content)
        with pytest.raises(pcl_ext.Error, match="other") as raised:
            pcl_ext.open(other)
        assert raised.value.code == "NotARecording"
    with pytest.raises(pcl_ext.Error, match="folder"):
        (tmp_path / "folder").mkdir()
        pcl_ext.open(tmp_path / "folder")
    with pytest.raises(TypeError):
        pcl_ext.open(5)
    with pytest.raises(ValueError, match="max_voxels is 0"):
        pcl_ext.open(other, max_voxels=0)


def test_frames_that_are_none(two_streams):
    recording = pcl_ext.open(two_streams[0])
    for call in (recording.read, recording.frame, recording.time_of):
        for place in ((0, 12), (0, -1), (2, 0), (-1, 0)):
            with pytest.raises(IndexError):
                call(*place)
        with pytest.raises(KeyError, match="/middle.*/left, /right"):
            call("/middle", 0)
        for place in ((0, 1.5), (None, 0), (0, "1")):
            with pytest.raises(TypeError, match="it must be a whole number"):
                call(*place)
    assert recording.time_of(np.int64(1), np.uint8(2)) == recording.time_of(1, 2)
    for time in (-1.0, np.nan, 1e10, "noon"):
        with pytest.raises(ValueError, match="time is"):
            recording.seek(time)
        with pytest.raises(ValueError, match="time is"):
            recording.frame_at(0, time)


def test_what_is_closed(two_streams):
    with pcl_ext.open(two_streams[0]) as recording:
        pass
    for call in (
        lambda: next(recording),
        lambda: recording.frame(0, 0),
        lambda: recording.read(0, 0),
        lambda: recording.seek(1.0),
        lambda: recording.damage,
        lambda: recording.file_bytes,
    ):
        with pytest.raises(ValueError, match="the recording is closed"):
            call()
    recording.close()
    assert len(recording.streams) == 2


def test_wrong_frames_and_streams(room, tmp_path):
    frame = frames_of(room, 1)[0]
    path = tmp_path / "cell.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        stream = writer.add_stream("/left")
        for name, message in (("/left", "two streams of the name"), ("", "needs a name")):
            with pytest.raises(ValueError, match=message):
                writer.add_stream(name)
        # A cloud that max_rate left out.
        writer.append(stream, b"", 1.0)
        for data in (b"no frame", frame[:-1], frame + b"x"):
            with pytest.raises(ValueError, match="the bytes are not one frame"):
                writer.append(stream, data, 1.0)
        for data in (frame, b""):
            with pytest.raises(ValueError, match="unknown stream"):
                writer.append(7, data, 1.0)
        for time in (-0.1, np.nan, 1.7e18, 10**400, "1", np.array("1")):
            with pytest.raises(ValueError, match="time is"):
                writer.append(stream, frame, time)
        with pytest.raises(TypeError, match="it must be bytes"):
            writer.append(stream, "text", 1.0)
        with pytest.raises(TypeError, match="stream is 'a'; it must be a whole number"):
            writer.append("a", frame, 1.0)
        with pytest.raises(ValueError, match="stream is -1"):
            writer.append(-1, frame, 1.0)
        with pytest.raises(TypeError, match="5 is not a str"):
            writer.add_stream("/b", metadata={"pose": 5})
        with pytest.raises(TypeError, match="metadata is 5; it must be a dict of str"):
            writer.add_stream("/b", metadata=5)
        with pytest.raises(ValueError, match="name is .* that UTF-8 has"):
            writer.add_stream("\ud800")
        with pytest.raises(TypeError, match="None is not a str"):
            writer.add_stream("/b", frame_id=None)
        writer.append(stream, bytearray(frame), 1.0)
        writer.flush()
    assert [frame.data for frame in pcl_ext.open(path)] == [frame]
    for data in (frame, b""):
        with pytest.raises(ValueError, match="the recording is finished"):
            writer.append(stream, data, 2.0)
    writer.finish()
    with pcl_ext.RecordingWriter(tmp_path / "one.pcxi") as writer:
        writer.append(writer.add_stream("a"), frame, 0)
        with pytest.raises(ValueError, match="one stream"):
            writer.add_stream("b")


def test_an_exception_leaves_an_unfinished_file(room, tmp_path):
    path = tmp_path / "cell.mcap"
    frame = frames_of(room, 1)[0]
    with pytest.raises(RuntimeError, match="mine"):
        with pcl_ext.RecordingWriter(path) as writer:
            writer.append(writer.add_stream("/left"), frame, 1.0)
            raise RuntimeError("mine")
    assert not path.exists()
    (unfinished,) = tmp_path.iterdir()
    assert unfinished.name.startswith("cell.mcap") and "unfinished" in unfinished.name
    recording = pcl_ext.open(unfinished)
    assert [frame.data for frame in recording] == [frame]
    assert recording.is_unfinished
    with pytest.warns(pcl_ext.RecordingWarning, match="no orderly end"):
        assert len(list(recording.clouds())) == 1


def test_places_that_cannot_be_written(tmp_path):
    with pytest.raises(pcl_ext.Error, match="no_such_folder") as raised:
        pcl_ext.RecordingWriter(tmp_path / "no_such_folder" / "cell.mcap")
    assert raised.value.code == "OutputFailed"
    (tmp_path / "file").touch()
    os.mkfifo(tmp_path / "pipe.pcxi")
    for path, message in (
        (tmp_path, "the folder .* exists"),
        (tmp_path / "file", "is a file; a name without an extension is a folder"),
        (tmp_path / "pipe.pcxi", "is no file or folder"),
        ("/dev/null", "is no file or folder"),
    ):
        with pytest.raises(pcl_ext.Error, match=message):
            pcl_ext.RecordingWriter(path, overwrite=True)
    for name in ("x.PCXI", "x.bag", "x.mcap.zstd"):
        with pytest.raises(ValueError, match=f"{name}' is no kind of output: name x.pcxi"):
            pcl_ext.RecordingWriter(tmp_path / name)
    with pytest.raises(ValueError, match="byte of 0"):
        pcl_ext.RecordingWriter(f"{tmp_path}/nu\0l")
    with pytest.raises(TypeError):
        pcl_ext.RecordingWriter(None)
    with pytest.raises(TypeError, match="overwrite is 1; it must be True or False"):
        pcl_ext.RecordingWriter(tmp_path / "x.mcap", overwrite=1)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "pipe.pcxi"]


@pytest.mark.parametrize("name", ["cell.mcap", "cell.pcxi", "cell"])
def test_an_existing_recording_stays_unless_it_may_be_replaced(room, tmp_path, name):
    path = tmp_path / name
    frames = frames_of(room, 2)

    def write(frame, **settings):
        with pcl_ext.RecordingWriter(path, **settings) as writer:
            writer.append(writer.add_stream("/a"), frame, EPOCH)

    def recorded():
        return [frame.data for frame in pcl_ext.open(path)]

    write(frames[0])
    is_folder = path.is_dir()
    assert is_folder == (name == "cell")
    message = "exists: name another output, or "
    with pytest.raises(pcl_ext.Error, match=message + ("remove" if is_folder else "replace")):
        write(frames[0], overwrite=is_folder)
    assert recorded() == frames[:1] and list(tmp_path.iterdir()) == [path]
    if not is_folder:
        other = frames_of(room * np.float32(0.5), 1)[0]
        write(other, overwrite=True)
        assert recorded() == [other]
        # Nor is one replaced that came while this one was written.
        path.unlink()
        writer = pcl_ext.RecordingWriter(path)
        writer.append(writer.add_stream("/a"), frames[0], EPOCH)
        write_beside = path.write_bytes(b"of somebody else")
        with pytest.raises(pcl_ext.Error, match="File exists"):
            writer.finish()
        assert path.stat().st_size == write_beside


def test_names_that_are_no_text(room, tmp_path):
    """A file name of any bytes."""
    path = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.mcap")
    with pcl_ext.RecordingWriter(path) as writer:
        writer.append(writer.add_stream("/left"), frames_of(room, 1)[0], 1.0)
    assert len(list(pcl_ext.open(path))) == 1
    pathlib.Path(path).write_bytes(b"text")
    with pytest.raises(pcl_ext.Error):
        pcl_ext.open(path)


def test_a_stream_without_frames_has_no_frame_0(room, tmp_path):
    with pcl_ext.RecordingWriter(tmp_path / "a.mcap") as writer:
        writer.add_stream("/empty")
        writer.append(writer.add_stream("/full"), frames_of(room, 1)[0], EPOCH)
    recording = pcl_ext.open(tmp_path / "a.mcap")
    assert recording.frame_at("/empty", EPOCH) is None
    for call in (recording.frame, recording.read, recording.time_of):
        with pytest.raises(IndexError, match="0 frames"):
            call("/empty", 0)
