"""The picture of the section on noise of lidars as PNG."""

import matplotlib
import numpy as np

from pictures import plt, png_of, read_samples

RAYS, RINGS, STEP = 1800, 16, 0.2  # of a ring, of the lidar; degrees
SHOWN = 75.0  # degrees to both sides; beyond are walls alone
LIDAR_PLACE = (9.6, 0.4)  # metres
SURFACE, SNOW, MIXED_ECHO = "#9a9a9a", "#e6550d", "#7b3294"
RANGES, MOST_METRES = matplotlib.colormaps["Blues"], 16.0


def _draw_from_above(axes, rows, words):
    is_snow, is_mixed = rows["is_snow"] > 0, rows["is_mixed_echo"] > 0
    is_surface = ~is_snow & ~is_mixed
    for chosen, colour, size in ((is_surface, SURFACE, 1), (is_mixed, MIXED_ECHO, 5),
                                 (is_snow, SNOW, 5)):
        axes.scatter(rows["x"][chosen], rows["y"][chosen], s=size, linewidths=0, c=colour)
    axes.plot(*LIDAR_PLACE, marker="^", color="black")
    axes.set_aspect("equal")
    axes.set(xlim=(-1.8, 11.8), ylim=(-1.8, 11.8), xlabel="x, m")
    axes.set_title(f"{words}: {is_snow.sum():,} points of snow, {is_mixed.sum():,} mixed "
                   f"echoes, {is_surface.sum():,} of surfaces", fontsize=10)


def _range_image(rows):
    """A ring a row and a ray a column, the lidar's left on the left; white: no point."""
    image = np.ones((RINGS, RAYS, 4))
    colours = RANGES(0.25 + 0.75 * rows["range"] / MOST_METRES)
    for kind, colour in (("is_mixed_echo", MIXED_ECHO), ("is_snow", SNOW)):
        colours[rows[kind] > 0] = matplotlib.colors.to_rgba(colour)
    image[rows["row"].astype(int), rows["column"].astype(int)] = colours
    # Azimuths grow to the left, and 0 is ahead.
    half = round(SHOWN / STEP)
    return np.roll(image, half, axis=1)[:, 2 * half:0:-1]


def lidar_in_snow(folder):
    """Before and after PointOutlierRemoval."""
    rows = read_samples(folder, "lidar_in_snow.csv")
    figure = plt.figure(figsize=(12.5, 9.6), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=(6.4, 1.4, 1.4))
    for place, (words, shown) in enumerate(
            (("before", rows), ("after", rows[rows["log_odds"] >= 0.0]))):
        above = figure.add_subplot(grid[0, place])
        _draw_from_above(above, shown, words)
        above.set_ylabel("" if place else "y, m")
        axes = figure.add_subplot(grid[place + 1, :])
        axes.imshow(_range_image(shown), aspect="auto", origin="lower", interpolation="none",
                    extent=(SHOWN, -SHOWN, 0.5, RINGS + 0.5))
        axes.set_title(f"{words}, as a range image: near surfaces light, far ones dark, "
                       "white without a point", fontsize=10)
        axes.set(ylabel="ring", xlabel="azimuth, degrees" if place else "")
    figure.legend(handles=[
        plt.Line2D([], [], marker=marker, linestyle="", color=colour, label=words)
        for marker, colour, words in (
            ("o", SNOW, "snow"), ("o", MIXED_ECHO, "mixed echoes at edges"),
            ("o", SURFACE, "surfaces, from above"), ("^", "black", "lidar"))],
        loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=4, fontsize=9, frameon=False)
    return png_of(figure)
