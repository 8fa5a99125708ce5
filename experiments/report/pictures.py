# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The report's pictures as PNG."""

import io

import matplotlib

matplotlib.use("Agg")

# The backend is chosen before pyplot is loaded.
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from paper_values import FIGURE_10_COUNT, FIGURE_11  # noqa: E402
from results import CODERS, LIDAR  # noqa: E402
from tables import FILTER, LAWS  # noqa: E402

CODER_COLOURS = {"published": "#8a6d3b", "fast": "#1b7837", "balanced": "#2166ac",
                 "small": "#762a83"}
SENSOR_COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b",
                  "#000000"]
METHOD_COLOURS = {"count": "#4d4d4d", "linear": "#2166ac", "quadratic": "#b2182b",
                  FILTER: "#1b7837"}
VOXEL_SIZE = 1.25  # of a marker that covers a voxel in the top views, square points


def read_samples(folder, name):
    """The rows of a file, by the header's names."""
    # genfromtxt returns a single row without its dimension.
    return np.atleast_1d(np.genfromtxt(folder / name, delimiter=",", names=True))


def _of(rows, sensor):
    return rows[rows["sensor"] == int(sensor)]


def png_of(figure):
    """A figure as PNG, which is closed then."""
    stream = io.BytesIO()
    # Without date and version, so that equal values make equal bytes.
    figure.savefig(stream, format="png", dpi=110, bbox_inches="tight",
                   metadata={"Software": None})
    plt.close(figure)
    return stream.getvalue()


def laws_over_depth(folder):
    """Figure 5."""
    laws = read_samples(folder, "laws.csv")
    figure, axes = plt.subplots(figsize=(7, 3.6))
    for law in LAWS:
        axes.plot(laws["depth"], laws[law], color=METHOD_COLOURS[law], label=law)
    cut_off = laws["cut_off_depth"][0]
    axes.axvline(cut_off, color="#999999", linestyle=":")
    axes.annotate(f"$z_c$ = {cut_off:.2f} m", (cut_off, 0.08), xytext=(5, 0),
                  textcoords="offset points")
    axes.set(xlabel="depth z, m", ylabel="intensity of a point $I_p$", xlim=(0, 18),
             ylim=(0, 1.05))
    axes.grid(alpha=0.3)
    axes.legend(loc="center left")
    return png_of(figure)


