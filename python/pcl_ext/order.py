# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The order in which a lidar measured its points, restored from their fields."""

import operator
from typing import Any, Optional, Sequence, Tuple

import numpy as np
from numpy.typing import NDArray

from ._points import check_fields, finite_points
from ._texts import shown

_MOST_SIDE = 1 << 16
_MOST_PIXELS = 1 << 24


def _field(cloud: NDArray[Any], name: Optional[str], usual: Sequence[str]) -> NDArray[Any]:
    """The values of a field, or of the first one of usual names."""
    names = usual if name is None else (name,)
    for wanted in names:
        if wanted in (cloud.dtype.names or ()):
            values: NDArray[Any] = cloud[wanted]
            if values.ndim > cloud.ndim:
                raise ValueError(f"field {wanted!r} has several values a point")
            if np.isnan(values).any():
                raise ValueError(f"field {wanted!r} of a point is not a number")
            return values
    raise ValueError(f"the cloud has no field {', '.join(map(repr, names))}")


def sort_by_time(
    cloud: NDArray[Any], *, time: Optional[str] = None, ring: Optional[str] = None
) -> NDArray[Any]:
    """Sorts points as a lidar measured them: by time, those of the same time by ring.

    Decoded clouds whose points are in the order of their voxels, or row by row, get
    that of the sensor back, if these fields were kept (`Encoder(fields=...)`).

    Parameters
    ----------
    cloud : numpy.ndarray
        Structured, with x, y, z and the two fields; points whose coordinates are not
        finite are left out.
    time : str, optional
        Field of when a point was measured, any unit. Else the first one of t, time,
        timestamp, time_stamp and offset_time.
    ring : str, optional
        Field of the laser. Else the first one of ring, channel and line.

    Returns
    -------
    numpy.ndarray
        A copy of shape (N,).

    Raises
    ------
    TypeError
        If the cloud has no fields x, y, z.
    ValueError
        Without the two fields, or if a value of them is not a number.
    """
    cloud = np.asarray(cloud)
    check_fields(cloud)
    points = finite_points(cloud)
    times = _field(points, time, ("t", "time", "timestamp", "time_stamp", "offset_time"))
    rings = _field(points, ring, ("ring", "channel", "line"))
    return points[np.lexsort((rings, times))]


def _columns(times: NDArray[Any]) -> NDArray[Any]:
    """Columns of sorted times, from 0 on, as floats."""
    gaps = np.diff(times.astype("f8"))
    steps = gaps[gaps > 0]
    if 2 * (len(steps) + 1) > len(times) > 0:
        raise ValueError(
            "most points have a time of their own: there are no columns of points of the "
            "same time"
        )
    if len(steps) > 0:
        steps = steps[steps < 1.5 * np.sort(steps)[len(steps) // 2]]
        gaps = np.where(gaps > 0, np.fmax(1, np.round(gaps / steps.mean())), 0)
    return np.concatenate(([0.0], np.cumsum(gaps)))[: len(times)]


def _sides(shape: Any) -> Tuple[int, int]:
    try:
        rows, columns = map(operator.index, shape)
    except (TypeError, ValueError):
        raise TypeError(
            f"shape is {shown(shape)}; it must be two whole numbers, rows and columns"
        ) from None
    return rows, columns


def arrange_by_ring(
    cloud: NDArray[Any],
    shape: Optional[Tuple[int, int]] = None,
    *,
    time: Optional[str] = None,
    ring: Optional[str] = None,
) -> NDArray[Any]:
    """Puts points into rows and columns as a lidar measured them.

    Each ring is a row, each time a column, for lidars whose points of a column have the
    same time. Columns begin with the first time; where times are further apart than most,
    columns without points are between them.

    Parameters
    ----------
    cloud : numpy.ndarray
        As for `sort_by_time`.
    shape : (int, int), optional
        Rows and columns; else as many as the points need.
    time, ring : str, optional
        As for `sort_by_time`.

    Returns
    -------
    numpy.ndarray
        A copy of two dimensions. Missing points are NaN, their integers 0.

    Raises
    ------
    TypeError
        As `sort_by_time`; if `shape` is not two whole numbers.
    ValueError
        As `sort_by_time`; if rings are no whole numbers from 0 on, if two points have the
        same ring and time, if times differ within columns, or if the points need more
        than `shape`, 65536 rows or columns, or 2^24 pixels.
    """
    most = np.array((_MOST_SIDE, _MOST_SIDE) if shape is None else _sides(shape))
    points = sort_by_time(cloud, time=time, ring=ring)
    rings = _field(points, ring, ("ring", "channel", "line")).astype("f8")
    columns = _columns(
        _field(points, time, ("t", "time", "timestamp", "time_stamp", "offset_time"))
    )
    if np.any(rings < 0) or np.any(rings != np.floor(rings)):
        raise ValueError("the ring of a point is not a whole number from 0 on")
    needed = np.array([rings.max(initial=-1) + 1, columns.max(initial=-1) + 1])
    if np.any(needed > most):
        raise ValueError(
            f"the points need {needed[0]:g} rows and {needed[1]:g} columns; there may be "
            f"{most[0]} and {most[1]}"
        )
    rows, width = (needed if shape is None else most).astype(int)
    if rows * width > _MOST_PIXELS:
        raise ValueError(f"{rows} rows and {width} columns are more than {_MOST_PIXELS} pixels")
    arranged = np.zeros_like(points, shape=(rows, width))
    for name in points.dtype.names or ():
        if np.issubdtype(points.dtype[name].base, np.floating):
            arranged[name] = np.nan
    pixels = rings.astype(int) * width + columns.astype(int)
    if len(np.unique(pixels)) < len(pixels):
        raise ValueError("two points have the same ring and time")
    arranged.reshape(-1)[pixels] = points
    return arranged
