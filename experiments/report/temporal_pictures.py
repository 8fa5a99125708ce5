"""The pictures of the section on TemporalVoxelFilter as PNG."""

from pictures import VOXEL_SIZE, plt, png_of, read_samples

COLOURS = {"none": "#4d4d4d", "outliers": "#e08214", "temporal": "#2166ac", "both": "#1b7837"}


def bytes_over_time(folder, names):
    """Bytes of each frame; `names` are the words for the filters in the file."""
    rows = read_samples(folder, "temporal_bytes.csv")
    figure, axes = plt.subplots(figsize=(7, 3.6))
    for name, words in names.items():
        axes.plot(rows["frame"], rows[name], color=COLOURS[name], linewidth=0.9, label=words)
    axes.set(xlabel="frame", ylabel="bytes", ylim=(0, None))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return png_of(figure)


def worst_frame(folder):
    """What was measured beside what is shown."""
    rows = read_samples(folder, "temporal_frame.csv")
    figure, both = plt.subplots(1, 2, figsize=(12.5, 6.6), sharex=True, sharey=True)
    for axes, title, kinds in (
            (both[0], f"frame {rows['frame'][0]:.0f} as measured", (
                ("is_measured", "voxels", "#9a9a9a", 1), ("is_noise", "noise", "#e08214", 2))),
            (both[1], "as shown", (
                ("is_shown", "shown", "#9a9a9a", 1),
                ("is_missed", "surface that is not shown", "#b2182b", 4),
                ("is_ghost", "ghosts", "#2166ac", 4)))):
        for kind, words, colour, size in kinds:
            chosen = rows[rows[kind] > 0]
            axes.scatter(chosen["x"], chosen["y"], s=size * VOXEL_SIZE, marker="s",
                         linewidths=0, c=colour, label=f"{words}: {len(chosen):,}")
        axes.set_aspect("equal")
        axes.set(xlim=(0, 10), ylim=(0, 10), xlabel="x, m")
        axes.set_title(title, fontsize=10)
        axes.legend(loc="lower left", fontsize=8, markerscale=3)
    both[0].set_ylabel("y, m")
    figure.tight_layout()
    return png_of(figure)
