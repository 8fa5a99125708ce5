# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Writing of recordings."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Dict, Optional, Union

import numpy as np

from . import _native
from ._arguments import (
    END_OF_TIME,
    Unique,
    check_recording,
    check_text,
    metadata_of,
    microseconds,
    whole_number,
)
from ._texts import counted

if TYPE_CHECKING:
    from ._arguments import Buffer


class RecordingWriter(Unique):
    """Records the encoded frames of one or several streams.

    In a ``with`` statement the recording is completed at the end. Until then the file has
    ".unfinished" added to its name, which stays after an exception. Several threads may call
    it, one after the other.

    Parameters
    ----------
    path : str or os.PathLike
        A name that ends in .pcxi: a file of one stream, its frames one after the other. In
        .mcap: MCAP, with a channel for each stream. Without an extension: a folder of rosbag2
        with such a file. "-": .pcxi on the standard output.
    overwrite : bool
        Replace a file that exists. A folder is never replaced.

    Raises
    ------
    ValueError
        If the name has another extension.
    Error
        If the file exists or cannot be written.

    Examples
    --------
    >>> import numpy, os, pcl_ext, tempfile
    >>> path = os.path.join(tempfile.mkdtemp(), "cell.mcap")
    >>> encoder = pcl_ext.Encoder()
    >>> with pcl_ext.RecordingWriter(path) as writer:
    ...     stream = writer.add_stream("/sensor_1", frame_id="world")
    ...     for number in range(3):
    ...         cloud = numpy.random.rand(1000, 3)
    ...         writer.append(stream, encoder.encode(cloud), time=10.0 + number)
    >>> recording = pcl_ext.open(path)
    >>> [frame.time for frame in recording]
    [10.0, 11.0, 12.0]
    """

    def __init__(self, path: Union[str, os.PathLike[str]], *, overwrite: bool = False):
        if not isinstance(overwrite, (bool, np.bool_)):
            raise TypeError(f"overwrite is {overwrite!r}; it must be True or False")
        self._name = os.fspath(path)
        self._native = _native.RecordingWriter()
        check_recording(*self._native.open(os.fsencode(path), overwrite))

    def __repr__(self) -> str:
        is_open, streams, frames = self._native.written()
        words = [counted(streams, "stream"), counted(frames, "frame")]
        words += [] if is_open else ["ended"]
        return f"<RecordingWriter {self._name!r}: {', '.join(words)}>"

    def __enter__(self) -> RecordingWriter:
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            self.finish()
        else:
            self._native.abandon()

    def add_stream(
        self,
        name: str,
        *,
        frame_id: str = "",
        metadata: Optional[Dict[str, str]] = None,
    ) -> int:
        """Adds a stream.

        Parameters
        ----------
        name : str
            Topic of the channel, unlike those of other streams.
        frame_id : str
            Coordinate frame of the voxels, where the frames have none.
        metadata : dict of str, optional
            Of the channel, such as a sensor's pose.

        Returns
        -------
        int
            For `append`.

        Raises
        ------
        ValueError
            If the name is empty or taken, or a .pcxi file has a stream already.
        """
        pairs = dict(metadata_of(metadata))
        for text in (name, frame_id, *pairs, *pairs.values()):
            if not isinstance(text, str):
                raise TypeError(
                    f"{text!r} is not a str, as name, frame_id, and keys and values of "
                    "metadata must be"
                )
        check_text("name", name)
        check_text("frame_id", frame_id)
        for text in (*pairs, *pairs.values()):
            check_text("a text of metadata", text)
        number, code, message = self._native.add_stream(name, frame_id, pairs)
        check_recording(code, message)
        return number

    def append(self, stream: int, data: Buffer, time: float) -> None:
        """Appends the next frame of a stream.

        Parameters
        ----------
        stream : int
            What `add_stream` returned.
        data : bytes, bytearray, memoryview or numpy.ndarray of uint8
            A frame, as `Encoder.encode` returns it. Of no bytes, as for a cloud that
            `max_rate` left out: nothing is appended.
        time : float
            Time of the cloud, seconds, which is stored to the microsecond. A .pcxi file does
            not store it; its frames may have a stamp.

        Raises
        ------
        ValueError
            If the bytes are not exactly one frame, or the time is not in range; nothing is
            written then. P-frames that need the missing one are refused, too, until the next
            I-frame; those before the first I-frame are written, and cannot be decoded.
        Error
            If the file takes no more bytes.
        """
        index = whole_number("stream", stream)
        if index < 0:
            raise ValueError(f"stream is {index}; it must be what add_stream returned")
        try:
            nanoseconds = round(microseconds("time", time, END_OF_TIME)) * 1000
        except ValueError:
            self._native.append(index, data, -1)  # is refused, and known to be missing
            raise
        check_recording(*self._native.append(index, data, nanoseconds))

    def flush(self) -> None:
        """Writes all frames at hand to the file, for a reader of the unfinished file."""
        check_recording(*self._native.flush())

    def finish(self) -> None:
        """Completes the recording and gives it its name. Does nothing if that was done."""
        check_recording(*self._native.finish())
