"""The frame header of stream version 1.

doc/bitstream.md, "Frame header" and "What a frame says".
"""

import math
import struct
import zlib
from dataclasses import dataclass, replace
from typing import Iterable, Optional, Sequence, Tuple

from invalid_frame import InvalidFrame, require

MAGIC = b"PCXI"
VERSION = 1
CHECKED_FROM = 9
"""Bytes of magic, version and checksum; the checksum covers what follows them."""

_I_FRAME, _DEPTH_MODEL, _STAMP, _FRAME_ID, _ORIGIN, _CONTENT = 1, 2, 4, 8, 64, 128
_CHANGES = 64
"""In a P-frame; in an I-frame it is the origin."""
_COLOURS, _POINT_COUNTS, _NO_INTENSITIES, _FIELDS, _IMAGE = 32, 64, 128, 256, 512
_MOST_PIXELS = 1 << 24


@dataclass(frozen=True)
class Field:
    """What is said of a field of points."""

    name: bytes
    type: int
    """1..8."""
    value_count: int
    """Values of a point."""
    step: Optional[float]
    """None: values are exact."""


@dataclass(frozen=True)
class Image:
    """Size and rays of an image."""

    width: int
    height: int
    is_spinning: bool
    has_half_steps: bool
    origin: Tuple[int, ...]
    vectors: Tuple[Tuple[int, ...], ...]
    """A, B and C, or X, Y and Z of a spinning one."""
    turns: Tuple[Tuple[int, ...], ...] = ()
    rows: Tuple[Tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class Content:
    """What frames have."""

    levels: int = 0
    colour_bits: int = 0
    """In a P-frame 1, whatever those of its I-frame are."""
    has_point_counts: bool = False
    has_intensities: bool = True
    has_fields: bool = False
    fields: Tuple[Field, ...] = ()
    """These and the viewpoint are an I-frame's."""
    viewpoint: Tuple[int, int, int] = (0, 0, 0)
    has_image: bool = False
    image: Optional[Image] = None
    """An I-frame's, too."""

    @property
    def has_supplement(self) -> bool:
        return bool(self.has_voxels or self.colour_bits or self.has_fields)

    @property
    def has_voxels(self) -> bool:
        """Whether the voxels are in the supplement."""
        return bool(self.levels or self.has_image)


@dataclass(frozen=True)
class Grid:
    """The lattice's resolution and the part of it that frames have."""

    resolution: float
    first_index: Tuple[int, int, int]
    depth: int
    origin: Tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class IntensityScale:
    """What numbers and symbols are worth; no number range on a linear scale."""

    offset: float
    step: float
    bits: int
    number_range: Optional[int]

    @property
    def highest_symbol(self) -> int:
        return (1 << self.bits) - 1


NO_INTENSITIES = IntensityScale(0.0, 1.0, 0, None)


@dataclass(frozen=True)
class FrameHeader:
    """A header as it is written; what only I-frames have is None in P-frames."""

    checksum: int
    is_i_frame: bool
    is_of_changes: bool
    has_depth_model: bool
    effort: int
    number: int
    content: Content
    grid: Optional[Grid]
    scale: Optional[IntensityScale]
    stamp: Optional[int]
    """The stamp in an I-frame, its change in a P-frame."""
    frame_id: Optional[bytes]
    voxel_count: int
    coarse_voxel_count: int
    point_count: int
    payload_size: int
    supplement_size: int


class ByteReader:
    """Numbers one after the other; refuses to read past the end."""

    def __init__(self, source: bytes, at: int = 0) -> None:
        self._source = source
        self.at = at

    def bytes(self, size: int) -> bytes:
        require(self.at + size <= len(self._source), "the frame is cut off")
        self.at += size
        return self._source[self.at - size : self.at]

    def skip_to(self, wanted: bytes) -> bool:
        """Goes on to the next place of some bytes; whether there is one."""
        place = self._source.find(wanted, self.at)
        self.at = len(self._source) if place < 0 else place
        return place >= 0

    def since(self, start: int) -> bytes:
        """What was read from a place on."""
        return self._source[start : self.at]

    def numbers(self, layout: str) -> tuple:
        """Little-endian numbers by the letters of `struct`."""
        return struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))

    def varint(self) -> int:
        """Seven bits a byte, the lowest first; 64 bits at most; no byte too many."""
        number = shift = 0
        while True:
            (byte,) = self.numbers("B")
            number |= (byte & 0x7F) << shift
            require(number < 1 << 64 and shift < 70, "a varint has more than 64 bits")
            if byte < 0x80:
                require(byte != 0 or shift == 0, "a varint ends with a byte 0")
                return number
            shift += 7


