# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Frames between machines, over a NATS server (https://nats.io); see doc/site.md.

    publisher = pcl_ext.link.FramePublisher("nats://centre:4222", site="cell")
    stream = publisher.add_stream("/sensor_1")
    while True:
        if publisher.wants_i_frame(stream):
            encoder.request_i_frame()
        publisher.publish(stream, encoder.encode(next_cloud()), time.time())

    for frame in pcl_ext.link.FrameSubscriber("nats://centre:4222", site="cell"):
        cloud = decoders[frame.stream].decode(frame.data)

Needs a package that was built with libnats.
"""

from __future__ import annotations

import sys
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Union,
)

from ._arguments import END_OF_TIME, Unique, metadata_of, microseconds, whole_number
from ._texts import in_a_line, shown
from .status import Error

try:
    from . import _link  # type: ignore[attr-defined]
except ImportError as error:
    raise ImportError(
        "this pcl_ext was built without libnats, NATS's client: build it where "
        "libnats-dev is installed"
    ) from error

if TYPE_CHECKING:
    from ._arguments import Buffer

__all__ = ["FramePublisher", "FrameSubscriber", "LinkFrame", "StreamStatistics"]


class LinkFrame(NamedTuple):
    """A frame that arrived.

    Attributes
    ----------
    stream : str
        Name of its stream.
    time : float
        Of the cloud, seconds.
    data : bytes
        For `Decoder.decode`, one of which serves one stream.
    is_i_frame : bool
        It can be decoded without those before it.
    metadata : dict of str
        Of the stream; I-frames only.
    """

    stream: str
    time: float
    data: bytes
    is_i_frame: bool
    metadata: Dict[str, str]

    def __repr__(self) -> str:
        return in_a_line(self)


class StreamStatistics(NamedTuple):
    """Figures of a stream that is received, as in LinkStreamStatistics of C++."""

    stream: str
    frames: int
    bytes: int
    frames_lost: int
    frames_dropped: int
    frames_skipped: int
    frames_early: int
    frames_late: int
    frames_damaged: int
    messages_invalid: int
    i_frame_requests: int
    publishers: int
    age: Optional[float]  # seconds since its last frame; None: none came


def _check(code: str, message: str) -> None:
    if code == "OutOfMemory":
        raise MemoryError(message)
    if code in ("InvalidSettings", "InvalidArgument"):
        raise ValueError(message)
    if code != "Ok":
        raise Error(message, code)


# Of the module, all arguments are checked before: its own TypeError shows each of them,
# passwords too.
def _bytes(name: str, text: str) -> bytes:
    if not isinstance(text, str):
        raise TypeError(f"{name} is of type {type(text).__name__}; it must be a str")
    try:
        return text.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        raise ValueError(f"{name} is no text that UTF-8 has") from None


def _count(name: str, number: Any, least: int, most: int) -> int:
    count = whole_number(name, number)
    if not least <= count <= most:
        raise ValueError(f"{name} is {count}; it must be {least} to {most}")
    return count


def _timeout(seconds: Any, least: float, most: float) -> float:
    try:
        is_valid = least <= seconds <= most  # not of NaN
    except TypeError:
        raise TypeError(f"timeout is {seconds!r}; it must be a number of seconds") from None
    if not is_valid:
        raise ValueError(f"timeout is {seconds!r}; it must be {least:g} to {most:g} seconds")
    return float(seconds)


def _connect_timeout(seconds: Any) -> float:
    return _timeout(seconds, 0.001, 3600.0)


def _wait(seconds: Any) -> float:
    return _timeout(seconds, 0.0, 1e9)  # whose nanoseconds have 63 bits


def _settings(*values: str) -> Dict[str, bytes]:
    names = "servers site user password token credentials_file ca_file certificate_file key_file"
    settings = {name: _bytes(name, value) for name, value in zip(names.split(), values)}
    return {"client_name": b"pcl_ext for Python", **settings}


def _names(streams: Any) -> List[bytes]:
    if isinstance(streams, str):
        return [_bytes("streams", streams)]
    if isinstance(streams, bytes) or not isinstance(streams, Iterable):
        raise TypeError(f"streams is {shown(streams)}; it must be a str or several of them")
    return [_bytes("streams", name) for name in streams]


class FramePublisher(Unique):
    """Publishes the frames of streams for whoever receives them.

    Frames that cannot be sent are lost: receivers request an I-frame then. A lost connection
    is restored for ever. Several threads may use it.

    Parameters
    ----------
    servers : str
        Addresses with commas between them: nats://HOST:PORT, or tls://HOST:PORT encrypted.
    site : str
        Up to 64 letters, digits, - and _.
    user, password, token : str
        Who this is, as the server demands.
    credentials : str
        File with JWT and seed, as nsc writes it.
    ca, certificate, key : str
        PEM files: certificates to trust, and those of this client.
    timeout : float
        Seconds in which a server must answer, 0.001 to 3600.

    Raises
    ------
    Error
        If no server takes the connection.
    """

    def __init__(
        self,
        servers: str = "nats://127.0.0.1:4222",
        *,
        site: str = "site",
        user: str = "",
        password: str = "",
        token: str = "",
        credentials: str = "",
        ca: str = "",
        certificate: str = "",
        key: str = "",
        timeout: float = 2.0,
    ):
        self._native = _link.Publisher(
            _settings(servers, site, user, password, token, credentials, ca, certificate, key),
            _connect_timeout(timeout),
        )
        self._streams: Set[int] = set()
        _check(*self._native.connect())

    def add_stream(self, name: str, metadata: Optional[Dict[str, str]] = None) -> int:
        """Adds a stream.

        Parameters
        ----------
        name : str
            Such as a topic, up to 1000 bytes.
        metadata : dict of str, optional
            Sent with each I-frame, such as a sensor's pose.

        Returns
        -------
        int
            For `publish`.
        """
        pairs = {
            _bytes("metadata", key): _bytes("metadata", value)
            for key, value in metadata_of(metadata).items()
        }
        number, code, message = self._native.add_stream(_bytes("name", name), pairs)
        _check(code, message)
        self._streams.add(number)
        return number

    def _index(self, stream: Any) -> int:
        index = whole_number("stream", stream)
        if index not in self._streams:
            raise ValueError(f"stream is {index}; it must be what add_stream returned")
        return index

    def publish(self, stream: int, data: Buffer, time: float) -> bool:
        """Sends the next frame of a stream.

        Parameters
        ----------
        stream : int
            What `add_stream` returned.
        data : bytes, bytearray, memoryview or numpy.ndarray of uint8
            A frame, as `Encoder.encode` returns it. Of no bytes, as for a cloud that
            `max_rate` left out: nothing is sent.
        time : float
            Of the cloud, seconds.

        Returns
        -------
        bool
            False if the connection is lost for the moment, and so is the frame.

        Raises
        ------
        Error
            If the frame is above the server's max_payload.
        """
        nanoseconds = round(microseconds("time", time, END_OF_TIME)) * 1000
        code, message = self._native.publish(self._index(stream), data, nanoseconds)
        if code == "NotConnected":
            return False
        _check(code, message)
        return True

    def wants_i_frame(self, stream: int) -> bool:
        """True once after a receiver has requested an I-frame of a stream.

        To be asked before each frame: it is never true for two frames in a row.

        Parameters
        ----------
        stream : int
            What `add_stream` returned.
        """
        return self._native.wants_i_frame(self._index(stream))

    def flush(self, timeout: float = 2.0) -> bool:
        """Waits until the server has all frames.

        Parameters
        ----------
        timeout : float
            Seconds.

        Returns
        -------
        bool
            False if it has not in that time.
        """
        return self._native.flush(_wait(timeout))

    @property
    def statistics(self) -> Dict[str, int]:
        """Frames and bytes that the server has, frames_under_way, frames_not_sent,
        frames_unanswered, i_frame_requests, reconnections, is_connected."""
        return self._native.statistics()


class FrameSubscriber(Unique):
    """Receives the frames of a site's streams; iterates over them for ever.

    Each stream begins with an I-frame and has no gap within what can be decoded: after a lost
    frame the next one is an I-frame, which is requested.

    Parameters
    ----------
    servers, site, user, password, token, credentials, ca, certificate, key, timeout
        As of `FramePublisher`.
    streams : str or sequence of str
        Name or names of those to receive; empty: all of the site.
    partition : int, optional
        The part of the streams to receive, where the server divides them.
    replay_from : float, optional
        What the server keeps since this time, seconds since 1970, in place of what comes; the
        iteration ends after it.
    max_waiting_bytes : int
        Frames that wait; further ones are dropped.

    Raises
    ------
    Error
        If no server takes the connection.
    """

    def __init__(
        self,
        servers: str = "nats://127.0.0.1:4222",
        *,
        site: str = "site",
        user: str = "",
        password: str = "",
        token: str = "",
        credentials: str = "",
        ca: str = "",
        certificate: str = "",
        key: str = "",
        timeout: float = 2.0,
        streams: Union[str, Sequence[str]] = (),
        partition: Optional[int] = None,
        replay_from: Optional[float] = None,
        max_waiting_bytes: int = 1 << 26,
    ):
        start = (
            None
            if replay_from is None
            else round(microseconds("replay_from", replay_from, END_OF_TIME)) * 1000
        )
        self._native = _link.Subscriber(
            _settings(servers, site, user, password, token, credentials, ca, certificate, key),
            _connect_timeout(timeout),
            _names(streams),
            None if partition is None else _count("partition", partition, 0, 2**32 - 1),
            start,
            _count("max_waiting_bytes", max_waiting_bytes, 1, sys.maxsize),
        )
        _check(*self._native.connect())

    def next(self, timeout: float) -> Union[LinkFrame, None]:
        """The next frame.

        Parameters
        ----------
        timeout : float
            Seconds to wait for it.

        Returns
        -------
        LinkFrame or None
            None if none came in time.

        Raises
        ------
        Error
            "EndOfReplay" after the last frame that the server keeps; "Closed" if the
            connection is lost for good.
        """
        frame, code, message = self._native.next(_wait(timeout))
        if code == "NoFrame":
            return None
        _check(code, message)
        stream, nanoseconds, data, is_i_frame, metadata = frame
        return LinkFrame(stream, nanoseconds / 1e9, data, is_i_frame, metadata)

    def __iter__(self) -> Iterator[LinkFrame]:
        while True:
            try:
                frame = self.next(0.1)  # so that Ctrl-C is seen
            except Error as error:
                if error.code == "EndOfReplay":
                    return
                raise
            if frame is not None:
                yield frame

    def request_i_frame(self, stream: str) -> None:
        """Requests an I-frame, as a decoder that fails needs it.

        Parameters
        ----------
        stream : str
            Name of the stream.
        """
        self._native.request_i_frame(_bytes("stream", stream))

    @property
    def statistics(self) -> Dict[str, StreamStatistics]:
        """Figures of the streams, by name."""
        return {row[0]: StreamStatistics(*row) for row in self._native.statistics()}