def _edges_of_cube(low, edge):
    """The twelve edges, each as two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    for one in corners:
        for other in corners:
            if (other - one).sum() == 1 and np.abs(other - one).sum() == 1:
                yield low + edge * np.array([one, other])


def eight_leaves(folder):
    """Figure 7."""
    edge = 0.04
    points, voxels = (read_samples(folder, f"octree_{name}.csv") for name in ("points", "voxels"))
    centres = np.stack([voxels[axis] for axis in "xyz"], axis=1)
    low = np.floor(centres.min(axis=0) / (2 * edge) + 1e-3) * 2 * edge
    figure, both = plt.subplots(1, 2, figsize=(10, 4.8), subplot_kw={"projection": "3d"})
    for axes, title in ((both[0], f"before: {len(points)} points"),
                        (both[1], f"after: {len(voxels)} points with a count")):
        for offset in np.ndindex(2, 2, 2):
            corner = low + edge * np.array(offset)
            is_occupied = (np.abs(centres - corner - edge / 2) < edge / 4).all(axis=1).any()
            for line in _edges_of_cube(corner, edge):
                axes.plot(*line.T, color="#2166ac" if is_occupied else "#cccccc",
                          linewidth=1.4 if is_occupied else 0.6,
                          zorder=2 if is_occupied else 1,
                          linestyle="-" if axes is both[0] else "--")
        axes.set_title(title, fontsize=10)
        axes.view_init(elev=22, azim=-60)
        axes.set_box_aspect((1, 1, 1))
        axes.set_axis_off()
    both[0].scatter(points["x"], points["y"], points["z"], s=14, c="#333333",
                    depthshade=False)
    both[1].scatter(*centres.T, s=60, c="#b2182b", depthshade=False)
    for centre, count in zip(centres, voxels["count"]):
        both[1].text(*(centre + [0.004, 0, 0.004]), f"{count:.0f}", fontsize=12)
    figure.tight_layout()
    return png_of(figure)


def _drawn_obliquely(rows):
    """Places on the page and order of drawing, seen from above a corner."""
    turn, tilt = np.radians(-35.0), np.radians(35.0)
    x, y = rows["x"] - 5.0, rows["y"] - 5.0
    across = np.cos(turn) * x - np.sin(turn) * y
    away = np.sin(turn) * x + np.cos(turn) * y
    up = np.sin(tilt) * away + np.cos(tilt) * rows["z"]
    return across, up, np.argsort(-away)


def before_and_after(folder):
    """Figure 10."""
    points = _of(read_samples(folder, "cell_points.csv"), 1)
    voxels = _of(read_samples(folder, "cell_voxels.csv"), 1)
    kept = voxels[voxels["count"] >= FIGURE_10_COUNT]
    figure, both = plt.subplots(1, 2, figsize=(12, 5.4), sharex=True, sharey=True)
    for axes, rows, quantity, colours, most, size, label, title in (
            (both[0], points, "z", "cividis", 4, 1.2, "height, m",
             f"cropped: {len(points):,} points"),
            (both[1], kept, "count", "YlOrBr", 8, 2.5, "points in the voxel",
             f"decoded, at least {FIGURE_10_COUNT} points: {len(kept):,} of "
             f"{len(voxels):,} voxels")):
        across, up, order = _drawn_obliquely(rows)
        drawn = axes.scatter(across[order], up[order], s=size, linewidths=0,
                             c=rows[quantity][order], cmap=colours, vmin=0, vmax=most)
        axes.set_title(title, fontsize=10)
        axes.set_aspect("equal")
        axes.set(xticks=[], yticks=[])
        figure.colorbar(drawn, ax=axes, orientation="horizontal", shrink=0.5, pad=0.03,
                        label=label)
    figure.tight_layout()
    return png_of(figure)


def _draw_top_view(axes, rows, marker, size, title):
    for sensor, colour in enumerate(SENSOR_COLOURS, start=1):
        of_sensor = _of(rows, sensor)
        axes.scatter(of_sensor["x"], of_sensor["y"], s=size, marker=marker, linewidths=0,
                     c=colour)
    axes.set(xlim=(0, 10), ylim=(0, 10))
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=9)
    axes.tick_params(labelsize=7)


def top_views(folder):
    """Figure 11."""
    points = read_samples(folder, "cell_points.csv")
    voxels = read_samples(folder, "cell_voxels.csv")
    figure, places = plt.subplots(2, 3, figsize=(12.5, 8.6))
    places = places.ravel()
    _draw_top_view(places[0], points, "o", 0.2, f"cropped: {len(points):,} points")
    _draw_top_view(places[1], voxels, "s", VOXEL_SIZE,
                   f"decoded: {len(voxels):,} voxels, "
                   f"{np.count_nonzero(voxels['is_noise']):,} of them noise")
    for axes, (law, threshold) in zip(places[2:], FIGURE_11.items()):
        kept = voxels[(voxels["sensor"] == int(LIDAR)) | (voxels[law] >= threshold)]
        _draw_top_view(axes, kept, "s", VOXEL_SIZE,
                       f"{law}, at least {threshold}: {len(kept):,} voxels, "
                       f"{np.count_nonzero(kept['is_noise']):,} of them noise")
    places[5].axis("off")
    places[5].legend(handles=[
        plt.Line2D([], [], marker="o", linestyle="", color=colour,
                   label=f"sensor {sensor}" + (", VLP-16" if sensor == 7 else ""))
        for sensor, colour in enumerate(SENSOR_COLOURS, start=1)], loc="center")
    figure.tight_layout()
    return png_of(figure)


def bits_over_resolution(results):
    """Bits per voxel against the voxel's edge."""
    figure, axes = plt.subplots(figsize=(7, 3.6))
    edges = range(1, 21)
    for coder in CODERS:
        bits = [8 * results.mean("resolution", "1", coder, edge, "bytes_per_voxel")
                for edge in edges]
        axes.plot(edges, bits, marker=".", color=CODER_COLOURS[coder], label=coder)
    axes.set(xlabel="voxel edge, cm", ylabel="bits per voxel", ylim=(0, None),
             xticks=range(0, 21, 2))
    axes.grid(alpha=0.3)
    axes.legend()
    return png_of(figure)


def precision_over_recall(results):
    """Laws and filter, of sensor 1."""
    figure, axes = plt.subplots(figsize=(7, 4.4))
    for method in LAWS + (FILTER,):
        points = sorted((float(quantity.rsplit(" ", 1)[1]),
                         results.mean("noise_curve", "1", method, 4, quantity))
                        for quantity in results.names("noise_curve", 4))
        axes.plot(*zip(*points), color=METHOD_COLOURS[method], label=method)
    noise = results.mean("noise", "1", FILTER, 4, "noise_percent") / 100
    axes.axhline(noise, color="#999999", linestyle=":", label="by chance")
    axes.set(xlabel="recall: share of the noise that is removed", xlim=(0, 1),
             ylim=(0, 1.02), ylabel="precision: share of noise in what is removed")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=9, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return png_of(figure)
