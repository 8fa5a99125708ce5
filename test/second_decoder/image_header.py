# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The image of a frame header: its size, and what its rays are made of.

doc/bitstream.md, the table of the image in "Frame header".
"""

from dataclasses import dataclass
from itertools import product
from typing import List, Tuple

from byte_reader import ByteReader
from invalid_frame import require

_SPINNING, _HALF_STEPS, _UNORGANISED, _AT_SENSOR = 1, 2, 4, 8
_LONGEST_SIDE = 1 << 16
_MOST_PIXELS = 1 << 24
_UNIT = 1 << 30
_HIGHEST_OF_PLANE = 1 << 46

Vector = Tuple[int, int, int]
Direction = Tuple[int, int]
"""Cosine and sine."""


@dataclass(frozen=True)
class Row:
    """A row of a spinning image."""

    direction: Direction
    run: int
    rise: int
    along: int
    across: int
    up: int


@dataclass(frozen=True)
class Pose:
    """Where the rays of an image are."""

    origin: Vector
    vectors: Tuple[Vector, Vector, Vector]
    """Planar: A, B and C; spinning: X, Y and Z."""


@dataclass(frozen=True)
class Image:
    """Size and rays of an image."""

    width: int
    height: int
    is_spinning: bool
    has_half_steps: bool
    is_organised: bool
    has_points_at_sensor: bool
    pose: Pose
    turns: Tuple[Direction, ...] = ()
    rows: Tuple[Row, ...] = ()

    @property
    def pixel_count(self) -> int:
        return self.width * self.height


def _vector(reader: ByteReader) -> Vector:
    return reader.svarint(), reader.svarint(), reader.svarint()


def read_pose(reader: ByteReader) -> Pose:
    origin = _vector(reader)
    return Pose(origin, (_vector(reader), _vector(reader), _vector(reader)))


def _require_length(vector: Vector, highest: int) -> None:
    require(max(map(abs, vector)) <= highest, "a vector of the image is too long")


def _require_plane(image: Image) -> None:
    a, b, c = image.pose.vectors
    _require_length(a, _HIGHEST_OF_PLANE)
    _require_length(b, _HIGHEST_OF_PLANE // image.width)
    _require_length(c, _HIGHEST_OF_PLANE // image.height)
    for column, row in product((0, image.width - 1), (0, image.height - 1)):
        for i in range(3):
            corner = a[i] + b[i] * column + c[i] * row
            require(abs(corner) <= _HIGHEST_OF_PLANE, "a corner of the plane is too far")


def require_pose(image: Image) -> None:
    """The pose is within its ranges."""
    _require_length(image.pose.origin, 1 << 38)
    if not image.is_spinning:
        _require_plane(image)
        return
    for axis in image.pose.vectors:
        _require_length(axis, _UNIT)


def _require_direction(cosine: int, sine: int) -> None:
    require(max(abs(cosine), abs(sine)) <= _UNIT, "a cosine or sine is out of its range")
    require(cosine**2 + sine**2 <= _UNIT * (_UNIT + 2), "a direction is too long")


def _turn(reader: ByteReader) -> Direction:
    cosine, sine = reader.svarint(), reader.svarint()
    _require_direction(cosine, sine)
    return cosine, sine


def _rows(reader: ByteReader, height: int) -> Tuple[Row, ...]:
    rows: List[Row] = []
    numbers = 7 * [0]
    for _ in range(height):
        numbers = [number + reader.svarint() for number in numbers]
        cosine, sine, *others = numbers
        _require_direction(cosine, sine)
        require(max(map(abs, others)) <= _UNIT, "a number of a row is out of its range")
        rows.append(Row((cosine, sine), *others))
    return tuple(rows)


def read_image(reader: ByteReader) -> Image:
    width, height = reader.varint(), reader.varint()
    require(1 <= min(width, height), "the image has no pixels")
    require(max(width, height) <= _LONGEST_SIDE, "the image is too wide or too high")
    require(width * height <= _MOST_PIXELS, "the image has too many pixels")
    (flags,) = reader.numbers("B")
    highest_flags = _SPINNING | _HALF_STEPS | _UNORGANISED | _AT_SENSOR
    require(flags <= highest_flags, "the flags of the image are none")
    is_spinning = bool(flags & _SPINNING)
    image = Image(
        width,
        height,
        is_spinning,
        bool(flags & _HALF_STEPS),
        not flags & _UNORGANISED,
        bool(flags & _AT_SENSOR),
        read_pose(reader),
        tuple(_turn(reader) for _ in range((width - 1).bit_length() * is_spinning)),
        _rows(reader, height * is_spinning),
    )
    require_pose(image)
    return image
