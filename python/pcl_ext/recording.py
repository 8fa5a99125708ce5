# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Recordings: files of one or several streams."""

from __future__ import annotations

import errno
import heapq
import math
import os
import warnings
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple, Union

from . import _native
from ._arguments import (
    END_OF_TIME,
    Unique,
    check_recording,
    least_intensity,
    limits,
    microseconds,
    whole_number,
)
from ._progress import Progress, reporting
from ._texts import counted, in_a_line
from .cloud import Cloud
from .codec import CompressionWarning
from .frames import FrameField
from .outliers import OutlierRemoval, removal
from .status import Error, Status

_NANOSECONDS = 1e9


class RecordedStream(NamedTuple):
    """A stream of a recording."""

    name: str  #: topic of the channel; .pcxi: name of the file
    frames: int  #: number of frames
    has_times: bool  #: False: all times are 0
    first_time: float  #: of the frames, seconds
    last_time: float  #: of the frames, seconds
    metadata: Dict[str, str]  #: of the channel


class RecordedFrame(NamedTuple):
    """An encoded frame of a recording; `Recording.frame` decodes it."""

    stream: int  #: index in `Recording.streams`
    number: int  #: of the frame in its stream, from 0
    time: float  #: at which it was recorded, seconds
    stamp: Optional[float]  #: time of the cloud, seconds; None if unknown
    frame_id: str  #: coordinate frame of the voxels; empty if unknown
    offset: int  #: byte of the file at which the frame or its chunk begins
    is_i_frame: bool  #: decodes without any other frame
    data: bytes  #: what the encoder returned
    fields: Tuple[FrameField, ...] = ()  #: of an I-frame: further fields of its points

    def __repr__(self) -> str:
        return in_a_line(self)


class Damage(NamedTuple):
    """A place of a recording that could not be read."""

    offset: int  #: byte of the file at which it begins
    message: str  #: what is wrong there and what is lost
    file: str  #: path of the file


class RecordingWarning(UserWarning):
    """Clouds of a recording are missing or may be, as it is damaged or has no orderly end."""


