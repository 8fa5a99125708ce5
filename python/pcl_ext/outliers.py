# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Removal of noise from the voxels of a stream, and from the points of a lidar."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Optional, Protocol, Sequence

from . import _native
from ._arguments import Unique
from ._texts import call_of, counted
from .status import Status

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    class _Decoder(Protocol):
        """What `OutlierRemoval.score` needs of a `Decoder`."""

        _native: _native.Decoder


Unit = Literal["automatic", "faces", "points", "voxels", "rays"]


class OutlierRemoval(Unique):
    """Removes noise from the voxels of one stream by their neighbourhood in this frame and
    previous ones.

    It works on voxels, not on points: give it to `Decoder.decode` (or to
    `Encoder.encode`, which saves bytes) with every frame of the stream, in order. An
    instance is for one stream.

    Parameters
    ----------
    unit : str
        What voxels are judged by. "points": counts of depth cameras (law "count"); "faces":
        the laws "quadratic" and "linear"; "rays": lidars, for snow; "voxels":
        native intensities, or none, and lidars that stand still; "automatic": "faces" from
        the first frame on that has a depth model, else "rays" from the first one on that is
        the scan of a lidar, else "voxels". See `unit`.
    min_log_odds : float
        Voxels of lower log-odds of surface against noise are removed; natural logarithm.
        0 removes 79 to 90 % of a depth camera's noise at 4 cm; higher values remove more,
        also of surfaces.
    max_blocks : int
        Most blocks of 4 x 4 x 4 voxels to remember, about 270 bytes each.
    use_history : bool, optional
        Also use the voxels of previous frames: True. All units but "rays" have it.
    full_intensity : float, optional
        Of "faces": intensity of a voxel face that is completely covered, 255.
    sensor_position : (float, float, float), optional
        Of "rays": where the lidar is, metres, in the coordinates of the cloud; the origin.
        Frames that are scans of a lidar have it themselves, and the angles.
    azimuth_step, elevation_step : float, optional
        Of "rays": angles between rays of a row and between rows, radians, 0.0001 to 1;
        0.0035 and 0.007, which are 0.2 and 0.4 degrees. Need be right to 30 %.
    intensities_are_counts : bool, optional
        Of "rays" and "automatic": intensities are numbers of points (law "count"); used
        where the frame has none itself. False: each voxel counts as one point.

    Raises
    ------
    ValueError, TypeError
        If a setting is outside its range, or is none of the unit's.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> removal = pcl_ext.OutlierRemoval(unit="points")
    >>> frame = pcl_ext.Encoder(law="count").encode(numpy.random.rand(1000, 3))
    >>> cloud = pcl_ext.Decoder().decode(frame, outliers=removal)
    >>> removal.status.ok
    True
    """

    def __init__(
        self,
        unit: Unit = "automatic",
        *,
        min_log_odds: float = 0.0,
        max_blocks: int = 1 << 17,
        use_history: Optional[bool] = None,
        full_intensity: Optional[float] = None,
        sensor_position: Optional[Sequence[float]] = None,
        azimuth_step: Optional[float] = None,
        elevation_step: Optional[float] = None,
        intensities_are_counts: Optional[bool] = None,
    ):
        of_unit = {
            "use_history": use_history,
            "full_intensity": full_intensity,
            "sensor_position": sensor_position,
            "azimuth_step": azimuth_step,
            "elevation_step": elevation_step,
            "intensities_are_counts": intensities_are_counts,
        }
        named = {name: value for name, value in of_unit.items() if value is not None}
        settings: dict[str, Any] = {
            "unit": unit,
            "min_log_odds": min_log_odds,
            "max_blocks": max_blocks,
            **named,
        }
        self._native = _native.OutlierRemoval(settings)
        self._call = call_of(self, settings)

    def __repr__(self) -> str:
        code, _, removed = self._native.status()
        judged = f"by {self.unit!r} {counted(removed, 'voxel')} of the last frame removed"
        return f"<{self._call}: {judged if code == 'Ok' else code}>"

    @property
    def status(self) -> Status:
        """Why voxels of the last frame were not judged, if they were not: all of them stay
        then."""
        code, message, _ = self._native.status()
        return Status(code, message)

    @property
    def removed(self) -> int:
        """Number of voxels that were removed from the last frame."""
        return self._native.status()[2]

    @property
    def unit(self) -> Unit:
        """What the last frame was judged by; before the first one what was asked for."""
        return self._native.unit()

    def score(self, decoder: _Decoder) -> NDArray[np.float32]:
        """Computes the log-odds of the points that a decoder returned last, in their order,
        instead of removing any.

        Call it once for each decoded frame, in place of ``decode(..., outliers=...)``.

        Parameters
        ----------
        decoder : Decoder
            After its call of `Decoder.decode`.

        Returns
        -------
        numpy.ndarray
            float32, one for each point, in the shape of the cloud: natural logarithm of the
            odds of surface against noise; infinite where none is judged (see `status`), NaN
            where a cloud of rows and columns has no point, or a point is too far away for a
            voxel.
        """
        native = getattr(decoder, "_native", None)
        if not isinstance(native, _native.Decoder):
            raise TypeError(f"decoder is a '{type(decoder).__name__}', not a Decoder")
        return self._native.score(native)

    def reset(self) -> None:
        """Forgets all frames, as at the start of a stream."""
        self._native.reset()


