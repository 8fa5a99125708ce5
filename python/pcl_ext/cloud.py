# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Decoded clouds, and what other packages make of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._points import check_fields, finite_points, has_colours, package
from ._texts import counted

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

# What Open3D calls the coordinates and the colours.
_NAMES_OF_OPEN3D = {"positions", "colors"}


class Cloud(np.ndarray):  # type: ignore[type-arg]
    """A structured numpy array with a row for each point, as `Decoder.decode` returns it.

    It is used as any array of numpy: ``cloud["x"]``, ``cloud[cloud["intensity"] > 2]``. Its
    methods give it to other packages, which they import when they are called. What functions of
    numpy make of it may be a plain array: ``pcl_ext.Cloud(numpy.concatenate([a, b]))``.

    Parameters
    ----------
    points : array_like
        Structured, with fields x, y, z and any others. Not copied.

    Raises
    ------
    TypeError
        If it has no fields x, y, z.
    """

    def __new__(cls, points: ArrayLike) -> Cloud:
        array = np.asarray(points)
        check_fields(array)
        return array.view(cls)

    def __repr__(self) -> str:
        # What numpy makes of a cloud, as by == or view(), has the class also without fields.
        if self.dtype.names is None:
            return repr(self.view(np.ndarray))
        points = np.ravel(self).view(np.ndarray)
        size = "" if self.ndim < 2 else " in " + " x ".join(map(str, self.shape))
        fields = [_range(name, points[name]) for name in self.dtype.names]
        return f"<Cloud of {counted(len(points), 'point')}{size}: {', '.join(fields)}>"

    def __getitem__(self, index: Any) -> Any:
        part = super().__getitem__(index)
        # The values of a field are no cloud.
        if isinstance(part, Cloud) and part.dtype.names is None:
            return part.view(np.ndarray)
        return part

    def to_pandas(self) -> Any:
        """Copies the cloud into a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each point, a column for each field, in its dtype; of several values
            a column each, as normal_0, normal_1. The rows of a cloud of rows and columns
            follow each other; x, y, z of missing points are NaN.

        Raises
        ------
        ImportError
            Without pandas.
        """
        check_fields(self)
        pandas = package("pandas", "python3-pandas")
        columns: dict[str, NDArray[Any]] = {}
        points = np.ravel(self)
        for name in points.dtype.names or ():
            values = points[name]
            for place, column in enumerate(_table(values).T):
                title = name if values.ndim == 1 else f"{name}_{place}"
                columns[_unused(title, columns)] = column
        return pandas.DataFrame(columns)

    def to_open3d(self) -> Any:
        """Copies the cloud into one of Open3D, whose tensors keep types and all fields.

        ``cloud.to_open3d().to_legacy()`` is an ``open3d.geometry.PointCloud``, as
        ``open3d.visualization.draw_geometries`` takes it.

        Returns
        -------
        open3d.t.geometry.PointCloud
            With the attributes positions, colors (uint8) of fields r, g, b, and each further
            field under its name, in its dtype, of shape (N, values); fields called positions
            or colors have "_" added. Missing points are left out.

        Raises
        ------
        ImportError
            Without Open3D.
        """
        check_fields(self)
        open3d = package("open3d", "python3-open3d")
        points = finite_points(self)

        def tensor(values: NDArray[Any]) -> Any:
            return open3d.core.Tensor(np.ascontiguousarray(_table(values)))

        left = [name for name in points.dtype.names or () if name not in tuple("xyz")]
        made = open3d.t.geometry.PointCloud(tensor(_side_by_side(points, "xyz")))
        if has_colours(points):
            made.point["colors"] = tensor(_side_by_side(points, "rgb"))
            left = [name for name in left if name not in tuple("rgb")]
        for name in left:
            made.point[_unused(name, _NAMES_OF_OPEN3D)] = tensor(points[name])
        return made

    def plot(self, axes: Any = None) -> Any:
        """Draws the cloud with matplotlib, see `pcl_ext.plotting.plot_cloud`.

        Parameters
        ----------
        axes : matplotlib axes, optional
            Of the projection "3d". Else those of a new figure.

        Returns
        -------
        matplotlib axes
            For titles and so on. ``matplotlib.pyplot.show()`` shows them.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        from .plotting import plot_cloud

        return plot_cloud(self, axes)


def _range(name: str, values: NDArray[Any]) -> str:
    """The name of a field, with the range of its numbers."""
    if values.ndim > 1 or not np.issubdtype(values.dtype, np.number):
        return name
    known = values[np.isfinite(values)]
    return f"{name} {known.min():.6g} to {known.max():.6g}" if len(known) > 0 else name


def _side_by_side(points: NDArray[Any], names: str) -> NDArray[Any]:
    return np.stack([points[name] for name in names], axis=1)


def _table(values: NDArray[Any]) -> NDArray[Any]:
    """A row for each point, a column for each of its values."""
    return values.reshape(len(values), int(np.prod(values.shape[1:])))


def _unused(name: str, used: Any) -> str:
    """A name as decoding makes it of one that is taken."""
    while name in used:
        name += "_"
    return name