def from_zigzag(code: int) -> int:
    """0, -1, 1, -2, 2, ... of 0, 1, 2, 3, 4, ..."""
    return -((code + 1) // 2) if code % 2 else code // 2


def _grid(reader: ByteReader, has_origin: bool) -> Grid:
    resolution, x, y, z, depth = reader.numbers("d3iB")
    require(1e-6 <= resolution <= 1e6, "the resolution is none")
    require(1 <= depth <= 21, "the depth is none of 1..21")
    for first in (x, y, z):
        require(
            -(1 << 20) <= first and first + (1 << depth) <= 1 << 20,
            "the grid leaves the lattice",
        )
    if not has_origin:
        return Grid(resolution, (x, y, z), depth)
    origin = reader.numbers("3d")
    require(all(abs(o) <= 1e6 * (1 << 21) for o in origin), "the origin is none")
    require(any(origin), "the origin is the world's")
    return Grid(resolution, (x, y, z), depth, (origin[0], origin[1], origin[2]))


def _content(reader: ByteReader, is_i_frame: bool) -> Content:
    field = reader.varint()
    require(0 < field < 1024, "the content is none")
    require(field & 31 <= 20, "the refinement has too many levels")
    require(
        not field & _IMAGE or (field & _POINT_COUNTS and not field & 31),
        "an image is without numbers of points or with levels",
    )
    require(is_i_frame or not field & _NO_INTENSITIES, "the content is an I-frame's")
    return Content(
        field & 31,
        1 if field & _COLOURS else 0,
        bool(field & _POINT_COUNTS),
        not field & _NO_INTENSITIES,
        bool(field & _FIELDS),
        has_image=bool(field & _IMAGE),
    )


def _colour_bits(reader: ByteReader) -> int:
    (bits,) = reader.numbers("B")
    require(1 <= bits <= 8, "the bits of a colour are none of 1..8")
    return bits


def _scale(reader: ByteReader) -> IntensityScale:
    offset, step, bits = reader.numbers("ffB")
    require(math.isfinite(offset), "the offset is not finite")
    require(math.isfinite(step) and step > 0, "the step is none")
    number_range = None
    if bits >= 128:
        bits -= 128
        (number_range,) = reader.numbers("H")
        require(number_range >= 1 << bits, "the scale should be a linear one")
    require(1 <= bits <= 16, "the bits are none of 1..16")
    return IntensityScale(offset, step, bits, number_range)


def _field(reader: ByteReader) -> Field:
    size = reader.varint()
    require(1 <= size <= 64, "the name of a field has none of 1..64 bytes")
    name = reader.bytes(size)
    (kind,) = reader.numbers("B")
    require(1 <= kind & 127 <= 8, "the type of a field is none of 1..8")
    value_count = reader.varint()
    require(value_count > 0, "a field has no values")
    step = None
    if kind & 128:
        (step,) = reader.numbers("d")
        require(math.isfinite(step) and step > 0, "the step of a field is none")
    return Field(name, kind & 127, value_count, step)


def _fields(reader: ByteReader) -> Tuple[Field, ...]:
    count = reader.varint()
    require(1 <= count <= 64, "the fields are none of 1..64")
    fields = tuple(_field(reader) for _ in range(count))
    values = sum(field.value_count for field in fields)
    require(values <= 4096, "a point has too many values")
    return fields


def _viewpoint(reader: ByteReader) -> Tuple[int, int, int]:
    x, y, z = (from_zigzag(reader.varint()) for _ in range(3))
    require(max(abs(x), abs(y), abs(z)) <= 1 << 22, "the viewpoint is too far away")
    return x, y, z


def _svarints(reader: ByteReader, count: int) -> Tuple[int, ...]:
    return tuple(from_zigzag(reader.varint()) for _ in range(count))


def _require_within(numbers: Iterable[int], most: int) -> None:
    require(all(abs(n) <= most for n in numbers), "a number of rays is too large")


def _require_direction(cosine: int, sine: int) -> None:
    one = 1 << 30
    _require_within((cosine, sine), one)
    require(cosine**2 + sine**2 <= one * (one + 2), "a direction is too long")


def _require_plane(vectors: Sequence[Sequence[int]], width: int, height: int) -> None:
    steepest = 1 << 46
    for vector, parts in zip(vectors, (1, width, height)):
        _require_within(vector, steepest // parts)
    for a, b, c in zip(*vectors):
        for column in (0, width - 1):
            for row in (0, height - 1):
                _require_within((a + b * column + c * row,), steepest)


def _rows(reader: ByteReader, height: int) -> Tuple[Tuple[int, ...], ...]:
    rows = []
    row: Tuple[int, ...] = 7 * (0,)
    for _ in range(height):
        row = tuple(n + d for n, d in zip(row, _svarints(reader, 7)))
        _require_direction(row[0], row[1])
        _require_within(row, 1 << 30)
        rows.append(row)
    return tuple(rows)


def _image(reader: ByteReader) -> Image:
    width, height = reader.varint(), reader.varint()
    (flags,) = reader.numbers("B")
    require(1 <= width <= 65536 and 1 <= height <= 65536, "the image is none")
    require(width * height <= _MOST_PIXELS and flags < 4, "the image is none")
    origin = _svarints(reader, 3)
    _require_within(origin, 1 << 38)
    vectors = tuple(_svarints(reader, 3) for _ in range(3))
    image = Image(width, height, bool(flags & 1), bool(flags & 2), origin, vectors)
    if not image.is_spinning:
        _require_plane(vectors, width, height)
        return image
    for vector in vectors:
        _require_within(vector, 1 << 30)
    turns = tuple(_svarints(reader, 2) for _ in range((width - 1).bit_length()))
    for cosine, sine in turns:
        _require_direction(cosine, sine)
    return replace(image, turns=turns, rows=_rows(reader, height))


def read_header(reader: ByteReader) -> FrameHeader:
    """The header at the reader, which stops at the payload."""
    require(reader.bytes(len(MAGIC)) == MAGIC, "no frame begins here")
    version, checksum, flags, number = reader.numbers("BIBI")
    require(version == VERSION, f"stream version {version} is unknown")
    is_i_frame = bool(flags & _I_FRAME)
    effort = flags >> 4 & 3
    require(effort <= 2, f"effort {effort} is unknown")
    is_of_changes = not is_i_frame and bool(flags & _CHANGES)
    require(
        not is_of_changes or not flags & (_DEPTH_MODEL | _CONTENT),
        "a frame of changes has a depth model or a content",
    )
    content = _content(reader, is_i_frame) if flags & _CONTENT else Content()
    grid = scale = None
    if is_i_frame:
        grid = _grid(reader, bool(flags & _ORIGIN))
        require(content.levels < grid.depth, "cells are larger than the grid")
        if content.colour_bits:
            content = replace(content, colour_bits=_colour_bits(reader))
        scale = NO_INTENSITIES
        if content.has_intensities:
            scale = _scale(reader)
        if content.has_fields:
            fields = _fields(reader)
            content = replace(content, fields=fields, viewpoint=_viewpoint(reader))
        if content.has_image:
            content = replace(content, image=_image(reader))
    stamp = None
    if flags & _STAMP:
        stamp = reader.numbers("Q")[0] if is_i_frame else from_zigzag(reader.varint())
        require(is_i_frame or stamp != -(1 << 63), "the stamp's change is -2^63")
    frame_id = None
    if flags & _FRAME_ID:
        size = reader.varint()
        require(size <= 1024, "the frame_id is too long")
        frame_id = reader.bytes(size)
    voxel_count = reader.varint()
    coarse_voxel_count = reader.varint() if content.levels else 0
    require(coarse_voxel_count <= voxel_count, "there are more coarse voxels than voxels")
    require(
        not content.levels or bool(coarse_voxel_count) == bool(voxel_count),
        "voxels are in no coarse voxel",
    )
    point_count = reader.varint() if content.has_point_counts else 0
    payload_size = reader.varint()
    supplement_size = reader.varint() if content.has_supplement else 0
    require(supplement_size <= payload_size, "the supplement is too large")
    return FrameHeader(
        checksum,
        is_i_frame,
        is_of_changes,
        bool(flags & _DEPTH_MODEL),
        effort,
        number,
        content,
        grid,
        scale,
        stamp,
        frame_id,
        voxel_count,
        coarse_voxel_count,
        point_count,
        payload_size,
        supplement_size,
    )


def require_checksum(header: FrameHeader, frame: bytes, depended_on: int) -> None:
    """Refuses a frame whose bytes, or whose frame before, are not those meant.

    `depended_on` is the checksum of the frame before, 0 for an I-frame.
    """
    start = zlib.crc32(struct.pack("<I", depended_on))
    if zlib.crc32(frame[CHECKED_FROM:], start) != header.checksum:
        raise InvalidFrame("the checksum is another one")
