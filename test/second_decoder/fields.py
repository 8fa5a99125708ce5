# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Fields of points: numbers of 64 bits, 0..2^64 - 1.

doc/bitstream_supplement.md, "Fields".
"""

from dataclasses import dataclass, field
from math import isqrt
from typing import Dict, List, Optional, Sequence, Tuple

from byte_reader import from_zigzag
from frame_header import Field
from invalid_frame import require
from morton import neighbours, position
from supplement_numbers import NumberReader

_MODULUS = 1 << 64
_AZIMUTHS, _ELEVATIONS = 8192, 4096
_ERROR_AT_START = 1024
_ZERO_OF_TYPE = {1: 1 << 7, 3: 1 << 15, 5: 1 << 31, 7: 1 << 31, 8: 1 << 63}
"""Numbers of the value 0 that are not 0, of exact values."""


def number_of_zero(described: Field) -> int:
    """The number of the value 0."""
    if described.step is not None:
        return (1 << 52) + 1
    return _ZERO_OF_TYPE.get(described.type, 0)


def signed(number: int) -> int:
    """A number modulo 2^64 as one of -2^63..2^63 - 1."""
    number %= _MODULUS
    return number - _MODULUS if number >> 63 else number


def folded(difference: int) -> int:
    """2 D if D >= 0, else -2 D - 1."""
    d = signed(difference)
    return 2 * d if d >= 0 else -2 * d - 1


def _towards_zero(dividend: int, divisor: int) -> int:
    quotient = abs(dividend) // divisor
    return quotient if dividend >= 0 else -quotient


class WideReader:
    """Wide numbers of a field."""

    def __init__(self, reader: NumberReader, index: int) -> None:
        self._reader = reader
        self._index = index

    def bit(self) -> int:
        return self._reader.bits(1)

    def wide(self, *lengths: object) -> int:
        """A wide number with a model of lengths."""
        length = part = self._nibble(*lengths)
        while part == 15 and length < 64:
            part = self._nibble("further")
            length += part
        require(length <= 64, "a wide number has more than 64 bits")
        if length < 2:
            return length
        bits = length - 1
        first = min(bits, 4)
        nibble = self._nibble("tail", length)
        require(nibble < 1 << first, "a wide number has a bit too many")
        number = (1 << first | nibble) << bits - first
        return number | self._reader.bits(bits - first)

    def difference(self, *lengths: object) -> int:
        """A folded difference as a wide number."""
        return from_zigzag(self.wide(*lengths))

    def _nibble(self, *context: object) -> int:
        model = self._reader.models.nibble("wide", self._index, *context)
        return model.read(self._reader.rans)


class DirectionTable:
    """The last number of each bin."""

    def __init__(self, bins: int) -> None:
        self._numbers: List[Optional[int]] = bins * [None]

    def copy(self) -> "DirectionTable":
        other = DirectionTable(0)
        other._numbers = list(self._numbers)
        return other

    def learn(self, place: int, number: int) -> None:
        self._numbers[place] = number

    def expected(self, place: int) -> Optional[int]:
        number = self._numbers[place]
        if number is not None:
            return number
        below = self._nearest(place, -1, place % 64 + 128)
        above = self._nearest(place, 1, 63 - place % 64 + 128)
        if below is None or above is None:
            one = below or above
            return None if one is None else one[1]
        (i, low), (j, high) = below, above
        d = signed(high - low)
        if abs(d) < 1 << 52:
            return (low + _towards_zero(d * i, i + j)) % _MODULUS
        return low if i <= j else high

    def _nearest(
        self, place: int, side: int, farthest: int
    ) -> Optional[Tuple[int, int]]:
        """Distance and number of the nearest bin with a number on a side."""
        for distance in range(1, farthest + 1):
            number = self._numbers[(place + side * distance) % len(self._numbers)]
            if number is not None:
                return distance, number
        return None


def azimuth(x: int, y: int) -> int:
    """Bin of the table of azimuths."""
    t = abs(y) * 2048 // max(abs(x) + abs(y), 1)
    h = t if x >= 0 else 4096 - t
    return (h if y >= 0 else 8192 - h) % 8192


def elevation(x: int, y: int, z: int) -> int:
    """Bin of the table of elevations."""
    r = abs(z) * 2048 // max(abs(z) + isqrt(x * x + y * y), 1)
    return min(2048 + r if z >= 0 else 2048 - r, 4095)


@dataclass
class FieldMemory:
    """What is kept of a field since the last I-frame, besides models."""

    listed: Sequence[int] = ()
    azimuths: DirectionTable = field(default_factory=lambda: DirectionTable(_AZIMUTHS))
    elevations: DirectionTable = field(
        default_factory=lambda: DirectionTable(_ELEVATIONS)
    )
    past: Dict[int, int] = field(default_factory=dict)
    """By key: number of the voxel's first point in the last frame with voxels; in scans
    by pixel."""

    def copy(self) -> "FieldMemory":
        return FieldMemory(
            self.listed, self.azimuths.copy(), self.elevations.copy(), self.past
        )

    def clear_numbers(self) -> None:
        """Forgets all but the list."""
        self.azimuths = DirectionTable(_AZIMUTHS)
        self.elevations = DirectionTable(_ELEVATIONS)
        self.past = {}


class Points:
    """The points of a frame by voxel, and where voxels are."""

    def __init__(
        self,
        keys: Sequence[int],
        point_counts: Sequence[int],
        depth: int,
        viewpoint: Tuple[int, int, int],
    ) -> None:
        self.keys = keys
        self.counts = point_counts or len(keys) * [1]
        self._depth = depth
        self._viewpoint = viewpoint

    def size(self) -> int:
        return sum(self.counts)

    def lower_neighbours(self, key: int) -> Tuple[Optional[int], ...]:
        """Keys at x - 1, y - 1, z - 1."""
        return neighbours(key, self._depth)[:3]

    def direction(self, key: int) -> Tuple[int, int]:
        """Azimuth and elevation of a voxel."""
        x, y, z = (p - v for p, v in zip(position(key), self._viewpoint))
        return azimuth(x, y), elevation(x, y, z)


class PixelPoints(Points):
    """Points of a scan: keys are pixels, row * width + column."""

    def __init__(self, pixels: Sequence[int], width: int) -> None:
        self.keys = pixels
        self.counts = len(pixels) * [1]
        self._width = width

    def lower_neighbours(self, key: int) -> Tuple[Optional[int], ...]:
        """Pixels at the left and above."""
        return key - 1 if key % self._width else None, key - self._width

    def direction(self, key: int) -> Tuple[int, int]:
        """Azimuth and elevation of a pixel."""
        row, column = divmod(key, self._width)
        return column % _AZIMUTHS, row % _ELEVATIONS


class SingleValues:
    """Section "Single values": the numbers of a frame, or indices of a list."""

    def __init__(
        self, reader: WideReader, points: Points, memory: FieldMemory, start: int
    ) -> None:
        self._reader = reader
        self._points = points
        self._memory = memory
        self._last = start
        self._errors = 4 * [_ERROR_AT_START]
        self._first_points: Dict[int, int] = {}

    def read(self) -> List[int]:
        numbers = []
        for key, count in zip(self._points.keys, self._points.counts):
            direction = self._points.direction(key)
            numbers.append(self._point(key, direction, self._of_neighbours(key)))
            self._first_points[key] = self._last
            for _ in range(1, count):
                numbers.append(self._point(key, direction, self._last))
        self._memory.past = self._first_points
        return numbers

    def _of_neighbours(self, key: int) -> int:
        lower = self._points.lower_neighbours(key)
        numbers = [self._first_points[n] for n in lower if n in self._first_points]
        if not numbers:
            return self._last
        differences = [signed(number - numbers[0]) for number in numbers]
        near = [d for d in differences if abs(d) < 1 << 60]
        return (numbers[0] + _towards_zero(sum(near), len(near))) % _MODULUS

    def _point(self, key: int, direction: Tuple[int, int], near: int) -> int:
        memory = self._memory
        tables = (memory.azimuths, memory.elevations)
        expected = [near, *(t.expected(b) for t, b in zip(tables, direction))]
        expected.append(memory.past.get(key))
        there = {i: e for i, e in enumerate(expected) if e is not None}
        order = sorted(there, key=lambda i: (self._errors[i], i))
        best = there[order[0]]
        a = min((self._errors[order[0]] + 64) // 128, 15)
        s = 0
        if len(order) > 1:
            s = min(folded(best - there[order[1]]).bit_length(), 7)
        number = (best + self._reader.difference("length", 8 * a + s)) % _MODULUS
        for i, e in there.items():
            length = folded(number - e).bit_length()
            self._errors[i] += 16 * length - self._errors[i] // 16
        for table, place in zip(tables, direction):
            table.learn(place, number)
        self._last = number
        return number


def _read_list(reader: WideReader, point_count: int) -> List[int]:
    count = reader.wide("list")
    require(1 <= count <= point_count, "a list has too many numbers, or none")
    numbers = []
    number = difference = 0
    for _ in range(count):
        difference += reader.difference("list")
        number = (number + difference) % _MODULUS
        numbers.append(number)
    return numbers


def _read_single_values(
    reader: WideReader, described: Field, points: Points, memory: FieldMemory
) -> List[int]:
    has_list = bool(reader.bit())
    if has_list != bool(memory.listed):
        memory.clear_numbers()
    if not has_list:
        memory.listed = ()
        return SingleValues(reader, points, memory, number_of_zero(described)).read()
    if reader.bit():
        require(bool(memory.listed), "the last frame has no list")
    else:
        memory.listed = _read_list(reader, points.size())
    indices = SingleValues(reader, points, memory, 0).read()
    require(max(indices) < len(memory.listed), "an index is not in the list")
    return [memory.listed[index] for index in indices]


def _read_several_values(
    reader: WideReader, described: Field, points: Points
) -> List[int]:
    """Section "Several values"."""
    error = _ERROR_AT_START
    numbers: List[int] = []
    last = described.value_count * [number_of_zero(described)]
    first_points: Dict[int, List[int]] = {}
    for key, count in zip(points.keys, points.counts):
        for lower in points.lower_neighbours(key):
            if lower in first_points:
                last = first_points[lower]
        for place in range(count):
            values = []
            for expected in last:
                a = min((error + 64) // 128, 15)
                difference = reader.difference("length", 8 * a)
                values.append((expected + difference) % _MODULUS)
                error += 16 * folded(difference).bit_length() - error // 16
            last = values
            numbers += values
            if place == 0:
                first_points[key] = values
    return numbers


def decode_field(
    reader: NumberReader,
    described: Field,
    index: int,
    points: Points,
    memory: FieldMemory,
) -> List[int]:
    """The numbers of all points; changes the memory."""
    wide_reader = WideReader(reader, index)
    if described.value_count > 1:
        return _read_several_values(wide_reader, described, points)
    return _read_single_values(wide_reader, described, points, memory)
