# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The frame header of stream version 1.

doc/bitstream.md, "Frame header" and "What a frame says".
"""

import math
import struct
import zlib
from dataclasses import dataclass, replace
from typing import Optional, Tuple

from byte_reader import ByteReader
from invalid_frame import InvalidFrame, require
from scan_header import Placement, ScanTable, read_placement, read_scan_table

MAGIC = b"PCXI"
VERSION = 1
CHECKED_FROM = 9
"""Bytes of magic, version and checksum; the checksum covers what follows them."""

_I_FRAME, _DEPTH_MODEL, _STAMP, _FRAME_ID, _ORIGIN, _CONTENT = 1, 2, 4, 8, 64, 128
_CHANGES = 64
"""In a P-frame; in an I-frame it is the origin."""
_COLOURS, _POINT_COUNTS, _NO_INTENSITIES, _FIELDS = 32, 64, 128, 256
_SCAN, _PLACEMENT, _LAYOUT, _PADDING = 512, 1024, 2048, 4096


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
class Layout:
    """Where messages have their fields."""

    fields: Tuple[Tuple[Field, int], ...]
    """With their offsets."""
    point_step: int
    row_padding: int


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
    has_scan: bool = False
    scan: Optional[ScanTable] = None
    """An I-frame's."""
    has_placement: bool = False
    """A P-frame has a placement of its scan."""
    has_layout: bool = False
    layout: Optional[Layout] = None
    """An I-frame's."""
    has_padding: bool = False
    """Of this frame alone."""

    @property
    def has_supplement(self) -> bool:
        return not self.has_scan and bool(
            self.levels or self.colour_bits or self.has_fields
        )

    @property
    def has_voxels_alone(self) -> bool:
        return not (
            self.has_scan
            or self.colour_bits
            or self.has_fields
            or self.has_point_counts
        )


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
    placement: Optional[Placement]
    """A P-frame's, if it is another one than before."""
    stamp: Optional[int]
    """The stamp in an I-frame, its change in a P-frame."""
    frame_id: Optional[bytes]
    voxel_count: int
    """Of a scan that of its points."""
    coarse_voxel_count: int
    point_count: int
    payload_size: int
    supplement_size: int
    padding_size: int


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
    require(0 < field < 8192, "the content is none")
    require(field & 31 <= 20, "the refinement has too many levels")
    require(
        is_i_frame or not field & (_NO_INTENSITIES | _LAYOUT | _PADDING),
        "the content is an I-frame's",
    )
    require(
        not field & _SCAN or (field & _POINT_COUNTS and not field & 31),
        "a scan is without numbers of points or with a refinement",
    )
    require(
        not field & _PLACEMENT or (field & _SCAN and not is_i_frame),
        "a placement is not that of a P-frame's scan",
    )
    return Content(
        field & 31,
        1 if field & _COLOURS else 0,
        bool(field & _POINT_COUNTS),
        not field & _NO_INTENSITIES,
        bool(field & _FIELDS),
        has_scan=bool(field & _SCAN),
        has_placement=bool(field & _PLACEMENT),
        has_layout=bool(field & _LAYOUT),
        has_padding=bool(field & _PADDING),
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


def _layout(reader: ByteReader) -> Layout:
    placed = []
    for _ in range(reader.varint()):
        field = _field(reader)
        require(field.step is None, "a field of a layout has a step")
        placed.append((field, reader.varint()))
    layout = Layout(tuple(placed), reader.varint(), reader.varint())
    require(1 <= layout.point_step <= 4096, "the bytes of a point are none of 1..4096")
    require(layout.row_padding <= 65536, "the padding of rows is too large")
    sizes = [len(field.name) + 6 for field, _ in placed]
    require(sum(sizes) + 6 <= 1024, "the layout is too large")
    for field, offset in placed:
        end = offset + (1, 1, 2, 2, 4, 4, 4, 8)[field.type - 1] * field.value_count
        require(end <= layout.point_step, "a field is beyond the point")
        require(field.value_count <= 4096, "a field has too many values")
    return layout


def _viewpoint(reader: ByteReader) -> Tuple[int, int, int]:
    x, y, z = (reader.svarint() for _ in range(3))
    require(max(abs(x), abs(y), abs(z)) <= 1 << 22, "the viewpoint is too far away")
    return x, y, z


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
    require(
        not content.has_scan or not flags & _DEPTH_MODEL, "a scan has a depth model"
    )
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
        if content.has_scan:
            content = replace(content, scan=read_scan_table(reader))
        if content.has_layout:
            content = replace(content, has_layout=False, layout=_layout(reader))
    placement = read_placement(reader) if content.has_placement else None
    stamp = None
    if flags & _STAMP:
        stamp = reader.numbers("Q")[0] if is_i_frame else reader.svarint()
        require(is_i_frame or stamp != -(1 << 63), "the stamp's change is -2^63")
    frame_id = None
    if flags & _FRAME_ID:
        size = reader.varint()
        require(size <= 1024, "the frame_id is too long")
        frame_id = reader.bytes(size)
    voxel_count = 0 if content.has_scan else reader.varint()
    coarse_voxel_count = reader.varint() if content.levels else 0
    require(coarse_voxel_count <= voxel_count, "there are more coarse voxels than voxels")
    require(
        not content.levels or bool(coarse_voxel_count) == bool(voxel_count),
        "voxels are in no coarse voxel",
    )
    point_count = reader.varint() if content.has_point_counts else 0
    if content.has_scan:
        voxel_count = point_count
    payload_size = reader.varint()
    supplement_size = reader.varint() if content.has_supplement else 0
    require(supplement_size <= payload_size, "the supplement is too large")
    padding_size = reader.varint() if content.has_padding else 0
    require(bool(padding_size) == content.has_padding, "there is no padding")
    content = replace(content, has_padding=False)
    require(padding_size <= payload_size - supplement_size, "the padding is too large")
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
        placement,
        stamp,
        frame_id,
        voxel_count,
        coarse_voxel_count,
        point_count,
        payload_size,
        supplement_size,
        padding_size,
    )


def require_checksum(header: FrameHeader, frame: bytes, depended_on: int) -> None:
    """Refuses a frame whose bytes, or whose frame before, are not those meant.

    `depended_on` is the checksum of the frame before, 0 for an I-frame.
    """
    start = zlib.crc32(struct.pack("<I", depended_on))
    if zlib.crc32(frame[CHECKED_FROM:], start) != header.checksum:
        raise InvalidFrame("the checksum is another one")
