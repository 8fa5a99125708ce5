"""The report's figures, as PNG, from what sample_pictures wrote."""

import io

import matplotlib

matplotlib.use("Agg")

# What must follow the choice of how to draw.
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from results import CODERS  # noqa: E402

CODER_COLOURS = {"published": "#8a6d3b", "fast": "#1b7837", "balanced": "#2166ac",
                 "small": "#762a83"}
SENSOR_COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b",
                  "#000000"]
NOISE_COLOUR = "#d7191c"
VOXEL_EDGE = 0.04  # metres
VOXEL_SIZE = 1.25  # of a marker that covers a voxel in the top views, square points

# Thresholds of the paper's Figure 11, in the unit of the decoded intensities.
THRESHOLDS = {"count": 2, "linear": 64, "quadratic": 64}


def _read(folder, name):
    return np.genfromtxt(folder / name, delimiter=",", names=True)


def _png(figure):
    stream = io.BytesIO()
    # Without a date or a version the same figures are the same bytes.
    figure.savefig(stream, format="png", dpi=110, bbox_inches="tight",
                   metadata={"Software": None})
    plt.close(figure)
    return stream.getvalue()


def laws_over_depth(folder):
    """Figure 5."""
    laws = _read(folder, "laws.csv")
    figure, axes = plt.subplots(figsize=(7, 3.6))
    for law, colour in (("count", "#4d4d4d"), ("linear", "#2166ac"),
                        ("quadratic", "#b2182b")):
        axes.plot(laws["depth"], laws[law], color=colour, label=law)
    cut_off = laws["cut_off_depth"][0]
    axes.axvline(cut_off, color="#999999", linestyle=":")
    axes.annotate(f"$z_c$ = {cut_off:.2f} m", (cut_off, 0.08), xytext=(5, 0),
                  textcoords="offset points")
    axes.set(xlabel="depth z, m", ylabel="intensity of a point $I_p$", xlim=(0, 18),
             ylim=(0, 1.05))
    axes.grid(alpha=0.3)
    axes.legend(loc="center left")
    return _png(figure)


def _draw_octree_cells(axes, low, levels):
    """Edges of the cells of the levels above the voxels'."""
    for level, shade in levels:
        edge = VOXEL_EDGE * 2 ** level
        ends = np.arange(3) * edge
        for one in ends:
            for other in ends:
                for axis in range(3):
                    line = np.empty((2, 3))
                    line[:, axis] = low[axis] + np.array([0.0, 2 * edge])
                    line[:, (axis + 1) % 3] = low[(axis + 1) % 3] + one
                    line[:, (axis + 2) % 3] = low[(axis + 2) % 3] + other
                    axes.plot(*line.T, color=shade, linewidth=0.7)


def _draw_voxels(axes, voxels, low, quantity, colours):
    filled = np.zeros((8, 8, 8), dtype=bool)
    faces = np.zeros((8, 8, 8, 4))
    top = voxels[quantity].max()
    for voxel in voxels:
        place = tuple(np.floor((np.array([voxel["x"], voxel["y"], voxel["z"]]) - low)
                               / VOXEL_EDGE).astype(int))
        filled[place] = True
        faces[place] = colours(voxel[quantity] / top)
    corners = np.indices((9, 9, 9)) * VOXEL_EDGE
    axes.voxels(*(corners[axis] + low[axis] for axis in range(3)), filled,
                facecolors=faces, edgecolor="#00000055", linewidth=0.3)
    scale = plt.cm.ScalarMappable(plt.Normalize(0, top), colours)
    bar = axes.figure.colorbar(scale, ax=axes, orientation="horizontal", shrink=0.6,
                               pad=0.12, ticks=np.linspace(0, top, 4).round())
    bar.ax.tick_params(labelsize=8)


def small_octree(folder):
    """Figure 7."""
    points = _read(folder, "octree_points.csv")
    voxels = _read(folder, "octree_voxels.csv")
    low = np.array([5.60, 3.12, 0.88])
    figure = plt.figure(figsize=(12, 5.2))
    for number, title in enumerate(("points, in the octree's cells of 16 cm",
                                    "voxels of 4 cm: number of points",
                                    "voxels of 4 cm: quadratic intensity")):
        axes = figure.add_subplot(1, 3, number + 1, projection="3d")
        if number == 0:
            _draw_octree_cells(axes, low, [(2, "#999999")])
            axes.scatter(points["x"], points["y"], points["z"], s=5, c="#2166ac",
                         depthshade=False)
            # As much room as the others have over their scales.
            figure.colorbar(plt.cm.ScalarMappable(), ax=axes, orientation="horizontal",
                            shrink=0.6, pad=0.12).ax.set_visible(False)
        else:
            _draw_voxels(axes, voxels, low, ("count", "quadratic")[number - 1],
                         plt.cm.viridis)
        axes.set_title(title, fontsize=10)
        for axis, name in enumerate("xyz"):
            getattr(axes, f"set_{name}lim")(low[axis], low[axis] + 0.32)
        axes.view_init(elev=28, azim=-125)
        axes.set_box_aspect((1, 1, 1))
        axes.tick_params(labelsize=6)
    return _png(figure)


