"""The report's figures, as PNG, from what sample_pictures wrote."""

import io

import matplotlib

matplotlib.use("Agg")

# What must follow the choice of how to draw.
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

import octree_picture  # noqa: E402
from noise_results import FILTER, FILTER_OF_EACH, LAWS  # noqa: E402
from results import CODERS, MERGED  # noqa: E402

CODER_COLOURS = {"published": "#8a6d3b", "fast": "#1b7837", "balanced": "#2166ac",
                 "small": "#762a83"}
SENSOR_COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b",
                  "#000000"]
METHOD_COLOURS = {"count": "#4d4d4d", "linear": "#2166ac", "quadratic": "#b2182b",
                  FILTER: "#1b7837", FILTER_OF_EACH: "#762a83"}
NOISE_COLOUR = "#d7191c"
VOXEL_SIZE = 1.25  # of a marker that covers a voxel in the top views, square points

# Thresholds of the paper's Figure 11, in the unit of the decoded intensities.
THRESHOLDS = {"count": 2, "linear": 64, "quadratic": 64}


def _read(folder, name):
    # One row alone would come without its dimension.
    return np.atleast_1d(np.genfromtxt(folder / name, delimiter=",", names=True))


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
    return _png(figure)


def small_octree(folder):
    """Figure 7."""
    return _png(octree_picture.small_octree(_read(folder, "octree_points.csv"),
                                            _read(folder, "octree_voxels.csv"),
                                            _read(folder, "octree_cells.csv")))


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


def precision_over_recall(results):
    """Laws and filter, of sensor 1 and of all cameras merged."""
    figure, both = plt.subplots(1, 2, figsize=(12, 4.4), sharex=True, sharey=True)
    for axes, sensor, methods, title in (
            (both[0], "1", LAWS + (FILTER,), "sensor 1, 4 cm"),
            (both[1], MERGED, LAWS + (FILTER, FILTER_OF_EACH),
             "all six cameras merged, 4 cm")):
        for method in methods:
            points = sorted(
                (float(quantity.rsplit(" ", 1)[1]),
                 results.mean("noise_curve", sensor, method, 4, quantity))
                for quantity in results.values("noise_curve", 4, sensor=sensor))
            axes.plot(*zip(*points), color=METHOD_COLOURS[method], label=method)
        noise = results.mean("noise", sensor, FILTER, 4, "noise_percent") / 100
        axes.axhline(noise, color="#999999", linestyle=":", label="by chance")
        axes.set(xlabel="recall: share of the noise that is removed", xlim=(0, 1),
                 ylim=(0, 1.02))
        axes.set_title(title, fontsize=10)
        axes.grid(alpha=0.3)
    both[0].set_ylabel("precision: share of noise in what is removed")
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    # The right one's, which has all: there is no room within that is never crossed.
    figure.legend(*both[1].get_legend_handles_labels(), loc="lower center", ncols=6,
                  fontsize=9, frameon=False)
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
