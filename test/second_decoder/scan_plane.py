# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Numbers of a plane: what is expected of each, and what it becomes.

doc/bitstream_scan.md, "Numbers of a plane" and "Depths".
"""

from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Optional, Tuple

from byte_reader import from_zigzag
from invalid_frame import require
from scan_costs import Costs, highest_bit
from scan_symbols import SymbolReader

NO_STEPS = 1 << 29
"""The number of 0 steps, turns, and steps of an angle from column to column."""
_NUMBERS = 1 << 30
_NO_POINT, _AT_SENSOR, _BESIDE = 72, 73, 74
_BESIDE_CONTEXT = 168
_FIRST_CONTEXT = _RUN_CONTEXT = 172

Steps = Tuple[int, int, int]


@dataclass(frozen=True)
class _Expectation:
    number: int
    candidates: Tuple[int, ...]
    """Edge or mean, and past; empty without left, up or past."""
    context: int


class _Plane:
    """The numbers before a pixel, and what they tell about that."""

    def __init__(
        self,
        width: int,
        first: int,
        is_of_means: bool,
        pasts: Optional[Mapping[int, int]] = None,
        is_one_row: bool = False,
    ) -> None:
        self._width = width
        self._is_of_means = is_of_means
        self._is_one_row = is_one_row
        self._last = first
        self._pasts = pasts
        self._costs = Costs(2, decay=64)
        self._is_past_better = False
        self._errors: Dict[int, int] = {}
        self.numbers: Dict[int, int] = {}

    def _pixels_around(self, pixel: int) -> List[Optional[int]]:
        """Left, up, up-left and up-right, None for what is outside the scan."""
        column = pixel % self._width
        above = pixel - self._width
        left = pixel - 1 if column > 0 else None
        if self._is_one_row and column >= 2:
            return [left, pixel - 2, left, left]
        if above < 0:
            return [left, None, None, None]
        up_left = above - 1 if column > 0 else None
        up_right = above + 1 if column + 1 < self._width else None
        return [left, above, up_left, up_right]

    def around(self, pixel: int) -> List[Optional[int]]:
        return [
            None if place is None else self.numbers.get(place)
            for place in self._pixels_around(pixel)
        ]

    def expect(self, pixel: int) -> _Expectation:
        left, up, up_left, up_right = self.around(pixel)
        past = None if self._pasts is None else self._pasts.get(pixel)
        if left is None or up is None:
            there = [n for n in (left, up, up_right, self._last) if n is not None]
            return _Expectation(there[0], (), self._outer_context(pixel, past))
        low, high = min(left, up), max(left, up)
        middle = (low + high) // 2
        corner = middle if up_left is None else up_left
        right = up if up_right is None else up_right
        edge = low + high - corner
        mean = middle + ((right - corner) >> 2)
        number = min(max(mean if self._is_of_means else edge, low), high)
        candidates = () if past is None else (number, past)
        if past is not None and self._is_past_better:
            number = past
        gradient = abs(left - corner) + abs(up - corner) + abs(right - up)
        if self._pasts is not None and past is None:
            context = self._outer_context(pixel, past)
        else:
            context = self._inner_context(pixel, gradient)
        return _Expectation(number, candidates, context)

    def _outer_context(self, pixel: int, past: Optional[int]) -> int:
        p = 0 if self._pasts is None else 2 if past is None else 1
        there = enumerate(self.around(pixel))
        return 16 * p + sum(1 << i for i, number in there if number is not None)

    def _inner_context(self, pixel: int, gradient: int) -> int:
        left, up, _, up_right = self._pixels_around(pixel)
        if self._is_one_row:
            up_right = None
        places = [place for place in (left, up, up_right) if place is not None]
        error = sum(self._errors.get(place, 0) for place in places)
        error_class = _error_class(error)
        of_gradient = highest_bit(gradient + 1)
        of_error = max(error_class - 1, 0) // 2
        if gradient == 0:
            relation = 0
        elif of_gradient + 2 < of_error:
            relation = 1
        elif of_gradient <= of_error:
            relation = 2
        else:
            relation = 3 if of_gradient == of_error + 1 else 4
        return 48 + 24 * relation + error_class

    def learn(self, pixel: int, expected: _Expectation, number: int) -> None:
        self.numbers[pixel] = self._last = number
        self._errors[pixel] = abs(number - expected.number)
        if expected.candidates and pixel % self._width % 4 == 0:
            self._is_past_better = self._costs.best(2) == 1
            self._costs.learn(expected.candidates, number)


def _error_class(error: int) -> int:
    """t of the description."""
    if error == 0 or error >= 1536:
        return 23 if error else 0
    odd = 2 * error + 1
    k = highest_bit(odd)
    return 2 * k + (odd >> (k - 1)) % 2


def _is_of_means(symbols: SymbolReader) -> bool:
    """What a plane begins with."""
    number = symbols.number_of(symbols.symbol(_FIRST_CONTEXT))
    require(number <= 1, "a plane is of neither edges nor means")
    return number == 1


def _number(symbols: SymbolReader, expected: int, symbol: int) -> int:
    """A number whose symbol was read."""
    number = expected + from_zigzag(symbols.number_of(symbol))
    require(0 <= number < _NUMBERS, "a number of a plane is out of its range")
    return number


def read_values(
    source: bytes, size: Tuple[int, int], pixels: Iterable[int], first: int
) -> List[int]:
    """A plane of a width and height with a number for each of some pixels."""
    symbols = SymbolReader(source)
    width, height = size
    plane = _Plane(width, first, _is_of_means(symbols), is_one_row=height == 1)
    for pixel in pixels:
        expected = plane.expect(pixel)
        symbol = symbols.symbol(expected.context)
        plane.learn(pixel, expected, _number(symbols, expected.number, symbol))
    symbols.require_end()
    return list(plane.numbers.values())


class DepthReader:
    """Reads the plane of depths; then these and the other points are known."""

    def __init__(
        self,
        source: bytes,
        size: Tuple[int, int],
        pasts: Optional[Mapping[int, int]],
        may_have_beside: bool,
    ) -> None:
        self._symbols = SymbolReader(source)
        self._width, self._height = size
        self._plane = _Plane(self._width, 0, _is_of_means(self._symbols), pasts)
        self._may_have_beside = may_have_beside
        self.depths = self._plane.numbers
        """By pixel."""
        self.at_sensor: Dict[int, None] = {}
        """The pixels of points at the sensor."""
        self.beside: Dict[int, Steps] = {}

    def read(self) -> None:
        for row in range(self._height):
            pixel = row * self._width
            end = pixel + self._width
            while pixel < end:
                if not any(n is not None for n in self._plane.around(pixel)):
                    pixel += self._run(pixel, end)
                if pixel < end:
                    self._pixel(pixel)
                pixel += 1
        self._symbols.require_end()

    def _run(self, first: int, row_end: int) -> int:
        """Reads how many pixels are passed over."""
        end = first + 1
        while end < row_end and self._plane.around(end)[3] is None:
            end += 1
        u = self._symbols.number_of(self._symbols.symbol(_RUN_CONTEXT))
        require(u <= end - first, "a run is too long")
        length = u - 1 if u else end - first
        if first % self._width > 0 and first - 1 in self.at_sensor:
            self.at_sensor.update(dict.fromkeys(range(first, first + length)))
        return length

    def _pixel(self, pixel: int) -> None:
        expected = self._plane.expect(pixel)
        symbol = self._symbols.symbol(expected.context)
        if symbol == _AT_SENSOR:
            self.at_sensor[pixel] = None
        elif symbol == _BESIDE:
            require(self._may_have_beside, "a point has steps of its own")
            depth = self._beside_number(0, expected.number)
            self.beside[pixel] = self._steps()
            self._plane.learn(pixel, expected, depth)
        elif symbol != _NO_POINT:
            depth = _number(self._symbols, expected.number, symbol)
            self._plane.learn(pixel, expected, depth)

    def _beside_number(self, index: int, expected: int) -> int:
        symbol = self._symbols.symbol(_BESIDE_CONTEXT + index)
        return _number(self._symbols, expected, symbol)

    def _steps(self) -> Steps:
        x, y, z = (self._beside_number(i, NO_STEPS) - NO_STEPS for i in (1, 2, 3))
        return x, y, z
