# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Encoder and decoder of streams of point clouds."""

from __future__ import annotations

import re
import warnings
from numbers import Real
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    Literal,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    Union,
)

from . import _native
from ._arguments import (
    MICROSECONDS,
    Unique,
    check_text,
    least_intensity,
    limits,
    microseconds,
)
from ._texts import call_of, counted
from .cloud import Cloud
from .outliers import OutlierRemoval, removal
from .statistics import CloudStatistics, FrameStatistics, RateControlStatus
from .status import Error, Status
from .temporal_filter import TemporalVoxelFilter, native_filter

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._arguments import Buffer

Effort = Literal["fast", "balanced", "small"]
Law = Literal["automatic", "count", "quadratic", "linear", "native", "none"]
Sensor = Union[str, Tuple[float, float, int, int]]
Fields = Union[
    str,
    Sequence[Union[str, Tuple[str, Optional[float]]]],
    Dict[str, Optional[float]],
]

# Types of fields that can be kept, in the machine's byte order.
_FIELD_TYPES, _FIELD_DEMAND = _native.field_types()


class CompressionWarning(UserWarning):
    """Not all of a cloud is in its frame, or not all of a frame in what is decoded."""


# Limits of the library.
_MOST_NAME_BYTES = 64
_MOST_VALUES = 4096


def _fault(name: str, dtype: Any) -> str:
    """Why a field cannot be kept, by its name and its dtype; empty if it can."""
    name_bytes = len(name.encode("utf-8", "replace"))
    if not 0 < name_bytes <= _MOST_NAME_BYTES:
        return f"its name has {name_bytes} bytes, not 1 to {_MOST_NAME_BYTES}"
    if not dtype.base.isnative or dtype.base.name not in _FIELD_TYPES:
        return f"of {dtype.base}"
    values = dtype.itemsize // dtype.base.itemsize
    if not 0 < values <= _MOST_VALUES:
        return f"{values:,} values a point, not 1 to {_MOST_VALUES:,}"
    return ""


def _loses_alpha(xyz: Any, colour: Optional[str], kept: set[str]) -> bool:
    """Whether frames, which have red, green and blue, lose an alpha."""
    if colour != "rgba" or colour in kept:
        return False
    bits = xyz[colour].astype(xyz.dtype[colour], order="C").view("u4")
    return bool((bits >> 24 != 255).any())


def _left_out(xyz: Any, kept: set[str], codes_colours: bool, loses_intensity: bool) -> str:
    """The fields of a structured array that are not encoded, in words."""
    dtype: Any = getattr(xyz, "dtype", None)
    names = getattr(dtype, "names", None) or ()
    colour = next((name for name in ("rgb", "rgba") if name in names), None)
    channels = {"r", "g", "b"}
    known = {"x", "y", "z"} | (set() if loses_intensity else {"intensity"})
    known |= {colour} if colour else channels if channels <= set(names) else set()
    known |= kept - {"all"}
    faults = {}
    if "all" in kept:
        colours = {"rgb", "rgba"} if codes_colours else set()
        faults = {name: _fault(name, dtype[name]) for name in names}
        known |= {name for name in names if not faults[name]} - colours
    loses_alpha = codes_colours and _loses_alpha(xyz, colour, kept)
    if loses_alpha:
        known.discard("rgba")
    left_out = [
        "the alpha of rgba"
        if loses_alpha and name == "rgba"
        else (name or "''") + (f" ({faults[name]})" if faults.get(name) else "")
        for name in names
        if name not in known
    ]
    if not left_out:
        return ""
    remedy = f"; a type must be {_FIELD_DEMAND}" if "(of " in "".join(left_out) else ""
    return f"fields of xyz that are left out: {', '.join(left_out)}{remedy}"


def _order_lost(xyz: Any, keep_order: bool, loses_order: bool) -> str:
    """That rows and columns do not come back, in words."""
    shape: Any = getattr(xyz, "shape", ())
    has_fields = getattr(getattr(xyz, "dtype", None), "names", None) is not None
    if len(shape) != (2 if has_fields else 3):
        return ""
    if loses_order:
        return "the rows and columns of xyz are not kept, as outliers are removed from voxels"
    if keep_order and 1 in shape[:2]:
        line = "column" if shape[1] == 1 else "row"
        return f"the one {line} of xyz is kept as ({shape[0] * shape[1]},), without what is NaN"
    return ""


