# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Draws the results of table `points`: bytes a frame, a column for each cloud, a row for each
voxel edge.

    /usr/bin/python3 benchmarks/draw_points.py <what the program printed> <picture>
"""

import pathlib
import sys

import matplotlib

matplotlib.use("Agg")

# The backend is chosen before pyplot is loaded.
import matplotlib.pyplot as plt  # noqa: E402

OWN_COLOUR = "#2166ac"
PEER_COLOUR = "#b3b3b3"


def read_kilobytes(file):
    """The first table by cloud, edge and coder."""
    lines = pathlib.Path(file).read_text(encoding="utf-8").splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith("|"))
    header, _, *rows = ([cell.strip() for cell in line.strip("|").split("|")]
                        for line in lines[first:lines.index("", first)])
    clouds = {}
    for name, edge, *sizes in rows:
        edges = clouds.setdefault(name.split(",")[0], {})
        edges[edge] = {coder: float(size.replace(",", ""))
                       for coder, size in zip(header[2:], sizes)}
    return clouds


def draw(clouds, picture):
    rows = max(map(len, clouds.values()))
    figure, plots = plt.subplots(rows, len(clouds), figsize=(10, 2.2 * rows), sharey=True,
                                 squeeze=False)
    for column, (cloud, edges) in zip(plots.T, clouds.items()):
        for axes, (edge, coders) in zip(column, edges.items()):
            bars = axes.barh(list(coders), list(coders.values()), color=[
                OWN_COLOUR if coder.startswith("pcl_ext") else PEER_COLOUR
                for coder in coders])
            axes.bar_label(bars, [f"{size:.1f}" for size in coders.values()], padding=3,
                           fontsize=9)
            axes.set_title(f"{cloud}, {edge}", fontsize=10, loc="left")
            # Room for the numbers.
            axes.set_xlim(0, 1.2 * max(coders.values()))
            axes.set_xticks([])
            axes.tick_params(left=False, labelsize=9)
            axes.spines[["top", "right", "bottom"]].set_visible(False)
    plots[0, 0].invert_yaxis()  # of all, as they share it
    figure.suptitle("kB a frame, all points kept, errors of at most half the edge; "
                    "each plot has a scale of its own", x=0.01, ha="left", fontsize=10)
    figure.tight_layout()
    figure.savefig(picture, dpi=100, pil_kwargs={"lossless": True})


draw(read_kilobytes(sys.argv[1]), sys.argv[2])
