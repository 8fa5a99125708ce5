#!/usr/bin/env python3
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Shows a recording, or a folder of frames, with matplotlib, or Open3D if it is installed.

    show_recording.py cell.mcap
    show_recording.py cell.mcap --stream /sensor_2 --frame 40 --output picture.png
    show_recording.py cell.mcap --outliers points --min-intensity 2
    show_recording.py cell.mcap --viewer open3d

A folder is a rosbag2 folder, or one of files with a frame each, in the order of their names.
"""

import argparse
import os
import sys

import numpy as np

import pcl_ext
from pcl_ext.plotting import colours_of, plot_sizes


class FolderOfFrames:
    """Files of one stream with a frame each: as much of pcl_ext.Recording as is used here."""

    def __init__(self, folder):
        paths = [os.path.join(folder, name) for name in sorted(os.listdir(folder))]
        self._paths = [path for path in paths if os.path.isfile(path)]
        self._decoder = pcl_ext.Decoder()
        self._next = 0
        self.streams = [
            pcl_ext.RecordedStream(folder, len(self._paths), False, 0.0, 0.0, {})
        ]

    def frame(self, stream, number, **denoising):
        if number < self._next:
            self._next = 0
            self._decoder = pcl_ext.Decoder()
        for skipped in range(self._next, number):
            self._decoder.decode(self._read(skipped))
        self._next = number + 1
        return self._decoder.decode(self._read(number), **denoising)

    @property
    def status(self):
        return self._decoder.status

    def sizes(self, stream):
        return [os.path.getsize(path) for path in self._paths]

    def _read(self, number):
        with open(self._paths[number], "rb") as file:
            return file.read()


def open_any(path):
    try:
        return pcl_ext.open(path)
    except pcl_ext.Error:
        if os.path.isdir(path):
            return FolderOfFrames(path)
        raise


def frame_sizes(recording, stream):
    """Bytes of each frame of a stream."""
    if isinstance(recording, FolderOfFrames):
        return recording.sizes(stream)
    count = recording.streams[stream].frames
    return [len(recording.read(stream, number).data) for number in range(count)]


def show_with_matplotlib(recording, stream, arguments, denoising):
    import matplotlib

    if arguments.output:
        matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.widgets import Slider

    sizes = frame_sizes(recording, stream)
    figure = pyplot.figure(figsize=(9, 8))
    cloud_axes = figure.add_axes([0.05, 0.27, 0.9, 0.68], projection="3d")
    size_axes = figure.add_axes([0.12, 0.12, 0.8, 0.12])

    def draw(number):
        cloud = recording.frame(stream, number, **denoising)
        name = f"{recording.streams[stream].name}, frame {number}"
        cloud_axes.clear()
        if cloud is None:
            cloud_axes.set_title(f"{name}: {recording.status.message}")
        else:
            cloud.plot(cloud_axes)
            cloud_axes.set_title(
                f"{name}: {len(cloud):,} voxels, {sizes[number]:,} bytes"
            )
        size_axes.clear()
        plot_sizes(sizes, number, size_axes)
        figure.canvas.draw_idle()

    draw(arguments.frame)
    if arguments.output:
        figure.savefig(arguments.output, dpi=120)
        return
    if len(sizes) > 1:
        slider = Slider(
            figure.add_axes([0.12, 0.02, 0.8, 0.03]),
            "frame",
            0,
            len(sizes) - 1,
            valinit=arguments.frame,
            valstep=1,
        )
        slider.on_changed(lambda number: draw(int(number)))
    pyplot.show()


def show_with_open3d(recording, stream, arguments, denoising):
    import open3d

    window = open3d.visualization.Visualizer()
    window.create_window(recording.streams[stream].name)
    shown = open3d.geometry.PointCloud()
    for number in range(arguments.frame, recording.streams[stream].frames):
        cloud = recording.frame(stream, number, **denoising)
        if cloud is None:
            continue
        made = cloud.to_open3d().to_legacy()
        if not made.has_colors():
            # Without missing points, as Open3D has it.
            points = np.ravel(cloud)
            colours = colours_of(points[np.isfinite(points["x"])])
            colours = np.repeat(colours[:, None] / max(colours.max(), 1e-6), 3, axis=1)
            made.colors = open3d.utility.Vector3dVector(colours)
        shown.points, shown.colors = made.points, made.colors
        if number == arguments.frame:
            window.add_geometry(shown)
        else:
            window.update_geometry(shown)
        if not window.poll_events():
            return
        window.update_renderer()
    window.run()


def parse(words):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", help="a .pcxi or MCAP file, or a folder")
    parser.add_argument("--stream", help="name of the stream (default: the first)")
    parser.add_argument("--frame", type=int, default=0, help="its number, from 0")
    parser.add_argument("--output", help="PNG to write instead of a window")
    parser.add_argument(
        "--viewer", choices=("matplotlib", "open3d"), default="matplotlib"
    )
    parser.add_argument(
        "--outliers",
        choices=("automatic", "faces", "points", "voxels", "rays"),
        help="remove noise; what the intensities are",
    )
    parser.add_argument("--min-intensity", type=float, help="remove voxels below")
    return parser.parse_args(words)


def main(words=None):
    arguments = parse(words)
    try:
        recording = open_any(arguments.recording)
    except (OSError, pcl_ext.Error) as error:
        sys.exit(str(error))
    names = [stream.name for stream in recording.streams]
    if arguments.stream is not None and arguments.stream not in names:
        sys.exit(f"there is no stream '{arguments.stream}', but {', '.join(names)}")
    stream = names.index(arguments.stream) if arguments.stream else 0
    frames = recording.streams[stream].frames
    if not 0 <= arguments.frame < frames:
        sys.exit(f"there is no frame {arguments.frame}; the stream has {frames}")
    denoising = {"min_intensity": arguments.min_intensity}
    if arguments.outliers:
        denoising["outliers"] = pcl_ext.OutlierRemoval(arguments.outliers)
    show = show_with_open3d if arguments.viewer == "open3d" else show_with_matplotlib
    show(recording, stream, arguments, denoising)


if __name__ == "__main__":
    main()
