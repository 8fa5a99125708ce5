# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Positions of the points of a free scan.

doc/bitstream_scan.md, "Positions".
"""

from dataclasses import dataclass
from math import isqrt
from typing import Dict, List, Optional, Sequence, Tuple

from byte_reader import from_zigzag
from invalid_frame import require
from scan_costs import Costs, highest_bit
from scan_header import Vector
from scan_symbols import POSITION_CONTEXTS, SymbolReader

MOST_STEPS = 1 << 28
"""Steps are of a smaller absolute value."""
_LEADS = 4
_LARGEST_FIRST_CONTEXT = 27
_CONTEXTS_AT = (0, 28, 140)
"""Of the first, second and third coordinate."""

_Errors = Tuple[int, int, int]
"""Of the first, second and third coordinate."""


@dataclass(frozen=True)
class _Coded:
    """A point that was read."""

    position: Vector
    errors: _Errors


def _clamped(number: int) -> int:
    return min(max(number, 1 - MOST_STEPS), MOST_STEPS - 1)


def _scaled(a: int, b: int, c: int) -> int:
    return a if c == 0 else _clamped((2 * a * b + c) // (2 * c))


def _distance(x: int, y: int) -> int:
    return isqrt(64 * (x * x + y * y))


def _continued(last: Vector, second: Vector) -> Vector:
    """Lead 1 or 3."""
    x, y, z = (_clamped(2 * i - j) for i, j in zip(last, second))
    return x, y, z


def _first_context(error: int) -> int:
    odd = 2 * error + 1
    of_error = highest_bit(odd)
    if of_error == 0:
        return 0
    return min(2 * of_error + (odd >> (of_error - 1)) % 2, _LARGEST_FIRST_CONTEXT)


def _later_context(error: int, of_point: int) -> int:
    """Without the first context of the coordinate."""
    of_error = highest_bit(2 * error + 1)
    relation = highest_bit(2 * of_point + 1) // 2
    return 8 * min(of_error, 13) + min(relation, 7)


class _PositionReader:
    """Reads one point after the other."""

    def __init__(self, source: bytes, width: int) -> None:
        self.symbols = SymbolReader(source, POSITION_CONTEXTS)
        self._width = width
        counts = _LEADS, 2 * _LEADS, 2 * _LEADS
        self._costs = [Costs(count, decay=16) for count in counts]
        self._points: Dict[int, _Coded] = {}
        """By pixel, in the order of pixels."""
        self._last: Optional[_Coded] = None
        self._second: Optional[_Coded] = None

    def _leads(self, pixel: int) -> List[Vector]:
        if self._last is None:
            return _LEADS * [(0, 0, 0)]
        last = self._last.position
        ahead = last
        if self._second is not None:
            ahead = _continued(last, self._second.position)
        up = self._points.get(pixel - self._width)
        if up is None:
            return [last, ahead, last, last]
        above = self._points.get(pixel - 2 * self._width)
        down = up.position
        if above is not None:
            down = _continued(up.position, above.position)
        return [last, ahead, up.position, down]

    def read(self, pixel: int) -> Vector:
        leads = self._leads(pixel)
        x, y, _ = leads[0]
        first, second = (1, 0) if abs(y) > abs(x) else (0, 1)
        before = [self._last, self._second, self._points.get(pixel - self._width)]
        e = [sum(p.errors[i] for p in before if p is not None) for i in range(3)]
        position = [0, 0, 0]

        candidates = [lead[first] for lead in leads]
        context = _first_context(e[0])
        position[first], error = self._coordinate(0, candidates, context)
        errors = [error]

        own = position[first]
        candidates = [lead[second] for lead in leads]
        candidates += [_scaled(lead[second], own, lead[first]) for lead in leads]
        context = _later_context(e[1], errors[0])
        position[second], error = self._coordinate(1, candidates, context)
        errors.append(error)

        own = _distance(position[0], position[1])
        candidates = [lead[2] for lead in leads]
        candidates += [_scaled(z, own, _distance(x, y)) for x, y, z in leads]
        context = _later_context(e[2], errors[0] + errors[1])
        position[2], error = self._coordinate(2, candidates, context)
        errors.append(error)

        point = _Coded(
            (position[0], position[1], position[2]), (errors[0], errors[1], errors[2])
        )
        self._points[pixel] = point
        self._last, self._second = point, self._last
        return point.position

    def _coordinate(
        self, index: int, candidates: Sequence[int], context: int
    ) -> Tuple[int, int]:
        """The first, second or third coordinate of a point, and its error."""
        costs = self._costs[index]
        expected = candidates[costs.best(len(candidates))]
        symbol = self.symbols.symbol(_CONTEXTS_AT[index] + context)
        difference = from_zigzag(self.symbols.number_of(symbol))
        coordinate = expected + difference
        require(abs(coordinate) < MOST_STEPS, "a point is too far from the sensor")
        if len(self._points) % 4 == 0:
            costs.learn(candidates, coordinate)
        return coordinate, abs(difference)


def read_positions(source: bytes, width: int, pixels: Sequence[int]) -> List[Vector]:
    """The steps of the points at some pixels from the sensor."""
    reader = _PositionReader(source, width)
    positions = [reader.read(pixel) for pixel in pixels]
    reader.symbols.require_end()
    return positions