def _last_frame(frame: FrameStatistics) -> str:
    if frame.frame_number == 0:
        return "no frame yet"
    kind = "I-frame" if frame.is_i_frame else "P-frame"
    noun = "point" if frame.has_points else "voxel"
    return (
        f"frame {frame.frame_number:,}, {kind} of {counted(frame.voxels, noun)} in "
        f"{counted(frame.bytes, 'byte')}"
    )


class Encoder(Unique):
    """Encodes the clouds of one stream into frames.

    A cloud's points are assigned to the voxels of a grid; a voxel keeps an intensity and the
    mean colour of its points. An encoder is for one stream. Several threads may call it, one
    after the other; while it encodes, other threads run.

    Parameters
    ----------
    resolution : float
        Voxel edge, metres, 1e-6 to 1e6.
    effort : str
        Time against size: "fast", which suits live streams, "balanced", which suits
        recordings, or "small". A decoder reads all three.
    i_frame_rate : int
        Most frames from one I-frame, which decodes alone, to the next; 0 and 1: I-frames
        only.
    i_frame_every : float
        Seconds from one I-frame to the next by the stamps of the clouds, 0.001 to 86400, so
        that a seek soon shows something; `i_frame_rate` may have one earlier; 0: the count
        alone. Clouds without a stamp, or with one of 0, are counted only.
    law : str
        Intensity of a voxel. "count": the number of its points; "native": the mean of the
        intensities of its points; "quadratic" and "linear": the share of its face that they
        cover, 0 to 255, from their depth, which needs `sensor`; "none": positions alone;
        "automatic": "native" if the first cloud with points has an intensity, else "none".
    sensor : str or (float, float, int, int), optional
        Name of a sensor of `sensors()`, or horizontal and vertical field of view, degrees,
        and columns and rows of its image. Of no effect with other laws than "quadratic" and
        "linear".
    sensor_pose : array_like of shape (4, 4), optional
        Pose of the sensor in the frame of the clouds (sensor -> cloud, metres), for the
        depth of the points, which is along the sensor's z axis, for the rays on which they
        are with `keep_points`, and for `temporal_filter`.
        By default the clouds are in the sensor's own frame.
    bounding_box : ((x, y, z), (x, y, z)), optional
        Lower and upper corner, metres; points outside are left out. By default the grid
        follows the points.
    intensity_bits : int
        Bits of an intensity, 1 to 16; 0: automatic.
    intensity_range : float
        Intensity at the top of the scale: points, for "quadratic" and "linear" shares of a
        face (1: a whole one, which is decoded as 255), else as in the clouds; 0: automatic,
        without few values that are far from the others, or above 65,535 steps of 1 (or of
        another step that all are multiples of), of whose number a `CompressionWarning` tells.
    intensity_curve : str
        "linear", or "companded": small numbers exact, then steps that grow.
    aggregation : str
        "sum" or, with the law "native" only, "mean" of a voxel's points; "automatic": the
        mean with "native" in "version1".
    depth_law : (int, float, float), optional
        For native intensities that already follow the quadratic law (exponent 2) or the
        linear one (1): exponent, cut-off depth in metres, intensity of a full voxel face. A
        hint that saves bytes.
    colour_bits : int
        Bits of a colour channel, 1 to 8; 0: none. Without effect on clouds without colours.
    keep_points : bool
        Keep all points. They come back in their order, each coordinate within half the
        edge (at most 1/16 more where float32 rounds it) and with intensities and colours of their own, where that takes at most 5 %
        and 256 bytes more; those of a lidar with a field ring, channel or line may come
        row by row. Else as many points as there were are at the centre of each voxel.
    keep_order : bool
        Keep all points in their order, and rows and columns where there are several of both,
        whatever bytes that takes. With the laws "native" and "none" only.
    fields : str, sequence or dict
        Further fields of structured arrays to keep, as ring, time or label of a lidar:
        "all", a name, names and (name, step) pairs, or steps by name. With
        `keep_points` each point keeps its values, else a voxel has one: the mean, or
        of integers the most frequent. Without a step, or with None, they are kept as they
        are, NaN included; with one they are rounded to multiples of it, in the unit of the
        field, which for integers is a whole number. Fields are int8 to int32, uint8 to
        uint32, float32 or float64 in the machine's byte order, and may have several values
        for each point. Those of NaN points in an array with rows and columns come back as
        0. "all" leaves a colour out that `colour_bits` keeps. At most 64 fields
        with 4096 values a point. Not with `temporal_filter`, and "version1" only.
    coarsen_wide_clouds : bool
        For clouds wider than 2**21 voxels double the edge of a voxel as often as needed, up to
        16-fold, instead of leaving points out.
    use_coordinate_step : bool
        For clouds whose coordinates are all multiples of a larger step, as whole
        millimetres, take voxels of that edge, centred on the multiples: fewer bytes, and
        coordinates as they were. Not with the laws "quadratic" and "linear", `origin`,
        `bounding_box` or `keep_order`, and "version1" only.
    threads : int
        Most threads that turn a cloud into voxels, 1 to 256; of clouds from 65,536 points on.
    temporal_filter : int
        Number of frames, 2 to 64, over which surfaces are told from noise before they are
        encoded; 8 suits sensors of 10 to 30 Hz that stand still; 0: off. A still scene takes
        few bytes then. Lossy, and not with `keep_points`. `sensor_pose` tells it from
        where the sensor looks.
    max_rate : float
        Bits that the frames of any second may take, 1e3 to 1e12; 0: no limit. So that few
        clouds have no room, filter, bits and voxels become coarser; see `rate_control`. The
        time of a cloud is its stamp, or without one that of the call.
    rate_buffer : float
        Seconds at `max_rate` that a frame may take, and wait for the ones before it, 0.01
        to 1.
    max_encode_ms : float
        Milliseconds that encoding may take on average, 0.1 to 1e4; 0: no limit. Effort and
        then voxels follow, and `max_rate` may raise the effort.
    rate_temporal_filter : int
        Strongest `temporal_filter` that `max_rate` may choose, 2 to 64, where the sensor
        rests; 0: none.
    rate_doublings : int
        How often the voxel edge may be doubled, 0 to 8.
    rate_sent_share : float
        Share of the clouds that `max_rate` sends, leaving others out, before it doubles the
        edge, 0.1 to 1.
    origin : (float, float, float), optional
        Position from which voxels are counted, metres, 2**20 each way. None: the world's
        origin; amid the points of clouds further out; half a voxel lower where all coordinates
        are multiples of the resolution, which then are kept as they are.
    format : str
        "version1", or "published": the layout of the paper's authors.
    frame_id : str, optional
        Name of the clouds' coordinate frame, which frames then carry; "version1" only.

    Raises
    ------
    ValueError, TypeError
        If a setting is outside its range, or two contradict each other.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> encoder = pcl_ext.Encoder(resolution=0.1, effort="fast")
    >>> frame = encoder.encode(numpy.zeros((10, 3), "float32"), stamp=12.5)
    >>> encoder.statistics.voxels
    1
    """

    def __init__(
        self,
        resolution: float = 0.01,
        *,
        effort: Effort = "fast",
        i_frame_rate: int = 30,
        i_frame_every: float = 0.0,
        law: Law = "automatic",
        sensor: Optional[Sensor] = None,
        sensor_pose: Optional[ArrayLike] = None,
        bounding_box: Optional[ArrayLike] = None,
        intensity_bits: int = 0,
        intensity_range: float = 0.0,
        intensity_curve: Literal["linear", "companded"] = "linear",
        aggregation: Literal["automatic", "sum", "mean"] = "automatic",
        depth_law: Optional[Tuple[int, float, float]] = None,
        colour_bits: int = 6,
        keep_points: bool = False,
        keep_order: bool = False,
        fields: Fields = (),
        coarsen_wide_clouds: bool = False,
        use_coordinate_step: bool = False,
        threads: int = 1,
        temporal_filter: int = 0,
        max_rate: float = 0.0,
        rate_buffer: float = 0.25,
        max_encode_ms: float = 0.0,
        rate_temporal_filter: int = 8,
        rate_doublings: int = 4,
        rate_sent_share: float = 0.33,
        origin: Optional[ArrayLike] = None,
        format: Literal["version1", "published"] = "version1",
        frame_id: Optional[str] = None,
    ):
        settings = dict(locals())
        del settings["self"]
        if frame_id is not None and not isinstance(frame_id, str):
            raise TypeError(f"frame_id is {frame_id!r}; it must be a text")
        check_text("frame_id", frame_id or "")
        self._frame_id = frame_id
        self._native = _native.Encoder(settings)
        self._call = call_of(self, settings)
        self._kept = {
            field if isinstance(field, str) else field[0]
            for field in ([fields] if isinstance(fields, str) else fields)
        }
        self._codes_colours = colour_bits > 0
        self._keeps_points, self._keeps_order = keep_points, keep_order
        self._is_automatic = law == "automatic"
        self._warning = ""
        self._warned: set[str] = set()
        self._may_filter = temporal_filter > 0 or (max_rate > 0 and rate_temporal_filter > 0)
        self._frames = self._voxels_hidden = self._voxels_occupied = 0

    def __repr__(self) -> str:
        last = self.statistics
        law = "" if self.law == "automatic" else f", law {self.law!r}"
        return f"<{self._call}: {_last_frame(last)}{law}>"

    def encode(
        self,
        xyz: ArrayLike,
        intensity: Optional[ArrayLike] = None,
        colour: Optional[ArrayLike] = None,
        *,
        stamp: Optional[float] = None,
        sensor_pose: Optional[ArrayLike] = None,
        outliers: Optional[OutlierRemoval] = None,
    ) -> bytes:
        """Encodes the next cloud of the stream.

        Parameters
        ----------
        xyz : array_like
            float32 or float64 of shape (N, 3) or (rows, columns, 3), metres; or a
            structured array with fields x, y, z, and maybe intensity, rgb or rgba (as
            in PCL), or r, g, b (uint8), as `Decoder.decode` returns it, and further
            fields. Points that are not finite are left out, and so are fields that the
            encoder does not keep, with a warning. Rows and columns are kept with
            keep_points where that hardly takes more bytes.
            May be empty, read-only, of any strides: x, y, z side by side are not copied.
            float64 is not rounded, for coordinates such as those of maps. Must not be
            changed during the call.
        intensity : array_like, optional
            Numbers in the shape of the cloud, for the law "native".
        colour : array_like, optional
            uint8 in the shape of the cloud with red, green, blue (and alpha, which is
            ignored).
        stamp : float, optional
            Time of the cloud, seconds, which the frame then carries to the microsecond. 0 is
            no time, as in PCL and ROS.
        sensor_pose : array_like of shape (4, 4), optional
            The sensor's pose for this cloud, if it moves.
        outliers : OutlierRemoval, optional
            Removes noise before the voxels are encoded, which saves bytes.

        Returns
        -------
        bytes
            The frame; empty if `max_rate` has no room for it, and the cloud is left out.

        Raises
        ------
        ValueError, TypeError
            If an array has another type or shape, or a value is outside its range.
        Error
            If the cloud cannot be encoded, as one of more than 2**28 voxels, or without a
            field that is to be kept.
        MemoryError
            After which the next frame is an I-frame.

        Warns
        -----
        CompressionWarning
            If not all of the cloud is in the frame, or it was left out for `max_rate`: once for
            each kind. The message of every frame is in `warning`.
        """
        frame, code, message = self._native.encode(
            xyz,
            intensity,
            colour,
            self._header(stamp),
            sensor_pose,
            removal(outliers),
        )
        if frame is None:
            self._warning = ""
            if code == "OutOfMemory":
                raise MemoryError(message)
            raise Error(message, code)
        if not frame:
            self._warning = message
            self._warn(message)
            return frame
        loses_intensity = self._is_automatic and self.law == "none"
        left_out = _left_out(xyz, self._kept, self._codes_colours, loses_intensity)
        loses_order = self._keeps_points and outliers is not None
        order_lost = _order_lost(xyz, self._keeps_order, loses_order)
        hidden = self._hidden_by_filter() if self._may_filter else ""
        kinds = [text for text in (message, left_out, order_lost, hidden) if text]
        self._warning = "; ".join(kinds)
        for text in kinds:
            self._warn(text)
        return frame

    def request_i_frame(self) -> None:
        """Makes the next frame an I-frame, for a receiver that is new or lost a frame."""
        self._native.request_i_frame()

    def set_max_rate(self, bits_per_second: float) -> None:
        """Changes `max_rate` as the link does; only where there is one.

        Parameters
        ----------
        bits_per_second : float
            1e3 to 1e12.

        Raises
        ------
        ValueError
            If it is outside its range, or the encoder has no `max_rate`.
        """
        if self._native.rate_control()["max_rate"] == 0:
            raise ValueError("the Encoder has no max_rate, which set_max_rate changes; pass one")
        if not isinstance(bits_per_second, Real):
            raise TypeError(f"bits_per_second is {bits_per_second!r}; it must be a number")
        if not 1e3 <= bits_per_second <= 1e12:
            raise ValueError(
                f"bits_per_second is {bits_per_second!r}; it must be a number from 1e3 to 1e12"
            )
        self._native.set_max_rate(bits_per_second)

    @property
    def rate_control(self) -> RateControlStatus:
        """What the rate control chose for the last cloud, and why."""
        return RateControlStatus(**self._native.rate_control())

    @property
    def law(self) -> str:
        """The law; "automatic" until the first cloud with points decides."""
        return self._native.law()

    @property
    def statistics(self) -> FrameStatistics:
        """Figures of the last frame."""
        return FrameStatistics(**self._native.statistics()[0])

    @property
    def cloud_statistics(self) -> CloudStatistics:
        """Figures of the last cloud: points used and left out."""
        return CloudStatistics(**self._native.statistics()[1])

    @property
    def warning(self) -> str:
        """What of the last cloud is not in its frame, and which setting helps; empty if all
        is."""
        return self._warning

    def _hidden_by_filter(self) -> str:
        """That most voxels are hidden; not of the first frames, in which many are."""
        frame, cloud = self._native.statistics()
        hidden = cloud["voxels_hidden"]
        self._frames += 1
        self._voxels_hidden += hidden
        self._voxels_occupied += frame["voxels"] + hidden - cloud["voxels_held"]
        if self._frames < 30 or 2 * self._voxels_hidden <= self._voxels_occupied:
            return ""
        return (
            f"the temporal filter hid {self._voxels_hidden} of {self._voxels_occupied} voxels, "
            "as most are seen in few frames: take a larger resolution, or no temporal_filter "
            "(rate_temporal_filter=0)"
        )

    def _header(self, stamp: Optional[float]) -> Optional[Tuple[int, str]]:
        if stamp is None:
            return None if self._frame_id is None else (0, self._frame_id)
        time = microseconds("stamp", stamp, end=9.2e12)
        return (round(time), self._frame_id or "")

    def _warn(self, message: str) -> None:
        words = re.sub(r"[0-9]", "", message)
        if words in self._warned:
            return
        self._warned.add(words)
        try:
            warnings.warn(message, CompressionWarning, stacklevel=3)
        except CompressionWarning:
            # The caller has made it an error and gets no frame, on which others would depend.
            self.request_i_frame()
            raise


