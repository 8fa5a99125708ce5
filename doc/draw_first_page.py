# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of the README's first table into doc/first_page.

Usage, after `pcl_ext demo --sensors 6 -o DEMO` and
`pcl_ext decode DEMO/cell.mcap -o CLOUDS --pcd binary --remove-outliers`:
  draw_first_page.py CLOUDS    the map is drawn of their last frame

The figures of the others are those of doc/benchmarks.md; watch.webp is a part of the picture that
viewer/pictures.mjs makes. Needs the group `benchmark` of tools/packages.txt, and webp.
"""

import pathlib
import re
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

DOC = pathlib.Path(__file__).resolve().parent
OURS, OTHERS = "#0a7d6c", "#b9bdc1"
SIZE = (3.4, 2.2)  # inches, at 200 dots an inch


def rows(title):
    """The rows of the table after a line of doc/benchmarks.md, each a list of its cells."""
    text = (DOC / "benchmarks.md").read_text()
    lines = text[text.index(f"\n{title}") + 1:].splitlines()
    table = [line for line in lines[1:lines.index("", next(
        i for i, line in enumerate(lines) if line.startswith("|")))] if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]]


def number(cell):
    return float(re.match(r"[\d.,]+", cell)[0].replace(",", ""))


def save(figure, name):
    with tempfile.NamedTemporaryFile(suffix=".png") as png:
        figure.savefig(png.name, dpi=200)
        subprocess.run(["cwebp", "-quiet", "-q", "80", png.name, "-o", DOC / "first_page" / name], check=True)
    plt.close(figure)


def bars(axes, names, values, unit):
    """A bar for each value, the last one this library's."""
    colours = [OTHERS] * (len(names) - 1) + [OURS]
    axes.barh(names, values, color=colours)
    axes.invert_yaxis()
    for place, value in enumerate(values):
        axes.text(value, place, f" {value:.3g} {unit}", va="center", fontsize=8)
    axes.set_xlim(0, 1.45 * max(values))
    axes.set_xticks([])
    axes.tick_params(axis="y", length=0, labelsize=8)
    for side in ("top", "right", "bottom"):
        axes.spines[side].set_visible(False)


def draw_switch():
    """PCL's class, in its fastest run, and ours at 4 cm: milliseconds of both directions."""
    cells = {row[1]: row for row in rows("The run of that day in which PCL's class was fastest")
             if row[0] == "4 cm, count"}
    figure, both = plt.subplots(2, 1, figsize=SIZE, layout="constrained")
    for axes, column, title in zip(both, (6, 7), ("encode a frame", "decode a frame")):
        names = ("PCL", "pcl_ext, fast")
        values = [number(cells["PCL, voxel grid"][column]), number(cells["pcl_ext, fast"][column])]
        bars(axes, names, values, "ms")
        axes.set_title(title, fontsize=9, loc="left")
    save(figure, "switch.webp")


def draw_plant():
    """Cores that a centre needs for filtered streams of 20 Hz, and the paper's number of sensors."""
    figure, axes = plt.subplots(figsize=SIZE, layout="constrained")
    cells = [row for row in rows("### A centre that merges") if row[1] == "temporal filter"]
    streams = [number(row[0]) for row in cells]
    for column, colour, name in ((8, OTHERS, "from nothing"), (6, OURS, "what changes")):
        cores = [number(row[column]) for row in cells]
        axes.plot([0, *streams], [0, *cores], color=colour, marker="o", markersize=3)
        axes.annotate(name, (streams[-2], cores[-2]), (-6, 4), textcoords="offset points", fontsize=8, ha="right")
    axes.axvline(440, color="black", linewidth=0.8, linestyle=":")
    axes.text(432, 14, "the paper's 440", rotation=90, va="top", ha="right", fontsize=7)
    axes.set_xlim(0, 460)
    axes.set_ylim(0, 20)
    axes.set_yticks(range(0, 21, 5))
    axes.set_title("cores, by sensors of 20 Hz", fontsize=9, loc="left")
    axes.tick_params(labelsize=7)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    save(figure, "plant.webp")


def draw_shrink():
    """Every point of recorded clouds to 1 cm: kilobytes a frame."""
    figure, both = plt.subplots(2, 1, figsize=SIZE, layout="constrained")
    for axes, stream in zip(both, ("ouster_os0", "kinect_v1")):
        (row,) = (row for row in rows("### All points, kB a frame\n")
                  if row[0].startswith(stream) and row[1] == "1 cm")
        names = ("zstd -19", "Draco", "pcl_ext")
        bars(axes, names, [number(row[9]), number(row[6]), number(row[3])], "kB")
        axes.set_title(f"a cloud of {stream.replace('_', ' ')}, all points, 1 cm", fontsize=9, loc="left")
    save(figure, "shrink.webp")


def draw_watch():
    """The middle of the viewer's page."""
    middle = ["-crop", "40", "58", "900", "580", "-resize", "680", "0"]
    subprocess.run(["cwebp", "-quiet", "-q", "80", *middle, DOC / "viewer_page.webp", "-o",
                    DOC / "first_page" / "watch.webp"], check=True)


def points(path):
    """x, y, z of a binary PCD file."""
    header, data = path.read_bytes().split(b"DATA binary\n", 1)
    fields = re.search(rb"FIELDS (.*)", header)[1].split()
    count = int(re.search(rb"POINTS (\d+)", header)[1])
    return np.frombuffer(data, np.float32).reshape(count, len(fields))[:, :3]


def draw_map(clouds):
    """The last clouds of all sensors, as a centre merges them, by height."""
    clouds = [points(sorted(folder.glob("*.pcd"))[-1]) for folder in sorted(clouds.iterdir())]
    voxels = np.unique(np.round(np.concatenate(clouds) / 0.04).astype(int), axis=0) * 0.04
    figure = plt.figure(figsize=SIZE)
    axes = figure.add_axes((-0.22, -0.3, 1.44, 1.6), projection="3d")
    axes.scatter(*voxels.T, c=voxels[:, 2], cmap="viridis", s=1.2, marker="s", linewidths=0, depthshade=False,
                 rasterized=True)
    axes.set_box_aspect(np.ptp(voxels, axis=0))
    axes.view_init(elev=35, azim=-60)
    axes.set_axis_off()
    save(figure, "map.webp")


draw_switch()
draw_shrink()
draw_plant()
draw_watch()
draw_map(pathlib.Path(sys.argv[1]))
