"""The image of a frame header: its size, and what its rays are made of.

doc/bitstream.md, the table of the image in "Frame header".
"""

from dataclasses import dataclass
from itertools import product
from typing import List, Tuple

from byte_reader import ByteReader
from invalid_frame import require

_SPINNING, _HALF_STEPS = 1, 2
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
class Image:
    """Size and rays of an image."""

    width: int
    height: int
    is_spinning: bool
    has_half_steps: bool
    origin: Vector
    vectors: Tuple[Vector, Vector, Vector]
    """Planar: A, B and C; spinning: X, Y and Z."""
    turns: Tuple[Direction, ...] = ()
    rows: Tuple[Row, ...] = ()

    @property
    def pixel_count(self) -> int:
        return self.width * self.height


def _vector(reader: ByteReader, highest: int) -> Vector:
    x, y, z = (reader.svarint() for _ in range(3))
    require(max(abs(x), abs(y), abs(z)) <= highest, "a vector of the image is too long")
    return x, y, z


def _plane(reader: ByteReader, width: int, height: int) -> Tuple[Vector, Vector, Vector]:
    a = _vector(reader, _HIGHEST_OF_PLANE)
    b = _vector(reader, _HIGHEST_OF_PLANE // width)
    c = _vector(reader, _HIGHEST_OF_PLANE // height)
    for column, row in product((0, width - 1), (0, height - 1)):
        for i in range(3):
            corner = a[i] + b[i] * column + c[i] * row
            require(abs(corner) <= _HIGHEST_OF_PLANE, "a corner of the plane is too far")
    return a, b, c


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
    require(flags <= _SPINNING | _HALF_STEPS, "the flags of the image are none")
    has_half_steps = bool(flags & _HALF_STEPS)
    origin = _vector(reader, 1 << 38)
    if not flags & _SPINNING:
        plane = _plane(reader, width, height)
        return Image(width, height, False, has_half_steps, origin, plane)
    axes = (_vector(reader, _UNIT), _vector(reader, _UNIT), _vector(reader, _UNIT))
    turns = tuple(_turn(reader) for _ in range((width - 1).bit_length()))
    rows = _rows(reader, height)
    return Image(width, height, True, has_half_steps, origin, axes, turns, rows)
