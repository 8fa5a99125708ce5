# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The example of python/examples, without a window."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import pcl_ext

EXAMPLE = pathlib.Path(__file__).parents[1] / "examples" / "show_recording.py"


@pytest.fixture
def recording(room, random, tmp_path):
    path = tmp_path / "cell.mcap"
    encoder = pcl_ext.Encoder(0.1)
    colouring = pcl_ext.Encoder(0.1, law="none")
    with pcl_ext.RecordingWriter(path) as writer:
        streams = [writer.add_stream("/plain"), writer.add_stream("/coloured")]
        for number in range(3):
            colour = random.integers(0, 256, (len(room), 3), dtype="u1")
            writer.append(streams[0], encoder.encode(room), float(number))
            writer.append(streams[1], colouring.encode(room, None, colour), number + 0.5)
    return path


def show(*words):
    command = [sys.executable, EXAMPLE, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True)


def pixels_of(picture):
    from matplotlib import image

    return (image.imread(picture)[..., :3] * 255).astype("u1").reshape(-1, 3)


@pytest.mark.parametrize(
    "options",
    [
        ["--frame", "2", "--outliers", "points", "--min-intensity", "2"],
        ["--stream", "/coloured", "--frame", "1"],
    ],
)
def test_a_picture_of_a_recording(recording, tmp_path, options):
    picture = tmp_path / "picture.png"
    done = show(recording, "--output", picture, *options)
    assert done.returncode == 0, done.stderr
    # White paper, black letters, and voxels of many colours.
    colours = np.unique(pixels_of(picture), axis=0)
    assert len(colours) > 500


def test_a_folder_of_frames(room, tmp_path):
    folder = tmp_path / "frames"
    folder.mkdir()
    encoder = pcl_ext.Encoder(0.1)
    for number in range(3):
        (folder / f"{number:04}.bin").write_bytes(encoder.encode(room))
    picture = tmp_path / "picture.png"
    done = show(folder, "--frame", 2, "--output", picture)
    assert done.returncode == 0, done.stderr
    assert len(np.unique(pixels_of(picture), axis=0)) > 500


def test_wrong_command_lines(recording, tmp_path):
    for words, message in (
        ([tmp_path / "no_such"], "No such file"),
        ([recording, "--stream", "/other"], "there is no stream '/other', but /plain"),
        ([recording, "--frame", "3"], "there is no frame 3; the stream has 3"),
        ([EXAMPLE], "show_recording.py"),
    ):
        done = show(*words, "--output", tmp_path / "picture.png")
        assert done.returncode != 0
        assert message in done.stderr and "Traceback" not in done.stderr
