# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What objects say of themselves."""

import numpy as np
import pytest

import pcl_ext


def test_encoder_and_decoder_name_their_settings_and_the_last_frame(room):
    encoder = pcl_ext.Encoder(0.1, effort="small", fields=["ring"], frame_id="hall")
    assert repr(encoder) == (
        "<Encoder(resolution=0.1, effort='small', fields=['ring'], frame_id='hall'): "
        "no frame yet>"
    )
    assert repr(pcl_ext.Encoder()) == "<Encoder(): no frame yet>"
    encoder = pcl_ext.Encoder(0.1, law="count")
    decoder = pcl_ext.Decoder(max_voxels=1 << 20)
    assert repr(decoder) == "<Decoder(max_voxels=1048576): no frame yet>"
    for kind in ("I", "P"):
        frame = encoder.encode(room)
        decoder.decode(frame)
        number = 1 if kind == "I" else 2
        voxels = encoder.statistics.voxels
        last = f"frame {number}, {kind}-frame of {voxels:,} voxels in {len(frame):,} bytes"
        assert repr(encoder) == f"<Encoder(resolution=0.1, law='count'): {last}, law 'count'>"
        assert repr(decoder) == f"<Decoder(max_voxels=1048576): {last}>"
    assert voxels > 1000
    decoder.decode(b"nothing")
    assert repr(decoder).endswith("bytes, last call: NoFrame>")


def test_long_settings_are_in_one_line():
    encoder = pcl_ext.Encoder(sensor_pose=np.eye(4), bounding_box=((0, 0, 0), (1, 1, 1)))
    text = repr(encoder)
    assert text.startswith("<Encoder(sensor_pose=array([[1.") and "\n" not in text
    assert "bounding_box=((0, 0, 0), (1, 1, 1))): no frame" in text and len(text) < 160


def test_filters_tell_what_they_did(room):
    encoder = pcl_ext.Encoder(0.04, law="count")
    decoder = pcl_ext.Decoder()
    removal = pcl_ext.OutlierRemoval("points", min_log_odds=1.5)
    before = "<OutlierRemoval(unit='points', min_log_odds=1.5): by 'points' 0 voxels of the "
    assert repr(removal) == before + "last frame removed>"
    all_voxels = len(decoder.decode(encoder.encode(room), outliers=removal))
    removed = encoder.statistics.voxels - all_voxels
    assert removed > 1
    assert f"by 'points' {removed:,} voxels of the last frame removed>" in repr(removal)
    wide = pcl_ext.OutlierRemoval("rays", azimuth_step=0.01)
    assert repr(wide).startswith("<OutlierRemoval(unit='rays', azimuth_step=0.01): ")
    points = pcl_ext.PointOutlierRemoval(use_history=False)
    assert repr(points).startswith("<PointOutlierRemoval(use_history=False): ")
    temporal = pcl_ext.TemporalVoxelFilter(4)
    assert repr(temporal) == (
        "<TemporalVoxelFilter(frames=4): 0 voxels of the last frame hidden, 0 held>"
    )


def test_clouds_tell_their_fields_and_ranges():
    points = np.zeros(3, [("x", "f4"), ("y", "f4"), ("z", "f8"), ("r", "u1"), ("n", "f4", 3)])
    points["x"] = (-1.5, np.nan, 2)
    points["z"] = np.nan
    points["r"] = (7, 0, 255)
    cloud = pcl_ext.Cloud(points)
    assert repr(cloud) == "<Cloud of 3 points: x -1.5 to 2, y 0 to 0, z, r 0 to 255, n>"
    assert repr(cloud[:0]) == "<Cloud of 0 points: x, y, z, r, n>"
    image = pcl_ext.Cloud(np.zeros((2, 5), [("x", "f4"), ("y", "f4"), ("z", "f4")]))
    assert repr(image) == ("<Cloud of 10 points in 2 x 5: x 0 to 0, y 0 to 0, z 0 to 0>")
    # What an array prints, and those of single points and fields, stay as they are.
    assert str(cloud[:1]) == str(points[:1])
    assert repr(cloud["r"]) == repr(points["r"])
    # Nor do they hide what has no fields.
    assert repr(cloud == cloud) == repr(points == points)
    assert repr(image.view("f4")) == repr(np.zeros((2, 15), "f4"))


def test_recordings_tell_their_size(room, tmp_path):
    path = tmp_path / "cell.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        for name in ("/left", "/right"):
            stream, encoder = writer.add_stream(name), pcl_ext.Encoder(0.1)
            for number in range(3):
                writer.append(stream, encoder.encode(room), 100 + number / 2)
    size = f"{path.stat().st_size:,} bytes"
    with pcl_ext.open(path) as recording:
        text = f"<Recording {str(path)!r}: 2 streams, 6 frames, 1.000 s, {size}>"
        assert repr(recording) == text
    assert repr(recording) == f"<Recording {str(path)!r}: closed>"
    cut_off = tmp_path / "cut_off.mcap"
    cut_off.write_bytes(path.read_bytes()[:-300])
    assert repr(pcl_ext.open(cut_off)).endswith(", no orderly end>")
    (tmp_path / "x.pcxi").write_bytes(pcl_ext.Encoder(0.1).encode(room))
    assert "1 stream, 1 frame, " in repr(pcl_ext.open(tmp_path / "x.pcxi"))


def test_a_writer_tells_what_it_wrote(room, tmp_path):
    path = tmp_path / "cell.mcap"
    with pcl_ext.RecordingWriter(path) as writer:
        assert repr(writer) == f"<RecordingWriter {str(path)!r}: 0 streams, 0 frames>"
        stream = writer.add_stream("/left")
        writer.append(stream, pcl_ext.Encoder(0.1).encode(room), 1.0)
        assert repr(writer) == f"<RecordingWriter {str(path)!r}: 1 stream, 1 frame>"
    assert repr(writer) == f"<RecordingWriter {str(path)!r}: 1 stream, 1 frame, ended>"


@pytest.mark.parametrize("settings", [{"frames": 7}, {"sensor_position": (0, 1, 2)}])
def test_a_text_is_the_call_that_makes_it(settings):
    made = pcl_ext.TemporalVoxelFilter(**settings)
    call = repr(made)[1:].partition("):")[0] + ")"
    again = eval(call, {"TemporalVoxelFilter": pcl_ext.TemporalVoxelFilter})
    assert repr(again) == repr(made)