class Recording(Unique):
    """A recording that is read, as `open` returns it.

    To iterate over it gives a `RecordedFrame` at a time, of all streams in the order of
    their times, from where the last iteration ended or `seek` went. Frames that cannot be
    read are left out; see `damage`. Close it with `close`, or use it in a ``with``
    statement. Several threads may call it, one after the other.

    Parameters
    ----------
    path : str or os.PathLike
        A .pcxi or MCAP file, a rosbag2 folder, or "-" for the standard input.
    max_voxels, max_frame_bytes, max_points, max_field_values : int, optional
        Limits of decoding, see `Decoder`, which has the same defaults but for
        `max_voxels`: 2**28 here, as the memory of all streams has a limit.
    """

    def __init__(
        self,
        path: Union[str, os.PathLike[str]],
        *,
        max_voxels: Optional[int] = None,
        max_frame_bytes: Optional[int] = None,
        max_points: Optional[int] = None,
        max_field_values: Optional[int] = None,
    ):
        name = os.fspath(path)
        if name != "-" and not os.path.exists(name):
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)
        self._native = _native.Recording()
        check_recording(
            *self._native.open(
                os.fsencode(name),
                limits(max_voxels, max_frame_bytes, max_points, max_field_values),
            )
        )
        self._streams = [
            RecordedStream(
                name,
                frames,
                has_times,
                first / _NANOSECONDS,
                last / _NANOSECONDS,
                metadata,
            )
            for name, frames, has_times, first, last, metadata in self._native.streams()
        ]
        self._status = Status()
        self._has_warned = False
        self._name = name
        self._is_closed = False

    def __repr__(self) -> str:
        if self._is_closed:
            return f"<Recording {self._name!r}: closed>"
        timed = [stream for stream in self._streams if stream.has_times and stream.frames]
        words = [
            counted(len(self._streams), "stream"),
            counted(sum(stream.frames for stream in self._streams), "frame"),
            counted(self.file_bytes, "byte"),
        ]
        if timed:
            first = min(stream.first_time for stream in timed)
            last = max(stream.last_time for stream in timed)
            words.insert(2, f"{last - first:.3f} s")
        words += ["no orderly end"] if self.is_unfinished else []
        words += [counted(len(self.damage), "damaged place")] if self.damage else []
        return f"<Recording {self._name!r}: {', '.join(words)}>"

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[RecordedFrame]:
        return self

    def __next__(self) -> RecordedFrame:
        while True:
            frame, code, message = self._native.next()
            if frame is not None:
                return _frame(frame)
            if code == "EndOfRecording":
                raise StopIteration
            if code != "Damaged":
                check_recording(code, message)

    @property
    def streams(self) -> List[RecordedStream]:
        """The streams of the recording."""
        return list(self._streams)

    def seek(self, time: float) -> None:
        """Continues the iteration with the first frame of a time or later.

        Parameters
        ----------
        time : float
            Seconds, on the clock of `RecordedStream.first_time`; compared to the
            microsecond. 0 is the beginning.
        """
        self._native.seek(_not_later("time", time))

    def clouds(
        self,
        streams: Union[None, int, str, Iterable[Union[int, str]]] = None,
        *,
        start: Optional[float] = None,
        end: Optional[float] = None,
        progress: Progress = False,
    ) -> Iterator[Tuple[float, str, Cloud]]:
        """Decodes the clouds of streams in the order of their times, those of the same time
        in the order of `streams` of the recording::

            for time, stream, cloud in pcl_ext.open("cell.mcap").clouds():
                print(time, stream, cloud.to_pandas().describe())

        Neither `seek` nor an iteration over the recording has to do with it. Frames that
        cannot be read or decoded are left out, with a `RecordingWarning` for the first one of
        each stream, and at the end for their number where it is above 1. There is one before
        for the first `damage` that is known, or if the recording `is_unfinished`, so that clouds
        may be missing.

        Parameters
        ----------
        streams : int, str or several of them, optional
            Indices or names of streams in `streams`. Else all.
        start, end : float, optional
            Times as those of `RecordedStream.first_time`, seconds: from start on, and before
            end, which may be math.inf; compared to the microsecond.
        progress : bool or callable
            A function of two numbers, the frames until then and all of these streams and
            times, which is called before each frame is decoded, and at the end; True: a bar
            of tqdm, which must be installed.

        Returns
        -------
        iterator of (float, str, Cloud)
            Time of recording, seconds, as of `time_of`; name of the stream; the cloud, as of
            `frame`.

        Raises
        ------
        IndexError, KeyError
            If there is no such stream.
        ValueError
            If start or end is given, and a stream has no times.
        """
        if end == math.inf:
            end = None
        if streams is None:
            streams = range(len(self._streams))
        elif isinstance(streams, (str, bytes)) or not isinstance(streams, Iterable):
            streams = [streams]  # type: ignore[list-item]
        indices = sorted({self._index(stream) for stream in streams})
        for index in indices:
            if not (start is None and end is None or self._streams[index].has_times):
                raise ValueError(f"{self._streams[index].name} has no times for start and end")
        return self._clouds(
            indices,
            0 if start is None else _not_later("start", start),
            math.inf if end is None else _not_later("end", end),
            progress,
        )

    def read(self, stream: Union[int, str], number: int) -> RecordedFrame:
        """Reads a frame without decoding it.

        Parameters
        ----------
        stream : int or str
            Index or name of a stream in `streams`.
        number : int
            Number of the frame in its stream, from 0.

        Returns
        -------
        RecordedFrame
            Its `data` are the bytes of the encoder.

        Raises
        ------
        IndexError, KeyError
            If there is no such frame or stream.
        Error
            If the file is damaged there.
        """
        index = self._index(stream)
        frame, code, message = self._native.read(index, self._number(index, number))
        if frame is None:
            raise Error(message, code)
        return _frame(frame)

    def frame(
        self,
        stream: Union[int, str],
        number: int,
        *,
        outliers: Optional[OutlierRemoval] = None,
        min_intensity: Optional[float] = None,
    ) -> Optional[Cloud]:
        """Decodes a frame. In order this takes no longer than `Decoder.decode`; any other
        frame is decoded from the I-frame before it on.

        Parameters
        ----------
        stream : int or str
            Index or name of a stream in `streams`.
        number : int
            Number of the frame in its stream, from 0.
        outliers : OutlierRemoval, optional
            Removes noise; for the frames of one stream, in order. Its unit "automatic" is
            that of the intensity_law in the metadata of the stream, where it is known.
        min_intensity : float, optional
            Voxels of lower intensity are removed, after the outliers.

        Returns
        -------
        Cloud or None
            As `Decoder.decode`. None if the frame cannot be decoded: `status` says why.

        Raises
        ------
        IndexError, KeyError
            If there is no such frame or stream.
        ValueError
            If the unit of `outliers` cannot judge intensities of the stream's intensity_law.

        Warns
        -----
        CompressionWarning
            As `Decoder.decode`, the first time of a recording.
        """
        index = self._index(stream)
        filtering = removal(outliers)
        if filtering is not None:
            known = self._streams[index].metadata
            law = known.get("intensity_law", "")
            filtering.set_stream(law, known.get("sensor") == "lidar")
        cloud, code, message = self._native.decode(
            index,
            self._number(index, number),
            filtering,
            least_intensity(min_intensity),
        )
        self._status = Status(code, message)
        if cloud is not None and message and not self._has_warned:
            self._has_warned = True
            warnings.warn(message, CompressionWarning, stacklevel=2)
        return None if cloud is None else Cloud(cloud)

    def frame_at(self, stream: Union[int, str], time: float) -> Optional[int]:
        """Number of the last frame of a stream that is not later than a time.

        Parameters
        ----------
        stream : int or str
            Index or name of a stream in `streams`.
        time : float
            Seconds; compared to the microsecond.

        Returns
        -------
        int or None
            None if all frames are later.
        """
        later = math.ceil(microseconds("time", time, END_OF_TIME) + 0.5)
        return self._native.frame_at(self._index(stream), later * 1000)

    def time_of(self, stream: Union[int, str], number: int) -> float:
        """Time of a frame, seconds, without reading it: what orders frames, so that within a
        stream it never falls. Where the clock was set back it is that of the frame before.

        Parameters
        ----------
        stream : int or str
            Index or name of a stream in `streams`.
        number : int
            Number of the frame in its stream, from 0.
        """
        index = self._index(stream)
        return self._native.time_of(index, self._number(index, number)) / _NANOSECONDS

    def close(self) -> None:
        """Closes the file."""
        self._native.close()
        self._is_closed = True

    @property
    def status(self) -> Status:
        """Outcome of the last call of `frame`."""
        return self._status

    @property
    def damage(self) -> List[Damage]:
        """What could not be read until now."""
        return [Damage(*place) for place in self._native.damage()]

    @property
    def is_unfinished(self) -> bool:
        """True if the recording has no orderly end, as after a power failure."""
        return self._native.is_unfinished()

    @property
    def file_bytes(self) -> int:
        """Bytes of the file or files."""
        return self._native.file_bytes()

    def _clouds(
        self, streams: List[int], start: int, end: float, progress: Progress
    ) -> Iterator[Tuple[float, str, Cloud]]:
        for place in self.damage[:1]:
            _warn(f"{place.file}: {place.message}")
        if self.is_unfinished and not self.damage:
            _warn("the recording has no orderly end: its last clouds may be missing")
        lost = dict.fromkeys(streams, 0)
        for time, stream, number in self._reported(streams, start, end, progress):
            seconds, name = time / _NANOSECONDS, self._streams[stream].name
            cloud, _, message = self._native.decode(stream, number, None, None)
            if cloud is not None:
                yield seconds, name, Cloud(cloud)
                continue
            lost[stream] += 1
            if lost[stream] == 1:
                _warn(f"frame {number} of {name} at {seconds:.6f} s is left out: {message}")
        for stream, count in lost.items():
            if count > 1:
                _warn(f"{count} frames of {self._streams[stream].name} were left out")

    def _reported(
        self, streams: List[int], start: int, end: float, progress: Progress
    ) -> Iterator[Tuple[int, int, int]]:
        """The places of streams by time; tells how many of them were given."""

        def places() -> Iterator[Tuple[int, int, int]]:
            for place in heapq.merge(*map(self._places, streams)):
                if place[0] >= end:
                    return
                if place[0] >= start:
                    yield place

        with reporting(progress) as report:
            total = sum(1 for _ in places()) if report else 0
            for done, place in enumerate(places()):
                if report:
                    report(done, total)
                yield place
            if report:
                report(total, total)

    def _places(self, stream: int) -> Iterator[Tuple[int, int, int]]:
        """Time, nanoseconds, stream and number of its frames."""
        for number in range(self._streams[stream].frames):
            yield self._native.time_of(stream, number), stream, number

    def _index(self, stream: Union[int, str]) -> int:
        if isinstance(stream, str):
            names = [known.name for known in self._streams]
            if stream not in names:
                raise KeyError(f"there is no stream '{stream}', but {', '.join(names)}")
            stream = names.index(stream)
        stream = whole_number("stream", stream)
        if not 0 <= stream < len(self._streams):
            raise IndexError(f"stream is {stream}; there are {len(self._streams)}")
        return stream

    def _number(self, stream: int, number: int) -> int:
        frames = self._streams[stream].frames
        number = whole_number("number", number)
        if not 0 <= number < frames:
            raise IndexError(f"number is {number}; the stream has {frames} frames")
        return number


