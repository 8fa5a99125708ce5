# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The points of a scan, in the order of the sensor.

doc/bitstream_scan.md, "Order".
"""

from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

from byte_reader import ByteReader
from image_header import Vector
from invalid_frame import require
from scan_plane import NO_STEPS, DepthReader, read_values
from scan_rays import Places, ScanRays

_DEPTHS = 1 << 24
_MOST_STEPS = 1 << 28
_NO_DIFFERENCE = 1 << 8
"""The number of red or blue that is as green is."""

Colour = Tuple[int, int, int]
"""Red, green and blue."""


@dataclass(frozen=True)
class ScanLayout:
    """What the frame header says besides rays."""

    width: int
    height: int
    is_spinning: bool
    point_count: int
    symbol_bits: int = 0
    """0 without intensities."""
    colour_bits: int = 0
    """0 without colours."""


@dataclass(frozen=True)
class ScanPoint:
    """A point of a pixel."""

    pixel: int
    """row * width + column."""
    depth: Optional[int]
    """None: at the sensor."""
    turn: int
    steps: Vector
    """From the ray."""
    symbol: Optional[int]
    colour: Optional[Colour]


@dataclass(frozen=True)
class Scan:
    """The points of a frame."""

    layout: ScanLayout
    points: List[ScanPoint]
    angles: List[int] = field(default_factory=list)
    """Of the columns of a spinning sensor."""

    def pasts(self) -> Dict[int, int]:
        """Depths by pixel, for the next frame."""
        return {p.pixel: p.depth for p in self.points if p.depth is not None}

    def places(self, rays: ScanRays) -> List[Vector]:
        """Where the points are from the grid's lowest corner, edges in 2^-32."""
        places = Places(rays, self.angles)
        return [
            places.place(
                point.pixel % self.layout.width,
                point.pixel // self.layout.width,
                point.depth,
                point.turn,
                point.steps,
            )
            for point in self.points
        ]


class _ScanReader:
    """Reads the parts of a frame one after the other."""

    def __init__(self, source: bytes, layout: ScanLayout) -> None:
        self._reader = ByteReader(source)
        self._layout = layout
        self._pixels: List[int] = []

    def read(self, pasts: Optional[Dict[int, int]]) -> Scan:
        layout = self._layout
        depths, steps = self._depths_and_steps(pasts)
        angles = self._angles() if layout.is_spinning else []
        turns = len(self._pixels) * [0]
        if layout.is_spinning and self._flag():
            turns = [number - NO_STEPS for number in self._values(NO_STEPS)]
        symbols: List[Optional[int]] = len(self._pixels) * [None]
        if layout.symbol_bits:
            symbols = [*self._values(0)]
            self._require_below(symbols, layout.symbol_bits)
        colours: List[Optional[Colour]] = len(self._pixels) * [None]
        if layout.colour_bits:
            colours = [*self._colours()]
        require(not self._reader.rest(), "bytes are left behind the scan")
        points = zip(self._pixels, depths, turns, steps, symbols, colours)
        return Scan(layout, [ScanPoint(*point) for point in points], angles)

    def _flag(self) -> bool:
        (flag,) = self._reader.numbers("B")
        require(flag <= 1, "a flag of the scan is neither 0 nor 1")
        return flag == 1

    def _plane(self) -> bytes:
        return self._reader.bytes(self._reader.varint())

    def _values(self, first: int) -> List[int]:
        return read_values(self._plane(), self._layout.width, self._pixels, first)

    def _depths_and_steps(
        self, pasts: Optional[Dict[int, int]]
    ) -> Tuple[List[Optional[int]], List[Vector]]:
        size = self._layout.width, self._layout.height
        has_steps = self._flag()
        reader = DepthReader(self._plane(), size, pasts, not has_steps)
        reader.read()
        require(
            all(depth < _DEPTHS for depth in reader.depths.values()),
            "a depth is out of its range",
        )
        self._pixels = sorted([*reader.depths, *reader.at_sensor])
        require(
            len(self._pixels) == self._layout.point_count,
            "other pixels than said have points",
        )
        steps = [reader.beside.get(pixel, (0, 0, 0)) for pixel in self._pixels]
        if has_steps:
            x, y, z = (self._values(NO_STEPS) for _ in range(3))
            of_points = zip(x, y, z)
            steps = [(i - NO_STEPS, j - NO_STEPS, k - NO_STEPS) for i, j, k in of_points]
        require(
            all(abs(n) < _MOST_STEPS for of_point in steps for n in of_point),
            "a point is too far beside its ray",
        )
        for pixel, of_point in zip(self._pixels, steps):
            require(
                pixel in reader.depths or not any(of_point),
                "a point at the sensor has steps",
            )
        return [reader.depths.get(pixel) for pixel in self._pixels], steps

    def _angles(self) -> List[int]:
        width = self._layout.width
        angles = []
        angle = 0
        for number in read_values(self._plane(), width, range(width), NO_STEPS):
            angle += number - NO_STEPS
            angles.append((angle + (1 << 31)) % (1 << 32) - (1 << 31))
        return angles

    def _colours(self) -> List[Colour]:
        bits = self._layout.colour_bits
        green = self._values(0)
        self._require_below(green, bits)
        red, blue = (
            [n + g - _NO_DIFFERENCE for n, g in zip(self._values(_NO_DIFFERENCE), green)]
            for _ in range(2)
        )
        self._require_below(red, bits)
        self._require_below(blue, bits)
        return list(zip(red, green, blue))

    @staticmethod
    def _require_below(numbers: List[int], bits: int) -> None:
        require(
            all(0 <= number < 1 << bits for number in numbers),
            "an intensity or a colour is out of its range",
        )


def decode_scan(source: bytes, layout: ScanLayout, before: Optional[Scan]) -> Scan:
    """The points of a frame.

    before: the last frame that had points; None in an I-frame
    """
    if before is None:
        return _ScanReader(source, layout).read(None)
    require(
        (layout.width, layout.height) == (before.layout.width, before.layout.height),
        "a P-frame has another size than the frame before",
    )
    return _ScanReader(source, layout).read(before.pasts())
