# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Rays of a scan: where its points are.

doc/bitstream_scan.md, "Places".
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Dict, List, Optional, Tuple

from scan_header import FREE, SPINNING, Direction, Pose, Row, Vector

Ray = Tuple[List[int], List[int]]
"""P and S."""


@dataclass(frozen=True)
class ScanRays:
    """What the frame header says of rays."""

    shape: int
    pose: Pose
    """At column 0."""
    motion: Pose
    """From a column to the next."""
    has_half_depths: bool = False
    turns: Tuple[Direction, ...] = ()
    rows: Tuple[Row, ...] = ()


def _product(one: Direction, other: Direction) -> Direction:
    (a, b), (c, d) = one, other
    half = 1 << 29
    return (a * c - b * d + half) >> 30, (b * c + a * d + half) >> 30


@dataclass(frozen=True)
class _Column:
    """The sensor at a column: O, F, L and Z' of the description."""

    origin: List[int]
    ahead: List[int]
    left: List[int]
    up: List[int]


class Places:
    """Places of the points of a frame."""

    def __init__(self, rays: ScanRays, angles: List[int]) -> None:
        self._rays = rays
        self._angles = angles
        self._columns: Dict[int, _Column] = {}
        self._direction = lru_cache(maxsize=None)(self._direction_of)

    def place(
        self, column: int, row: int, depth: Optional[int], turn: int, steps: Vector
    ) -> Vector:
        """The place of a point; without a depth it is at the sensor."""
        start, step = [o << 16 for o in self._rays.pose.origin], [0, 0, 0]
        if depth is not None and self._rays.shape == SPINNING:
            start, step = self._spinning(self._column(column), row, turn)
        elif depth is not None and self._rays.shape != FREE:
            step = self._planar(column, row)
            if self._rays.has_half_depths:
                start = [o + (s >> 1) for o, s in zip(start, step)]
        x, y, z = (
            start[i] + (depth or 0) * step[i] + (steps[i] << 32) for i in range(3)
        )
        return x, y, z

    def _planar(self, column: int, row: int) -> List[int]:
        a, b, c = self._rays.pose.vectors
        return [(a[i] + b[i] * column + c[i] * row) >> 8 for i in range(3)]

    def _direction_of(self, steps: int) -> Direction:
        direction = 1 << 30, 0
        for k, turn in enumerate(self._rays.turns):
            if abs(steps) >> k & 1:
                direction = _product(direction, turn)
        cosine, sine = direction
        return cosine, -sine if steps < 0 else sine

    def _column(self, column: int) -> _Column:
        if column not in self._columns:
            self._columns[column] = self._make_column(column)
        return self._columns[column]

    def _make_column(self, column: int) -> _Column:
        pose, motion = self._rays.pose, self._rays.motion
        u, v = self._direction(self._angles[column])
        x, y, z = (
            [n + (m * column >> 16) for n, m in zip(*of_axis)]
            for of_axis in zip(pose.vectors, motion.vectors)
        )
        return _Column(
            [(n << 16) + m * column for n, m in zip(pose.origin, motion.origin)],
            [(u * i + v * j) >> 30 for i, j in zip(x, y)],
            [(u * j - v * i) >> 30 for i, j in zip(x, y)],
            z,
        )

    def _spinning(self, column: _Column, row: int, turn: int) -> Ray:
        of_row = self._rays.rows[row]
        p, q = _product(of_row.direction, self._direction(turn))
        start, step = [], []
        of_axes = zip(column.origin, column.ahead, column.left, column.up)
        for origin, f, l, up in of_axes:
            ahead = (p * f + q * l) >> 30
            left = (p * l - q * f) >> 30
            away = of_row.along * ahead + of_row.across * left + of_row.up * up
            start.append(origin + (away >> 14))
            step.append((of_row.run * ahead + of_row.rise * up) >> 22)
        return start, step
