"""Draws the README's picture, doc/robot_cell.png: a cloud, its voxels, and their outliers.

    build/experiments/report/sample_pictures <folder>
    bash tools/run.sh demo --sensors 1 --frames 91 --output <clouds>
    python3 experiments/report/cell_picture.py <folder> <clouds>/cell_sensor_1 doc/robot_cell.png

The points are those of frame 90, the last of the 91 (`shown_frame` of sample_pictures.cpp).
"""

import io
import pathlib
import struct
import sys

import matplotlib

matplotlib.use("Agg")

# The backend is chosen before pyplot is loaded.
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402

FRAME = 90


def unpacked(data, size):
    """LZF, the compression of PCD's binary_compressed."""
    out = bytearray()
    at = 0
    while len(out) < size:
        control = data[at]
        at += 1
        if control < 32:
            out += data[at:at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[at]
            at += 1
        start = len(out) - ((control & 31) << 8) - data[at] - 1
        at += 1
        for i in range(length + 2):
            out.append(out[start + i])
    return bytes(out)


def read_voxels(path):
    """x, y, z and intensity of a cloud that pcl_ext wrote."""
    header, body = path.read_bytes().split(b"DATA binary_compressed\n", 1)
    lines = dict(line.split(" ", 1) for line in header.decode().splitlines() if " " in line)
    if lines["FIELDS"] != "x y z intensity":
        raise ValueError(f"{path} has the fields {lines['FIELDS']}")
    packed, size = struct.unpack("<II", body[:8])
    fields = unpacked(body[8:8 + packed], size)
    return np.frombuffer(fields, dtype="<f4").reshape(4, -1)


def draw(axes, x, y, z, colours, size, title, **options):
    """A view from above a corner of the cell, the nearest points last."""
    turn, tilt = np.radians(-35.0), np.radians(35.0)
    x, y = x - 5.0, y - 5.0
    across = np.cos(turn) * x - np.sin(turn) * y
    away = np.sin(turn) * x + np.cos(turn) * y
    up = np.sin(tilt) * away + np.cos(tilt) * z
    order = np.argsort(-away)
    drawn = axes.scatter(across[order], up[order], s=size, linewidths=0, c=colours[order],
                         rasterized=True, **options)
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)
    return drawn


def main(measurements, clouds, output):
    points = np.genfromtxt(measurements / "cell_points.csv", delimiter=",", names=True)
    points = points[points["sensor"] == 1]
    decoded, denoised = (read_voxels(clouds / kind / f"{FRAME:06d}.pcd")
                         for kind in ("decoded", "denoised"))
    kept = {tuple(centre) for centre in denoised[:3].T}
    removed = decoded[:, [tuple(centre) not in kept for centre in decoded[:3].T]]

    figure, ((sensor, voxels), (outliers, clean)) = plt.subplots(
        2, 2, figsize=(11, 6.6), sharex=True, sharey=True)
    height = draw(sensor, points["x"], points["y"], points["z"], points["z"], 0.9,
                  f"sensor: {len(points):,} points", cmap="viridis", vmin=0, vmax=3)
    # Without the lightest colours, which are hard to see on white.
    shades = matplotlib.colors.ListedColormap(plt.get_cmap("plasma_r")(np.linspace(0.2, 1, 8)))
    counts = {"cmap": shades, "vmin": 0.5, "vmax": 8.5}
    draw(voxels, *decoded[:3], decoded[3], 2,
         f"decoded: {decoded.shape[1]:,} voxels of 4 cm", **counts)
    draw(outliers, *removed[:3], removed[3], 2,
         f"removed as outliers: {removed.shape[1]:,} voxels", **counts)
    count = draw(clean, *denoised[:3], denoised[3], 2,
                 f"kept: {denoised.shape[1]:,} voxels", **counts)
    figure.subplots_adjust(left=0.01, right=0.99, top=0.96, bottom=0.1, wspace=0.02, hspace=0.09)
    for drawn, left, label in ((height, 0.12, "height of a point, m"),
                               (count, 0.62, "intensity: points in a voxel (8: 8 or more)")):
        bar = figure.add_axes((left, 0.07, 0.26, 0.018))
        figure.colorbar(drawn, cax=bar, orientation="horizontal")
        bar.tick_params(labelsize=8)
        bar.set_xlabel(label, fontsize=9)
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100, metadata={"Software": None})
    # A palette makes a third of the bytes.
    Image.open(stream).convert("RGB").quantize(256, Image.Quantize.FASTOCTREE).save(output, optimize=True)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3])