class VoxelChanges(NamedTuple):
    """How the voxels of a frame differ from those of the last one that was decoded."""

    #: Voxels that are there no more, or with other values, as they were.
    gone: Cloud
    #: Voxels that are new, or have other values, as they are.
    came: Cloud
    #: Whether no earlier frame was known: `came` has all voxels, and those of the receiver
    #: are to be dropped.
    is_from_nothing: bool


class Decoder(Unique):
    """Decodes the frames of one stream, in either format.

    Any bytes are safe: `decode` ends in bounded time and memory and never raises because of
    them. Frames that come again are dropped (`OldFrame`): to decode a stream from its
    beginning again, make another decoder. Several threads may call a decoder, one after the other; while it decodes, other
    threads run.

    Parameters
    ----------
    max_voxels : int
        Most voxels of a frame, or points of one that has these in order, up to 2**28; 120
        bytes of memory for each (130 of a point), and 480 for each block of 4 x 4 x 4. A frame of more than 2**23, or 2**20 blocks, needs a byte
        for 64, or 8 blocks, too.
    max_frame_bytes : int
        Most bytes of a frame, and most bytes that are skipped to find one.
    max_points : int
        Most points of a frame whose voxels have a number of points; rows * columns of one
        that has its points in order.
    max_field_values : int
        Most values of all further fields of a frame; 8 bytes of memory for each.

    Examples
    --------
    >>> import numpy, pcl_ext
    >>> decoder = pcl_ext.Decoder()
    >>> encoder = pcl_ext.Encoder(law="count")
    >>> cloud = decoder.decode(encoder.encode(numpy.zeros((10, 3))))
    >>> cloud["intensity"]
    array([10.], dtype=float32)
    >>> decoder.decode(b"something else") is None
    True
    >>> decoder.status.code
    'NoFrame'
    """

    def __init__(
        self,
        *,
        max_voxels: int = 1 << 26,
        max_frame_bytes: int = 1 << 28,
        max_points: int = 1 << 30,
        max_field_values: int = 1 << 30,
    ):
        named = limits(max_voxels, max_frame_bytes, max_points, max_field_values)
        self._native = _native.Decoder(named)
        self._call = call_of(self, named)
        self._status = Status()
        self._has_warned = False

    def __repr__(self) -> str:
        status = "" if self._status.ok else f", last call: {self._status.code}"
        return f"<{self._call}: {_last_frame(self.statistics)}{status}>"

    def decode(
        self,
        data: Buffer,
        *,
        outliers: Optional[OutlierRemoval] = None,
        min_intensity: Optional[float] = None,
        temporal_filter: Optional[TemporalVoxelFilter] = None,
    ) -> Optional[Cloud]:
        """Decodes the first frame in memory.

        It ends at ``statistics.skipped_bytes + statistics.bytes``, where the next call may
        continue. If there is no frame, the stream continues with the next one that depends
        on a decoded one, at the latest with the next I-frame.

        Parameters
        ----------
        data : bytes, bytearray, memoryview or numpy.ndarray of uint8
            Must not be changed during the call.
        outliers : OutlierRemoval, optional
            Removes noise from the frame.
        min_intensity : float, optional
            Voxels of lower intensity are removed, after the filters.
        temporal_filter : TemporalVoxelFilter, optional
            Shows likely surfaces of the last frames in place of the frame's voxels, after
            outliers were removed. Not for streams that were encoded with ``temporal_filter``.

        Returns
        -------
        Cloud or None
            One point at the centre of each voxel, or, if the frame has its points, these in
            the order of their sensor, in rows and columns if they had them, with x, y, z of
            NaN where there is no point: a structured array with x, y, z (metres, float32, or float64 in frames that reach more than 2**20 voxels from the origin),
            intensity (float32) if the stream has it, r, g, b (uint8) if it has colours, and
            the further fields that it keeps, in the dtypes and the unit that they had; those
            of several values for each point have shape (N, values). A field that is called
            intensity, r, g or b takes the place of the voxel's; one whose name is taken
            otherwise has "_" added to it. See `positions` for an array of shape (N, 3). None
            if no frame was decoded: `status` says why.

        Raises
        ------
        TypeError
            If `data` is not bytes.

        Warns
        -----
        CompressionWarning
            If a filter or `min_intensity` needs voxels of a frame that has its points, and some
            of these are outside the grid of voxels: the first time. `status` has the message of
            every frame.
        """
        cloud, code, message = self._native.decode(
            data,
            removal(outliers),
            least_intensity(min_intensity),
            native_filter(temporal_filter),
        )
        self._status = Status(code, message)
        if cloud is not None and message and not self._has_warned:
            self._has_warned = True
            warnings.warn(message, CompressionWarning, stacklevel=2)
        return None if cloud is None else Cloud(cloud)

    def decode_changes(self, data: Buffer) -> Optional[VoxelChanges]:
        """Decodes the first frame in memory to what changed, for a map or a display that
        keeps its voxels: these without `gone` and with `came` are those of the frame.

        Parameters
        ----------
        data : bytes, bytearray, memoryview or numpy.ndarray of uint8
            Must not be changed during the call.

        Returns
        -------
        VoxelChanges or None
            Clouds as `decode` returns them, with one point at the centre of each voxel and
            without further fields; a frame that has its points is turned into voxels. They
            are the changes since the last frame that was decoded, by `decode` or this. None
            if no frame was decoded: `status` says why, and the next changes are from the same
            frame as these would have been.

        Raises
        ------
        TypeError
            If `data` is not bytes.

        Examples
        --------
        >>> import numpy, pcl_ext
        >>> encoder, decoder = pcl_ext.Encoder(resolution=0.1), pcl_ext.Decoder()
        >>> changes = decoder.decode_changes(encoder.encode(numpy.zeros((1, 3))))
        >>> changes.is_from_nothing, len(changes.came)
        (True, 1)
        >>> changes = decoder.decode_changes(encoder.encode(numpy.ones((1, 3))))
        >>> len(changes.gone), len(changes.came)
        (1, 1)
        """
        changes, code, message = self._native.decode_changes(data)
        self._status = Status(code, message)
        if changes is None:
            return None
        gone, came, is_from_nothing = changes
        return VoxelChanges(Cloud(gone), Cloud(came), is_from_nothing)

    @property
    def status(self) -> Status:
        """Outcome of the last call of `decode` or `decode_changes`."""
        return self._status

    @property
    def statistics(self) -> FrameStatistics:
        """Figures of the last frame that was decoded."""
        return FrameStatistics(**self._native.statistics())

    @property
    def stamp(self) -> Optional[float]:
        """Time of the last decoded frame, seconds; None if it carries none, or 0."""
        microseconds, _ = self._native.stamp() or (0, "")
        return microseconds / MICROSECONDS if microseconds > 0 else None

    @property
    def frame_id(self) -> Optional[str]:
        """Coordinate frame of the last decoded frame; None if it carries none, or an empty
        name."""
        _, frame_id = self._native.stamp() or (0, "")
        return frame_id or None
