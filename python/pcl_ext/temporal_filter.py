# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Telling the voxels of surfaces from noise over time."""

from __future__ import annotations

from typing import Optional, Sequence

from . import _native
from ._arguments import Unique
from ._texts import call_of, counted
from .status import Status


class TemporalVoxelFilter(Unique):
    """Shows the voxels of one stream that were likely surfaces in the last frames, in place
    of those that the sensor happened to hit: what stands still does not flicker.

    It is for streams that were encoded without: give it to `Decoder.decode` with every frame
    of the stream, in order. `Encoder` has it as ``temporal_filter``, which saves most of the
    bytes. It is lossy. An instance is for one stream.

    Parameters
    ----------
    frames : int
        Number of frames over which a voxel's occupancy is averaged, 2 to 64. 8 suits sensors
        of 10 to 30 Hz.
    sensor_position : (float, float, float), optional
        Where the sensor is, metres, in the coordinates of the clouds: what it sees through
        is hidden in the second frame. By default it is unknown, and what is gone stays for five
        eighths of `frames` twentieths of a second, by the frames' stamps. Frames without a
        stamp count as a twentieth of a second each.

    Raises
    ------
    ValueError, TypeError
        If a setting is outside its range.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> temporal_filter = pcl_ext.TemporalVoxelFilter()
    >>> frame = pcl_ext.Encoder(0.1, law="count").encode(numpy.random.rand(1000, 3))
    >>> cloud = pcl_ext.Decoder().decode(frame, temporal_filter=temporal_filter)
    >>> temporal_filter.status.ok
    True
    """

    def __init__(
        self,
        frames: int = 8,
        *,
        sensor_position: Optional[Sequence[float]] = None,
    ):
        settings = {"frames": frames, "sensor_position": sensor_position}
        self._native = _native.TemporalVoxelFilter(settings)
        self._call = call_of(self, settings)

    def __repr__(self) -> str:
        code, _, hidden, held = self._native.status()
        filtered = f"{counted(hidden, 'voxel')} of the last frame hidden, {held:,} held"
        return f"<{self._call}: {filtered if code == 'Ok' else code}>"

    @property
    def status(self) -> Status:
        """Why the last frame was not filtered, if it was not: it has numbers of points."""
        code, message, _, _ = self._native.status()
        return Status(code, message)

    @property
    def hidden(self) -> int:
        """Number of voxels of the last frame that are not shown."""
        return self._native.status()[2]

    @property
    def held(self) -> int:
        """Number of voxels that are shown, but were not in the last frame."""
        return self._native.status()[3]

    def reset(self) -> None:
        """Forgets all frames, as at the start of a stream."""
        self._native.reset()


def native_filter(
    temporal_filter: Optional[TemporalVoxelFilter],
) -> Optional[_native.TemporalVoxelFilter]:
    if temporal_filter is None:
        return None
    if not isinstance(temporal_filter, TemporalVoxelFilter):
        raise TypeError(
            f"temporal_filter is a '{type(temporal_filter).__name__}', not a "
            "TemporalVoxelFilter"
        )
    return temporal_filter._native
