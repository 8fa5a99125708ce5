# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Pictures of clouds and recordings with matplotlib.

    recording = pcl_ext.open("cell.mcap")
    recording.frame("/sensor_2", 40).plot()
    matplotlib.pyplot.show()
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional, Sequence

import numpy as np

from ._points import check_fields, finite_points, has_colours, package

if TYPE_CHECKING:
    from numpy.typing import NDArray


def colours_of(cloud: NDArray[Any]) -> NDArray[Any]:
    """What points are coloured by: their own colours, intensity or height.

    Parameters
    ----------
    cloud : numpy.ndarray
        As `Decoder.decode` returns it.

    Returns
    -------
    numpy.ndarray
        Red, green and blue of 0 to 1, of shape (N, 3), or a number for each point.
    """
    if has_colours(cloud):
        return np.stack([cloud[name] for name in "rgb"], axis=-1) / 255
    if "intensity" in (cloud.dtype.names or ()):
        values = cloud["intensity"].astype(float)
        known = values[np.isfinite(values)]
        if len(known) == 0:
            return np.zeros(len(values))
        # Points without an intensity are as those of the lowest. Counts and shares have a few
        # high values, which would hide the others.
        values = np.where(np.isnan(values), np.min(known), values)
        return np.clip(values, np.min(known), max(np.percentile(known, 95), 1e-6))
    return cloud["z"]


def plot_cloud(cloud: NDArray[Any], axes: Any = None) -> Any:
    """Draws the points of a cloud in their colours, by intensity, or by height.

    Parameters
    ----------
    cloud : numpy.ndarray
        As `Decoder.decode` returns it. Missing points are left out.
    axes : matplotlib axes, optional
        Of the projection "3d". Else those of a new figure.

    Returns
    -------
    matplotlib axes
        With equal scales of x, y and z.

    Raises
    ------
    TypeError
        If the cloud has no fields x, y, z, or the axes are others.
    """
    cloud = np.asarray(cloud)
    check_fields(cloud)
    points = finite_points(cloud)
    if axes is None:
        axes = _new_figure().add_subplot(projection="3d")
    elif getattr(axes, "name", None) != "3d":
        raise TypeError('axes are not of the projection "3d"')
    if len(points):
        xyz = [points[axis] for axis in "xyz"]
        axes.scatter(*xyz, c=colours_of(points), s=1.5, linewidths=0)
        axes.set_box_aspect([max(np.ptp(values), 0.1) for values in xyz], zoom=1.1)
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    return axes


def plot_sizes(sizes: Sequence[int], number: Optional[int] = None, axes: Any = None) -> Any:
    """Draws the bytes of frames as bars.

    Parameters
    ----------
    sizes : sequence of int
        Bytes of each frame: ``[len(frame.data) for frame in recording]``.
    number : int, optional
        A frame that is emphasized.
    axes : matplotlib axes, optional
        Else those of a new figure.

    Returns
    -------
    matplotlib axes
        For titles and so on.
    """
    if axes is None:
        axes = _new_figure().add_subplot()
    axes.bar(range(len(sizes)), sizes, width=1.0, color="#9ecae1")
    if number is not None:
        axes.bar([number], [sizes[number]], width=1.0, color="#08519c")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set(xlabel="frame", ylabel="bytes", xlim=(-0.5, len(sizes) - 0.5))
    return axes


def _new_figure() -> Any:
    package("matplotlib", "python3-matplotlib")
    from matplotlib import pyplot

    return pyplot.figure()
