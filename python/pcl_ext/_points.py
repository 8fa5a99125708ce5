# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What clouds and pictures of them have in common."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def check_fields(array: NDArray[Any]) -> None:
    """A view of a cloud, or what was computed of it, may have other fields."""
    if not {"x", "y", "z"} <= set(array.dtype.names or ()):
        raise TypeError(f"points of dtype {array.dtype} have no fields x, y, z")


def finite_points(cloud: NDArray[Any]) -> NDArray[Any]:
    """A copy of the points whose coordinates are finite, of shape (N,)."""
    points = np.ravel(cloud)
    return points[np.all([np.isfinite(points[axis]) for axis in "xyz"], axis=0)]


def has_colours(cloud: NDArray[Any]) -> bool:
    """Whether r, g, b are the colours, and not other fields of these names."""
    fields: Any = cloud.dtype.fields or {}
    return all(name in fields and fields[name][0] == np.uint8 for name in "rgb")


def package(name: str, debian_package: str) -> Any:
    """Imports a package that may be missing."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        top = name.partition(".")[0]
        if error.name != top:
            raise  # The package is there, but what it needs is not.
        raise ImportError(
            f"{top} is missing: pip install {top}, or Debian's {debian_package}",
            name=top,
        ) from error
