# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What a frame header says of a scan: its size, the order of its points, and its rays.

doc/bitstream.md, the tables of the scan and of the placement in "Frame header".
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import List, Tuple

from byte_reader import ByteReader
from invalid_frame import require

ORGANISED, ROW_BY_ROW, COLUMN_BY_COLUMN = 0, 1, 2
"""Orders of the points of a cloud."""
PLANAR, SPINNING, FREE = 0, 1, 2
"""Shapes of the rays."""
_ORDER, _SHAPE_UNIT, _LATTICE, _SHIFTS, _HALF_DEPTHS = 3, 4, 16, 32, 64
_LONGEST_SIDE = 1 << 16
_MOST_PIXELS = 1 << 24
_UNIT = 1 << 30
_HIGHEST_OF_PLANE = 1 << 45
_MOST_STEP = 1 << 29
"""Run and rise of a row."""
_FARTHEST = 1 << 42
_MOST_SPIN = 1 << 45
_MOST_TURNS = 31

Vector = Tuple[int, int, int]
Direction = Tuple[int, int]
"""Cosine and sine."""


@dataclass(frozen=True)
class Row:
    """A row of a spinning sensor."""

    direction: Direction
    run: int
    rise: int
    along: int
    across: int
    up: int


@dataclass(frozen=True)
class Pose:
    """Where rays are, or how that changes from a column to the next."""

    origin: Vector
    vectors: Tuple[Vector, Vector, Vector]
    """Planar: A, B and C; spinning: X, Y and Z; free: 0."""


_NO_VECTORS = (0, 0, 0), (0, 0, 0), (0, 0, 0)
NO_MOTION = Pose((0, 0, 0), _NO_VECTORS)


@dataclass(frozen=True)
class Placement:
    """What P-frames may change."""

    width: int
    height: int
    pose: Pose
    motion: Pose = NO_MOTION


@dataclass(frozen=True)
class ScanTable:
    """Size, order and rays of a scan."""

    placement: Placement
    order: int
    shape: int
    is_on_lattice: bool
    has_half_depths: bool = False
    firing_order: Tuple[int, ...] = ()
    shifts: Tuple[int, ...] = ()
    """Of rows, in columns; empty without."""
    turns: Tuple[Direction, ...] = ()
    rows: Tuple[Row, ...] = ()

    @property
    def width(self) -> int:
        return self.placement.width

    @property
    def height(self) -> int:
        return self.placement.height

    @property
    def is_spinning(self) -> bool:
        return self.shape == SPINNING

    @property
    def is_free(self) -> bool:
        return self.shape == FREE

    @property
    def is_sequence(self) -> bool:
        """A free scan whose points are in the first pixels."""
        return self.is_free and self.order == ROW_BY_ROW

    @property
    def ray_columns(self) -> int:
        return self.width - max(self.shifts, default=0)

    @property
    def pixel_count(self) -> int:
        return self.width * self.height

    def placed(self, placement: Placement) -> "ScanTable":
        """The table of a P-frame with a placement of its own."""
        table = replace(self, placement=placement)
        require(
            self.is_sequence or self.height == table.height,
            "a scan that is no sequence has another height",
        )
        require(
            self.is_sequence or self.is_spinning or self.width == table.width,
            "a scan that is neither a sequence nor spinning has another width",
        )
        _require_size(table)
        _require_rays(table)
        return table


def _require_size(table: ScanTable) -> None:
    longest = _MOST_PIXELS if table.is_sequence else _LONGEST_SIDE
    require(1 <= min(table.width, table.height), "the scan has no pixels")
    require(max(table.width, table.height) <= longest, "the scan is too wide or too high")
    require(table.pixel_count <= _MOST_PIXELS, "the scan has too many pixels")
    require(table.ray_columns >= 1, "a row is moved out of the scan")


def _require_length(vector: Vector, highest: int) -> None:
    require(max(map(abs, vector)) <= highest, "a vector of the scan is too long")


