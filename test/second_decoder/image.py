"""Images: points in the order of their sensor, along rays.

doc/bitstream.md, "Frame header", and doc/bitstream_supplement.md, "Image".
"""

from dataclasses import dataclass
from typing import Dict, List, Optional, Tuple

from fields import WideReader
from frame_header import Image
from invalid_frame import require
from supplement_numbers import NumberReader

Vector = Tuple[int, ...]
"""x, y, z."""

_DEPTH_END = 1 << 22


def _product(one: Vector, other: Vector) -> Vector:
    """The direction that is turned by both."""
    (a, b), (c, d) = one, other
    half = 1 << 29
    return (a * c - b * d + half) >> 30, (b * c + a * d + half) >> 30


class Rays:
    """Start and step of the rays of pixels, units of 2^-32 voxels."""

    def __init__(self, image: Image) -> None:
        self._image = image
        self._columns: List[Vector] = [(1 << 30, 0)]
        if image.is_spinning:
            for column in range(1, image.width):
                bit = column.bit_length() - 1
                before = self._columns[column - (1 << bit)]
                self._columns.append(_product(before, image.turns[bit]))

    def ray(self, row: int, column: int) -> Tuple[Vector, Vector]:
        start, step = (
            self._spinning(row, column)
            if self._image.is_spinning
            else self._planar(row, column)
        )
        if self._image.has_half_steps:
            start = tuple(p + (s >> 1) for p, s in zip(start, step))
        return start, step

    def _planar(self, row: int, column: int) -> Tuple[Vector, Vector]:
        a, b, c = self._image.vectors
        return (
            tuple(o << 16 for o in self._image.origin),
            tuple((i + j * column + k * row) >> 8 for i, j, k in zip(a, b, c)),
        )

    def _spinning(self, row: int, column: int) -> Tuple[Vector, Vector]:
        cosine, sine, run, rise, along, across, up = self._image.rows[row]
        u, v = _product(self._columns[column], (cosine, sine))
        start, step = [], []
        for origin, x, y, z in zip(self._image.origin, *self._image.vectors):
            ahead = (u * x + v * y) >> 30
            left = (u * y - v * x) >> 30
            offset = (along * ahead + across * left + up * z) >> 14
            start.append((origin << 16) + offset)
            step.append((run * ahead + rise * z) >> 22)
        return tuple(start), tuple(step)


@dataclass
class PixelPoint:
    """The point of a pixel."""

    depth: int
    position: Vector
    """Of its voxel in the grid."""


def _or(*choices: Optional[int]) -> int:
    """The first one that there is."""
    return next(choice for choice in choices if choice is not None)


@dataclass
class Expected:
    """An expected depth: its cost and its errors."""

    columns: List[int]
    row: int = 0
    cost: int = 0

    def error(self, column: int) -> int:
        after = self.columns[column + 1] if column + 1 < len(self.columns) else 0
        return self.columns[column] + after + self.row

    def learn(self, column: int, difference: int) -> None:
        h = 8 * abs(difference)
        self.columns[column] = (self.columns[column] + 3 * h) // 4
        self.row = (self.row + h) // 2
        self.cost += 256 * h.bit_length() - self.cost // 256