def open(
    path: Union[str, os.PathLike[str]],
    *,
    max_voxels: Optional[int] = None,
    max_frame_bytes: Optional[int] = None,
    max_points: Optional[int] = None,
    max_field_values: Optional[int] = None,
) -> Recording:
    """Opens a recording, which is found by its content: a .pcxi file, an MCAP file, or a
    rosbag2 folder with messages of type point_cloud_interfaces/msg/CompressedPointCloud2.

    Files that were cut off or damaged are read as far as possible.

    Parameters
    ----------
    path : str or os.PathLike
        A file, a folder, or "-" for the standard input.
    max_voxels, max_frame_bytes, max_points, max_field_values : int, optional
        Limits of decoding, see `Decoder`, which has the same defaults but for
        `max_voxels`: 2**28 here, as the memory of all streams has a limit.

    Returns
    -------
    Recording
        To be iterated over.

    Raises
    ------
    FileNotFoundError
        If there is nothing of this name.
    Error
        If it cannot be read, or is no recording.
    """
    return Recording(
        path,
        max_voxels=max_voxels,
        max_frame_bytes=max_frame_bytes,
        max_points=max_points,
        max_field_values=max_field_values,
    )


def _not_later(name: str, time: float) -> int:
    """Nanoseconds of a time of frames, or less than a microsecond before: a float of seconds
    may be above the time that it was made of."""
    return max(0, math.floor(microseconds(name, time, END_OF_TIME) - 0.5)) * 1000


def _warn(message: str) -> None:
    # Of the loop, below which are _clouds and this function.
    warnings.warn(message, RecordingWarning, stacklevel=3)


def _frame(values: Any) -> RecordedFrame:
    stream, number, time, stamp, frame_id, offset, is_i_frame, data, fields = values
    return RecordedFrame(
        stream,
        number,
        time / _NANOSECONDS,
        stamp / _NANOSECONDS if stamp != 0 else None,
        frame_id,
        offset,
        is_i_frame,
        data,
        tuple(FrameField(*field) for field in fields),
    )