class PointOutlierRemoval(Unique):
    """Tells snow and other noise that floats in the air from surfaces in the clouds of a
    lidar that turns, before they are encoded.

    Each point is judged by the ranges of the rays around it. An instance is for one sensor.

    Parameters
    ----------
    min_log_odds : float
        Points of lower log-odds of surface against noise count as noise in `removed`; natural
        logarithm.
    use_history : bool
        Also use the last cloud, as long as the sensor stands still.

    Raises
    ------
    ValueError, TypeError
        If a setting is outside its range.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> azimuth, height = numpy.meshgrid(numpy.arange(0, 6.28, 0.01), numpy.arange(-1, 1, 0.1))
    >>> cloud = numpy.stack((9 * numpy.cos(azimuth), 9 * numpy.sin(azimuth), height), axis=-1)
    >>> cloud[10, 300] *= 0.2  # a snow flake
    >>> removal = pcl_ext.PointOutlierRemoval()
    >>> cloud[removal.score(cloud) < 0] = numpy.nan
    >>> numpy.isnan(cloud[10, 300]).all(), removal.removed
    (True, 1)
    """

    def __init__(self, *, min_log_odds: float = 0.0, use_history: bool = True):
        settings = {"min_log_odds": min_log_odds, "use_history": use_history}
        self._native = _native.PointOutlierRemoval(settings)
        self._call = call_of(self, settings)

    def __repr__(self) -> str:
        code, _, removed = self._native.status()
        judged = f"{counted(removed, 'point')} of the last cloud are noise"
        return f"<{self._call}: {judged if code == 'Ok' else code}>"

    @property
    def status(self) -> Status:
        """Why points of the last cloud were not judged, if they were not."""
        code, message, _ = self._native.status()
        return Status(code, message)

    @property
    def removed(self) -> int:
        """Number of points of the last cloud below min_log_odds."""
        return self._native.status()[2]

    def score(self, xyz: ArrayLike) -> NDArray[np.float32]:
        """Computes the log-odds of the points of the sensor's next cloud.

        Parameters
        ----------
        xyz : array_like
            float32 or float64 of shape (rows, columns, 3) or (N, 3), or a structured array
            with fields x, y, z, metres, in the coordinates of the sensor, whose z is the axis
            of its turns. Rows are those of the array, else a field ``ring``, else they are
            told from the directions of the points.

        Returns
        -------
        numpy.ndarray
            float32 in the shape of the cloud: natural logarithm of the odds of surface against
            noise; infinite where none is judged (see `status`).
        """
        return self._native.score(xyz)

    def reset(self) -> None:
        """Forgets the last cloud, as at the start of a stream."""
        self._native.reset()


def removal(outliers: Optional[OutlierRemoval]) -> Optional[_native.OutlierRemoval]:
    if outliers is None:
        return None
    if isinstance(outliers, PointOutlierRemoval):
        raise TypeError(
            "outliers is a 'PointOutlierRemoval', which judges points, not voxels: "
            "set those with score(xyz) < 0 to NaN before encoding"
        )
    if not isinstance(outliers, OutlierRemoval):
        raise TypeError(
            f"outliers is a '{type(outliers).__name__}', not an OutlierRemoval"
        )
    return outliers._native
