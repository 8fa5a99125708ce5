# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Arguments that several classes take and outcomes that they have, as those of the module."""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any, Mapping, NoReturn, Optional, Union

from . import _native
from ._texts import shown
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


def number_or_nan(number: Any) -> float:
    """A number as a float; NaN for what is none, as a text, which float() reads, or for one
    that is too large."""
    is_text = isinstance(number, (str, bytes, bytearray))
    is_text |= getattr(getattr(number, "dtype", None), "kind", "f") in "SU"
    try:
        return math.nan if is_text else float(number)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def least_intensity(min_intensity: Optional[float]) -> Optional[float]:
    if min_intensity is None:
        return None
    least = number_or_nan(min_intensity)
    if math.isnan(least):
        raise ValueError(f"min_intensity is {shown(min_intensity)}; it must be a number")
    return least


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
    time = number_or_nan(seconds) * MICROSECONDS
    # Also refuses NaN.
    if not 0.0 <= time < end * MICROSECONDS:
        raise ValueError(
            f"{name} is {shown(seconds)}; it must be seconds, not negative and less than "
            f"{end:g} (of nanoseconds pass {name} * 1e-9)"
        )
    return time


def check_text(name: str, text: Any) -> None:
    """Raises ValueError for a text that has no bytes, as a lone surrogate."""
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{name} is {text!r}; it must be a text that UTF-8 has") from None


def metadata_of(metadata: Any) -> Mapping[Any, Any]:
    """The metadata of a stream, or TypeError."""
    if metadata is None:
        return {}
    if not isinstance(metadata, Mapping):
        raise TypeError(f"metadata is {shown(metadata)}; it must be a dict of str")
    return metadata


class Unique:
    """An object with a state of its own that a copy would share: that of a stream, or a
    file. Its settings are those that it was made with."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            raise AttributeError(f"{name} of {type(self).__name__} cannot be set: make another one")
        super().__setattr__(name, value)

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        raise TypeError(f"cannot copy or pickle this {type(self).__name__}: make another one")


def check_recording(code: str, message: str) -> None:
    """Raises what belongs to the status of a recording."""
    if code == "Ok":
        return
    if code == "OutOfMemory":
        raise MemoryError(message)
    if code == "InvalidArgument":
        raise ValueError(message)
    raise Error(message, code)