def _require_plane(placement: Placement) -> None:
    a, b, c = placement.pose.vectors
    width, height = placement.width, placement.height
    _require_length(a, _HIGHEST_OF_PLANE)
    _require_length(b, _HIGHEST_OF_PLANE // width)
    _require_length(c, _HIGHEST_OF_PLANE // height)
    for column, row in product((0, width - 1), (0, height - 1)):
        for i in range(3):
            corner = a[i] + b[i] * column + c[i] * row
            require(abs(corner) <= _HIGHEST_OF_PLANE, "a corner of the plane is too far")


def _require_rays(table: ScanTable) -> None:
    """Pose and motion are within their ranges."""
    placement = table.placement
    _require_length(placement.pose.origin, _FARTHEST)
    if not table.is_spinning:
        require(placement.motion == NO_MOTION, "a scan that is not spinning has a motion")
    if table.shape == PLANAR:
        _require_plane(placement)
    if table.is_free:
        require(placement.pose.vectors == _NO_VECTORS, "a free scan has vectors")
    if not table.is_spinning:
        return
    for axis in placement.pose.vectors:
        _require_length(axis, _UNIT)
    _require_length(placement.motion.origin, _FARTHEST)
    for axis in placement.motion.vectors:
        _require_length(axis, _MOST_SPIN // placement.width)


def _vector(reader: ByteReader) -> Vector:
    return reader.svarint(), reader.svarint(), reader.svarint()


def _pose(reader: ByteReader) -> Pose:
    origin = _vector(reader)
    return Pose(origin, (_vector(reader), _vector(reader), _vector(reader)))


def _motion(reader: ByteReader) -> Pose:
    (has_motion,) = reader.numbers("B")
    require(has_motion <= 1, "the byte before a motion is neither 0 nor 1")
    return _pose(reader) if has_motion else NO_MOTION


def _require_direction(cosine: int, sine: int) -> None:
    require(max(abs(cosine), abs(sine)) <= _UNIT, "a cosine or sine is out of its range")
    require(cosine**2 + sine**2 <= _UNIT * (_UNIT + 2), "a direction is too long")


def _turns(reader: ByteReader) -> Tuple[Direction, ...]:
    (count,) = reader.numbers("B")
    require(1 <= count <= _MOST_TURNS, "the turns are none of 1..31")
    turns: List[Direction] = []
    for _ in range(count):
        cosine, sine = reader.svarint(), reader.svarint()
        _require_direction(cosine, sine)
        turns.append((cosine, sine))
    return tuple(turns)


def _rows(reader: ByteReader, height: int) -> Tuple[Row, ...]:
    rows: List[Row] = []
    numbers = 7 * [0]
    for _ in range(height):
        numbers = [number + reader.svarint() for number in numbers]
        cosine, sine, run, rise, *others = numbers
        _require_direction(cosine, sine)
        require(run**2 + rise**2 <= _MOST_STEP**2, "a step of depth is too long")
        require(max(map(abs, others)) <= _UNIT, "a number of a row is out of its range")
        rows.append(Row((cosine, sine), run, rise, *others))
    return tuple(rows)


def _firing_order(reader: ByteReader, height: int) -> Tuple[int, ...]:
    rows = tuple(reader.varint() for _ in range(height))
    require(sorted(rows) == list(range(height)), "the firing order lacks a row")
    return rows


def _shifts(reader: ByteReader, height: int) -> Tuple[int, ...]:
    return tuple(reader.varint() for _ in range(height))


def read_scan_table(reader: ByteReader) -> ScanTable:
    width, height = reader.varint(), reader.varint()
    (flags,) = reader.numbers("B")
    require(flags < 2 * _HALF_DEPTHS, "the flags of the scan are none")
    order = flags & _ORDER
    require(order <= COLUMN_BY_COLUMN, "the order of the points is unknown")
    shape = flags % _LATTICE // _SHAPE_UNIT
    require(shape <= FREE, "the shape of the rays is unknown")
    require(
        shape != FREE or order != COLUMN_BY_COLUMN, "a free scan is column by column"
    )
    # Before the firing order and rows, whose numbers the height tells.
    is_sequence = shape == FREE and order == ROW_BY_ROW
    require(is_sequence or height <= _LONGEST_SIDE, "the scan is too high")
    is_spinning = shape == SPINNING
    has_half_depths = bool(flags & _HALF_DEPTHS)
    require(not has_half_depths or shape == PLANAR, "half depths of no camera")
    firing_order = _firing_order(reader, height) if order == COLUMN_BY_COLUMN else ()
    has_shifts = bool(flags & _SHIFTS)
    require(not has_shifts or bool(firing_order), "rows of another order are moved")
    shifts = _shifts(reader, height) if has_shifts else ()
    pose = _pose(reader)
    motion = _motion(reader) if is_spinning else NO_MOTION
    table = ScanTable(
        Placement(width, height, pose, motion),
        order,
        shape,
        bool(flags & _LATTICE),
        has_half_depths,
        firing_order,
        shifts,
        _turns(reader) if is_spinning else (),
        _rows(reader, height) if is_spinning else (),
    )
    _require_size(table)
    _require_rays(table)
    return table


def read_placement(reader: ByteReader) -> Placement:
    """The placement of a P-frame; ScanTable.placed checks it."""
    return Placement(
        reader.varint(), reader.varint(), _pose(reader), _motion(reader)
    )
