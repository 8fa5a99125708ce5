# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Arguments that several classes take and outcomes that they have, as those of the module."""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any, Optional, Union

from . import _native
from .status import Error

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Buffer = Union[bytes, bytearray, memoryview, NDArray[np.uint8]]

MICROSECONDS = 1e6
# Of recordings, seconds: nanoseconds have 63 bits.
END_OF_TIME = 9.2e9


def limits(
    max_voxels: Optional[int],
    max_frame_bytes: Optional[int],
    max_points: Optional[int],
    max_field_values: Optional[int],
) -> dict[str, Optional[int]]:
    """Limits of decoding. Only those of a recording may be None."""
    return {
        "max_voxels": max_voxels,
        "max_frame_bytes": max_frame_bytes,
        "max_points": max_points,
        "max_field_values": max_field_values,
    }


def least_intensity(min_intensity: Optional[float]) -> Optional[float]:
    if min_intensity is None:
        return None
    if isinstance(min_intensity, (str, bytes)) or math.isnan(min_intensity):
        raise ValueError(f"min_intensity is {min_intensity!r}; it must be a number")
    return float(min_intensity)


def whole_number(name: str, number: Any) -> int:
    """A number of a stream or a frame, or TypeError."""
    try:
        return operator.index(number)
    except TypeError:
        raise TypeError(f"{name} is {number!r}; it must be a whole number") from None


def microseconds(name: str, seconds: Any, end: float) -> float:
    """A time in microseconds, not rounded.

    Parameters
    ----------
    name : str
        For messages.
    seconds : float
        A time of 0 to less than `end`.
    """
    try:
        time = float(seconds) * MICROSECONDS
    except (TypeError, ValueError):
        time = math.nan
    # Also refuses NaN.
    if not 0.0 <= time < end * MICROSECONDS:
        raise ValueError(
            f"{name} is {seconds!r}; it must be seconds, not negative and less than "
            f"{end:g} (of nanoseconds pass {name} * 1e-9)"
        )
    return time


def check_recording(code: str, message: str) -> None:
    """Raises what belongs to the status of a recording."""
    if code == "Ok":
        return
    if code == "OutOfMemory":
        raise MemoryError(message)
    if code == "InvalidArgument":
        raise ValueError(message)
    raise Error(message, code)