class ImageReader:
    """The points of a frame."""

    def __init__(
        self, reader: NumberReader, image: Image, depth: int, past: Dict[int, int]
    ) -> None:
        self._reader = reader
        self._wide = WideReader(reader, "image")
        self._image = image
        self._rays = Rays(image)
        self._end = 1 << depth
        self._past = past
        self._points: Dict[int, PixelPoint] = {}
        self._last = 0
        self._miss_rate = 128
        self._expected = [Expected([0] * image.width) for _ in range(3)]

    def read(self, point_count: int) -> Tuple[Dict[int, PixelPoint], Dict[int, int]]:
        """The points by pixel, and the past after the frame."""
        past: Dict[int, int] = {}
        for pixel in range(self._image.width * self._image.height):
            if not self._is_point(pixel):
                continue
            require(len(self._points) < point_count, "there are too many points")
            depth = self._depth(pixel)
            past[pixel] = self._past_after(pixel, depth)
            position = self._voxel(pixel, depth)
            self._points[pixel] = PixelPoint(depth, position)
        require(len(self._points) == point_count, "there are too few points")
        return self._points, past

    def _around(self, pixel: int) -> List[Optional[int]]:
        """Pixels at the left, above, above and left, above and right."""
        row, column = divmod(pixel, self._image.width)
        is_last = column + 1 == self._image.width
        return [
            pixel - 1 if column else None,
            pixel - self._image.width if row else None,
            pixel - self._image.width - 1 if row and column else None,
            pixel - self._image.width + 1 if row and not is_last else None,
        ]

    def _is_point(self, pixel: int) -> bool:
        context = 0
        for bit, other in enumerate(self._around(pixel)):
            context |= (other in self._points) << bit
        is_last = (pixel + 1) % self._image.width == 0
        context |= (pixel in self._past) << 4
        context |= (not is_last and pixel + 1 in self._past) << 5
        return bool(self._reader.bit("point", context))

    def _expect(self, pixel: int) -> Tuple[List[Optional[int]], int]:
        """Expected depths, and how much those around differ."""
        left, up, up_left, up_right = (
            self._points[other].depth if other in self._points else None
            for other in self._around(pixel)
        )
        above = _or(up, up_left, up_right, self._last)
        left = _or(left, above)
        if up is None:
            up = _or(up_right, left) if up_left is None else left
        up_left = _or(up_left, up)
        up_right = _or(up_right, up)
        low, high = sorted((left, up))
        edge = min(max(left + up - up_left, low), high)
        mean = (2 * (left + up) + up_right - up_left + 2) >> 2
        past = (self._past[pixel] + 8) // 16 if pixel in self._past else None
        g = abs(left - up_left) + abs(up - up_left) + abs(up_right - up)
        return [edge, mean, past], g

    def _depth(self, pixel: int) -> int:
        column = pixel % self._image.width
        depths, g = self._expect(pixel)
        there = [i for i, depth in enumerate(depths) if depth is not None]
        best = min(there, key=lambda i: (self._expected[i].cost, i))
        q = self._expected[best].error(column) // 8
        length = q.bit_length()
        t = q if q < 4 else min(2 * length - 2 + (q >> length - 2) % 2, 19)
        context = 20 * min(g.bit_length(), 11) + t
        depth = _or(depths[best]) + self._wide.difference("depth", context)
        require(0 <= depth < _DEPTH_END, "a depth is none")
        for i in there:
            self._expected[i].learn(column, depth - _or(depths[i]))
        self._last = depth
        return depth

    def _past_after(self, pixel: int, depth: int) -> int:
        past = self._past.get(pixel)
        if past is None or abs(16 * depth - past) >= 256:
            return 16 * depth
        return (3 * past + 16 * depth + 2) // 4

    def _voxel(self, pixel: int, depth: int) -> Vector:
        start, step = self._rays.ray(*divmod(pixel, self._image.width))
        places = [p + depth * s for p, s in zip(start, step)]
        position = tuple(place >> 32 for place in places)
        parts = [place >> 28 & 15 for place in places]
        m = min(7, *(min(part, 15 - part) for part in parts))
        k = min(self._miss_rate // 64, 3)
        is_on_ray = self._reader.bit("on_ray", 8 * k + m)
        self._miss_rate += (0 if is_on_ray else 16) - self._miss_rate // 16
        if not is_on_ray:
            position = tuple(
                expected + self._wide.difference("offset", 4 * axis + k)
                for axis, expected in enumerate(position)
            )
        require(
            all(0 <= at < self._end for at in position), "a voxel is outside the grid"
        )
        return position
