# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What is asked of frames and decoded clouds, and what can be chosen by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Tuple

import numpy as np

from . import _native
from ._arguments import limits
from ._points import check_fields
from .status import Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ._arguments import Buffer


class FrameSize(NamedTuple):
    """What `frame_size` found at the beginning of some bytes.

    Attributes
    ----------
    status : Status
        Ok: the size is known. "Truncated": more bytes are needed to know it. Else: no frame
        begins here.
    known : int
        Bytes of the whole frame, of which fewer may be there; 0 if they are not known.
    needed : int
        Bytes that the frame has at least; as `known`, if that is not 0.
    drop : int
        Bytes without a frame, after which one may begin.
    """

    status: Status
    known: int
    needed: int
    drop: int


class FrameField(NamedTuple):
    """A further field of the points of a frame, see `Encoder`."""

    name: str  #: as in the cloud that was encoded
    dtype: str  #: "int8" to "int32", "uint8" to "uint32", "float32" or "float64"
    count: int  # type: ignore[assignment]  #: values of a point
    step: float  #: values are multiples of it, in the unit of the field; 0: exact


def frame_size(
    data: Buffer,
    *,
    max_voxels: int = 1 << 26,
    max_frame_bytes: int = 1 << 28,
    max_points: int = 1 << 30,
    max_field_values: int = 1 << 30,
) -> FrameSize:
    """Tells how many bytes the frame at the beginning of some bytes has, for bytes that
    arrive in pieces, as from a socket.

    Parameters
    ----------
    data : bytes, bytearray, memoryview or numpy.ndarray of uint8
        The bytes at hand; may be empty.
    max_voxels, max_frame_bytes, max_points, max_field_values : int
        Limits of the `Decoder` that gets the frame.

    Returns
    -------
    FrameSize
        `status`, `known`, `needed` and `drop`.
    """
    code, message, *sizes = _native.frame_size(
        data, limits(max_voxels, max_frame_bytes, max_points, max_field_values)
    )
    return FrameSize(Status(code, message), *sizes)


def positions(cloud: NDArray[Any]) -> NDArray[Any]:
    """The coordinates of a decoded cloud, not copied.

    Parameters
    ----------
    cloud : numpy.ndarray
        As `Decoder.decode` returns it, or a part of it.

    Returns
    -------
    numpy.ndarray
        float32 of shape (N, 3), or float64 for clouds far from the origin, metres. Changes
        of it change the cloud.

    Raises
    ------
    TypeError
        If the cloud has no fields x, y, z.
    ValueError
        If these are not floats of one type side by side.
    """
    cloud = np.asarray(cloud)
    check_fields(cloud)
    type_of_x, offset = cloud.dtype.fields["x"][:2]  # type: ignore[index]
    for axis, name in enumerate("xyz"):
        place = offset + axis * type_of_x.itemsize
        if (
            type_of_x not in (np.dtype("f4"), np.dtype("f8"))
            or cloud.dtype.fields[name][:2] != (type_of_x, place)  # type: ignore[index]
        ):
            raise ValueError(
                f"x, y, z of dtype {cloud.dtype} are not floats of one type side by side"
            )
    return np.lib.stride_tricks.as_strided(
        cloud["x"], (*cloud.shape, 3), (*cloud.strides, type_of_x.itemsize)
    )


def sensors() -> dict[str, Tuple[float, float, int, int]]:
    """The sensors that an `Encoder` knows by name.

    Returns
    -------
    dict
        Horizontal and vertical field of view, degrees, columns and rows, by name.
    """
    return _native.sensors()


def laws() -> list[str]:
    """The laws of intensity that an `Encoder` knows, besides "automatic"."""
    return _native.laws()
