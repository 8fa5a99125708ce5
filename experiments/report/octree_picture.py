"""Figure 7: a small octree."""

import matplotlib.pyplot as plt
import numpy as np

LEVEL_COLOURS = {3: "#b2182b", 2: "#ef8a62", 1: "#67a9cf", 0: "#2166ac"}


def _edges_of_cube(low, edge):
    """The twelve edges, each as two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    for one in corners:
        for other in corners:
            if (other - one).sum() == 1 and np.abs(other - one).sum() == 1:
                yield low + edge * np.array([one, other])


def _draw_cells(axes, cells, level):
    for cell in cells[cells["level"] == level]:
        low = np.array([cell["x"], cell["y"], cell["z"]])
        for line in _edges_of_cube(low, cell["edge"]):
            axes.plot(*line.T, color=LEVEL_COLOURS[level], linewidth=0.9)


def _draw_voxels(axes, voxels, quantity, low, edge, of_axis):
    filled = np.zeros((of_axis,) * 3, dtype=bool)
    faces = np.zeros((of_axis,) * 3 + (4,))
    top = voxels[quantity].max()
    for voxel in voxels:
        place = tuple(np.floor((np.array([voxel["x"], voxel["y"], voxel["z"]]) - low)
                               / edge).astype(int))
        filled[place] = True
        faces[place] = plt.cm.viridis(voxel[quantity] / top)
    corners = np.indices((of_axis + 1,) * 3) * edge
    axes.voxels(*(corners[axis] + low[axis] for axis in range(3)), filled,
                facecolors=faces, edgecolor="#00000055", linewidth=0.3)
    scale = plt.cm.ScalarMappable(plt.Normalize(0, top), plt.cm.viridis)
    bar = axes.figure.colorbar(scale, ax=axes, orientation="horizontal", shrink=0.6,
                               pad=0.12, ticks=np.linspace(0, top, 4).round())
    bar.ax.tick_params(labelsize=8)


def _lay_out(axes, low, size):
    for axis, name in enumerate("xyz"):
        getattr(axes, f"set_{name}lim")(low[axis], low[axis] + size)
        getattr(axes, f"set_{name}ticks")(low[axis] + np.array([0.0, 0.5, 1.0]) * size)
    # The grid of the axes would pass for the octree's.
    axes.grid(False)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.pane.fill = False
    axes.view_init(elev=28, azim=-125)
    axes.set_box_aspect((1, 1, 1))
    axes.tick_params(labelsize=6)


def _centimetres(edge):
    return f"{100 * edge:.0f} cm"


def _draw_tree(axes, cells, voxels):
    """The nodes of each level under their parents; leaves by quadratic intensity."""
    top_level = int(cells["level"].max())
    root = cells[cells["level"] == top_level][0]
    low = np.array([root["x"], root["y"], root["z"]])

    def path(place, level):
        """Which child of each cell from the root on."""
        steps = []
        corner, edge = low.copy(), root["edge"]
        for _ in range(top_level - level):
            edge /= 2
            upper = place >= corner + edge
            steps.append(int(upper[0]) * 4 + int(upper[1]) * 2 + int(upper[2]))
            corner = corner + edge * upper
        return tuple(steps)
    leaves = sorted((path(np.array([voxel["x"], voxel["y"], voxel["z"]]), 0),
                     voxel["quadratic"]) for voxel in voxels)
    across = {leaf: place for place, (leaf, _) in enumerate(leaves)}
    for level in range(0, top_level + 1):
        nodes = {}
        for leaf, _ in leaves:
            nodes.setdefault(leaf[:top_level - level], []).append(across[leaf])
        for node, below in nodes.items():
            place = np.mean([min(below), max(below)])
            if level < top_level:
                parent = [across[leaf] for leaf, _ in leaves
                          if leaf[:len(node) - 1] == node[:-1]]
                axes.plot([place, np.mean([min(parent), max(parent)])],
                          [level, level + 1], color="#999999", linewidth=0.6, zorder=1)
            if level > 0:
                axes.scatter([place], [level], s=45, marker="s",
                             c=LEVEL_COLOURS[level], zorder=2)
        edge = cells[cells["level"] == level][0]["edge"]
        axes.text(-0.02, level, f"{_centimetres(edge)}: {len(nodes)}", ha="right",
                  va="center", fontsize=9, transform=axes.get_yaxis_transform())
    axes.scatter(range(len(leaves)), np.zeros(len(leaves)), s=45, marker="s",
                 c=[intensity for _, intensity in leaves], cmap="viridis", vmin=0,
                 zorder=2)
    axes.set_ylim(-0.4, top_level + 0.4)
    axes.axis("off")
    axes.set_title("the tree: occupied cells of each level, voxels by quadratic intensity",
                   fontsize=10)


def small_octree(points, voxels, cells):
    """The figure; cells of all levels, 0 being the voxels'."""
    top_level = int(cells["level"].max())
    root = cells[cells["level"] == top_level][0]
    low, size = np.array([root["x"], root["y"], root["z"]]), root["edge"]
    edge = size / 2 ** top_level
    figure = plt.figure(figsize=(12, 13.2))
    grid = figure.add_gridspec(3, 3, height_ratios=(1, 1, 0.75))

    def add_axes(place, title):
        axes = figure.add_subplot(grid[place // 3, place % 3], projection="3d")
        axes.set_title(title, fontsize=10)
        _lay_out(axes, low, size)
        return axes
    for place, level in enumerate(range(top_level, 0, -1)):
        of_level = cells[cells["level"] == level]
        axes = add_axes(place, f"level {top_level - level}: {len(of_level)} of "
                        f"{8 ** (top_level - level)} cells of "
                        f"{_centimetres(of_level[0]['edge'])} occupied")
        _draw_cells(axes, cells, level)
        axes.scatter(points["x"], points["y"], points["z"], s=3, c="#333333",
                     depthshade=False)
    axes = add_axes(3, f"level {top_level}: {len(voxels)} voxels of {_centimetres(edge)}")
    _draw_cells(axes, cells, 0)
    # As much room as the two beside it have over their scales.
    figure.colorbar(plt.cm.ScalarMappable(), ax=axes, orientation="horizontal", shrink=0.6,
                    pad=0.12).ax.set_visible(False)
    for place, quantity, words in ((4, "count", "number of points"),
                                   (5, "quadratic", "quadratic intensity")):
        _draw_voxels(add_axes(place, "voxels: " + words), voxels, quantity, low, edge,
                     2 ** top_level)
    _draw_tree(figure.add_subplot(grid[2, :]), cells, voxels)
    return figure