def _drawn_obliquely(voxels):
    """Places on the page and order of drawing, seen from above a corner."""
    turn, tilt = np.radians(-35.0), np.radians(35.0)
    x, y = voxels["x"] - 5.0, voxels["y"] - 5.0
    across = np.cos(turn) * x - np.sin(turn) * y
    away = np.sin(turn) * x + np.cos(turn) * y
    up = np.sin(tilt) * away + np.cos(tilt) * voxels["z"]
    return across, up, np.argsort(-away)


def denoising(folder):
    """Figure 10."""
    voxels = _read(folder, "cell_voxels.csv")
    voxels = voxels[voxels["sensor"] == 1]
    kept = voxels[voxels["quadratic"] >= THRESHOLDS["quadratic"]]
    figure, both = plt.subplots(1, 2, figsize=(12, 4.6), sharex=True, sharey=True)
    for axes, shown, title in ((both[0], voxels, "before"),
                               (both[1], kept, "after, quadratic 64")):
        across, up, order = _drawn_obliquely(shown)
        noise = shown["is_noise"][order] > 0
        axes.scatter(across[order], up[order], s=1.5, linewidths=0,
                     c=shown["z"][order], cmap="cividis", vmin=0, vmax=4)
        axes.scatter(across[order][noise], up[order][noise], s=3, linewidths=0,
                     c=NOISE_COLOUR)
        axes.set_title(f"{title}: {len(shown):,} voxels, "
                       f"{np.count_nonzero(noise):,} of them noise (red)", fontsize=10)
        axes.set_aspect("equal")
        axes.set_xticks([])
        axes.set_yticks([])
    figure.tight_layout()
    return _png(figure)


def _draw_top_view(axes, shown, marker, size, title):
    for sensor, colour in enumerate(SENSOR_COLOURS, start=1):
        of_sensor = shown[shown["sensor"] == sensor]
        axes.scatter(of_sensor["x"], of_sensor["y"], s=size, marker=marker, linewidths=0,
                     c=colour)
    axes.set(xlim=(0, 10), ylim=(0, 10))
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=10)
    axes.tick_params(labelsize=7)


def _kept(voxels, law):
    # The lidar's own intensity knows none of the laws: its voxels all stay.
    return voxels[(voxels["sensor"] == 7) | (voxels[law] >= THRESHOLDS[law])]


def top_views(folder):
    """Figure 11."""
    points = _read(folder, "cell_points.csv")
    voxels = _read(folder, "cell_voxels.csv")
    figure, places = plt.subplots(2, 3, figsize=(12.5, 8.6))
    places = places.ravel()
    _draw_top_view(places[0], points, "o", 0.2, f"raw: {len(points):,} points")
    _draw_top_view(places[1], voxels, "s", VOXEL_SIZE,
                   f"unfiltered: {len(voxels):,} voxels, "
                   f"{np.count_nonzero(voxels['is_noise']):,} of them noise")
    for axes, law in zip(places[2:], ("count", "linear", "quadratic")):
        kept = _kept(voxels, law)
        noise = np.count_nonzero(kept["is_noise"])
        _draw_top_view(axes, kept, "s", VOXEL_SIZE,
                       f"{law} {THRESHOLDS[law]}: {len(kept):,} voxels, "
                       f"{noise:,} of them noise")
    places[5].axis("off")
    places[5].legend(handles=[
        plt.Line2D([], [], marker="o", linestyle="", color=colour,
                   label=f"sensor {sensor}" + (", VLP-16" if sensor == 7 else ""))
        for sensor, colour in enumerate(SENSOR_COLOURS, start=1)], loc="center")
    figure.tight_layout()
    return _png(figure)


def bits_over_resolution(results):
    """Bits per voxel against the voxel's edge."""
    figure, axes = plt.subplots(figsize=(7, 3.6))
    edges = range(1, 21)
    for coder in CODERS:
        bits = [8 * results.figure("resolution", "1", coder, edge,
                                   "bytes_per_voxel").mean for edge in edges]
        axes.plot(edges, bits, marker=".", color=CODER_COLOURS[coder], label=coder)
    axes.set(xlabel="voxel edge, cm", ylabel="bits per voxel", ylim=(0, None),
             xticks=range(0, 21, 2))
    axes.grid(alpha=0.3)
    axes.legend()
    return _png(figure)


def filtering_counts(folder):
    """By filter: voxels of the six Kinects that stay, and how many of them are noise."""
    voxels = _read(folder, "cell_voxels.csv")
    voxels = voxels[voxels["sensor"] != 7]
    kept = {"none": voxels}
    for law, threshold in THRESHOLDS.items():
        kept[f"{law} {threshold}"] = _kept(voxels, law)
    return {name: (len(stay), int(np.count_nonzero(stay["is_noise"])))
            for name, stay in kept.items()}
