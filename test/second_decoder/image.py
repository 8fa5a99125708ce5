# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Points in the order of the sensor: pixels of an image.

doc/bitstream_supplement.md, "Image".
"""

from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from fields import WideReader
from image_header import Direction, Image
from invalid_frame import InvalidFrame, require
from morton import node_at
from supplement_numbers import NumberReader

_DEPTHS = 1 << 22
_FRACTION_BITS = 32
"""Of a place."""


@dataclass(frozen=True)
class ImagePoint:
    """A point of a pixel, and the voxel that it is in."""

    pixel: int
    """row * width + column."""
    depth: int
    key: int


# Paragraph "Rays"


def _product(one: Direction, other: Direction) -> Direction:
    (a, b), (c, d) = one, other
    half = 1 << 29
    return (a * c - b * d + half) >> 30, (b * c + a * d + half) >> 30


class Rays:
    """Places of depths."""

    def __init__(self, image: Image) -> None:
        self._image = image
        self._columns: List[Direction] = [(1 << 30, 0)]
        for k, turn in enumerate(image.turns):
            columns = range(min(1 << k, image.width - (1 << k)))
            self._columns += [_product(self._columns[c], turn) for c in columns]

    def place(self, column: int, row: int, depth: int) -> List[int]:
        """P + n S."""
        ray = self._spinning if self._image.is_spinning else self._planar
        half = self._image.has_half_steps
        return [
            (o << 16) + start + (step >> 1 if half else 0) + depth * step
            for o, (start, step) in zip(self._image.pose.origin, ray(column, row))
        ]

    def _planar(self, column: int, row: int) -> List[Tuple[int, int]]:
        """Of each axis P without the origin, and S."""
        a, b, c = self._image.pose.vectors
        return [(0, (a[i] + b[i] * column + c[i] * row) >> 8) for i in range(3)]

    def _spinning(self, column: int, row: int) -> List[Tuple[int, int]]:
        """As of a planar image."""
        of_row = self._image.rows[row]
        u, v = _product(self._columns[column], of_row.direction)
        ray = []
        for x, y, z in zip(*self._image.pose.vectors):
            ahead = (u * x + v * y) >> 30
            left = (u * y - v * x) >> 30
            start = of_row.along * ahead + of_row.across * left + of_row.up * z
            step = of_row.run * ahead + of_row.rise * z
            ray.append((start >> 14, step >> 22))
        return ray


# Paragraph "Depth"


class ExpectedDepth:
    """Cost and errors of one of the expected depths."""

    def __init__(self, width: int) -> None:
        self.cost = 0
        self._of_columns = (width + 1) * [0]
        self._of_row = 0

    def error(self, column: int) -> int:
        return self._of_columns[column] + self._of_columns[column + 1] + self._of_row

    def learn(self, column: int, difference: int) -> None:
        h = 8 * abs(difference)
        self._of_columns[column] = (self._of_columns[column] + 3 * h) // 4
        self._of_row = (self._of_row + h) // 2
        self.cost += 256 * h.bit_length() - self.cost // 256


def _error_class(error: int) -> int:
    """t of the description."""
    q = error // 8
    if q < 4:
        return q
    length = q.bit_length()
    return min(2 * length - 2 + (q >> (length - 2)) % 2, 19)


def _first(*depths: Optional[int]) -> int:
    """The first depth that there is; the last one always is."""
    return next(depth for depth in depths if depth is not None)


class ImageReader:
    """Reads the image of a frame."""

    def __init__(
        self, reader: NumberReader, image: Image, grid_depth: int, pasts: Dict[int, int]
    ) -> None:
        self._reader = reader
        self._wide = WideReader(reader, "image")
        self._image = image
        self._rays = Rays(image)
        self._grid_depth = grid_depth
        self._pasts = pasts
        self._expected = [ExpectedDepth(image.width) for _ in range(3)]
        self._last_depth = 0
        self._miss_rate = 128
        self._depths: Dict[int, int] = {}

    def read(self, point_count: int) -> List[ImagePoint]:
        """The points in the order of pixels."""
        points: List[ImagePoint] = []
        for row in range(self._image.height):
            for column in range(self._image.width):
                if not self._has_point(column, row):
                    continue
                require(len(points) < point_count, "more pixels than said have points")
                pixel = row * self._image.width + column
                if self._image.has_points_at_sensor and self._is_at_sensor(column, row):
                    points.append(ImagePoint(pixel, 0, self._sensor_key()))
                    continue
                depth = self._depth(column, row)
                self._depths[pixel] = self._last_depth = depth
                points.append(ImagePoint(pixel, depth, self._key(column, row, depth)))
        require(len(points) == point_count, "fewer pixels than said have points")
        return points

    def next_pasts(self) -> Dict[int, int]:
        """The pasts after the frame."""
        after = {}
        for pixel, depth in self._depths.items():
            past = self._pasts.get(pixel)
            if past is not None and abs(16 * depth - past) < 256:
                after[pixel] = (3 * past + 16 * depth + 2) // 4
            else:
                after[pixel] = 16 * depth
        return after

    def _of_pixel(
        self, numbers: Dict[int, int], column: int, row: int
    ) -> Optional[int]:
        if not (0 <= column < self._image.width and 0 <= row):
            return None
        return numbers.get(row * self._image.width + column)

    def _around(self, column: int, row: int) -> List[Optional[int]]:
        """Depths left, up, up-left and up-right."""
        places = ((column - 1, row), *((column + c, row - 1) for c in (0, -1, 1)))
        return [self._of_pixel(self._depths, *place) for place in places]

    def _has_point(self, column: int, row: int) -> int:
        return self._reader.bit("point", self._context(column, row))

    def _is_at_sensor(self, column: int, row: int) -> int:
        return self._reader.bit("sensor", self._context(column, row))

    def _sensor_key(self) -> int:
        x, y, z = (coordinate >> 16 for coordinate in self._image.pose.origin)
        key = node_at((x, y, z), self._grid_depth)
        if key is None:
            raise InvalidFrame("a point is at a sensor outside the grid")
        return key

    def _context(self, column: int, row: int) -> int:
        there = self._around(column, row)
        there += [self._of_pixel(self._pasts, column + c, row) for c in (0, 1)]
        return sum(1 << i for i, number in enumerate(there) if number is not None)

    def _depth(self, column: int, row: int) -> int:
        left, up, up_left, up_right = self._around(column, row)
        above = _first(up, up_left, up_right, self._last_depth)
        left = _first(left, above)
        if up is None:
            up = left if up_left is not None else _first(up_right, left)
        up_left = _first(up_left, up)
        up_right = _first(up_right, up)
        edge = min(max(left + up - up_left, min(left, up)), max(left, up))
        mean = (2 * (left + up) + up_right - up_left + 2) >> 2
        expected = [edge, mean]
        past = self._of_pixel(self._pasts, column, row)
        if past is not None:
            expected.append((past + 8) // 16)
        best = min(range(len(expected)), key=lambda i: self._expected[i].cost)
        t = _error_class(self._expected[best].error(column))
        g = abs(left - up_left) + abs(up - up_left) + abs(up_right - up)
        context = 20 * min(g.bit_length(), 11) + t
        depth = expected[best] + self._wide.difference("depth", context)
        require(0 <= depth < _DEPTHS, "a depth is out of its range")
        for of_depth, number in zip(self._expected, expected):
            of_depth.learn(column, depth - number)
        return depth

    # Paragraph "Voxel"

    def _key(self, column: int, row: int, depth: int) -> int:
        place = self._rays.place(column, row, depth)
        parts = [coordinate >> _FRACTION_BITS - 4 & 15 for coordinate in place]
        m = min(min(part, 15 - part) for part in parts)
        k = min(self._miss_rate // 64, 3)
        is_expected = self._reader.bit("on_ray", 8 * k + m)
        self._miss_rate += (0 if is_expected else 16) - self._miss_rate // 16
        x, y, z = (coordinate >> _FRACTION_BITS for coordinate in place)
        if not is_expected:
            x += self._wide.difference("offset", k)
            y += self._wide.difference("offset", 4 + k)
            z += self._wide.difference("offset", 8 + k)
        key = node_at((x, y, z), self._grid_depth)
        if key is None:
            raise InvalidFrame("a voxel is outside the grid")
        return key
