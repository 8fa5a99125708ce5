# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The points of a scan, in the order of the sensor.

doc/bitstream_scan.md, "Order" and "Past".
"""

from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Tuple

from byte_reader import ByteReader
from fields import FieldMemory, PixelPoints, decode_field
from frame_header import Field
from invalid_frame import require
from scan_header import FREE, SPINNING, Vector
from scan_plane import NO_STEPS, DepthReader, read_values
from scan_positions import MOST_STEPS, read_positions
from scan_rays import Places, ScanRays
from supplement_numbers import Models, NumberReader

_DEPTHS = 1 << 24
_NO_DIFFERENCE = 1 << 8
"""The number of red or blue that is as green is."""

Colour = Tuple[int, int, int]
"""Red, green and blue."""


@dataclass(frozen=True)
class ScanLayout:
    """What the frame header says besides rays."""

    width: int
    height: int
    shape: int
    is_sequence: bool
    shifts: Tuple[int, ...]
    """Of rows, in columns; empty without."""
    point_count: int
    symbol_bits: int = 0
    """0 without intensities."""
    colour_bits: int = 0
    """0 without colours."""
    fields: Tuple[Field, ...] = ()

    @property
    def ray_columns(self) -> int:
        return self.width - max(self.shifts, default=0)

    def ray_of(self, pixel: int) -> Tuple[int, int]:
        """Row and ray of a pixel."""
        row, column = divmod(pixel, self.width)
        return row, column - (self.shifts[row] if self.shifts else 0)

    def pixel_of(self, row: int, ray: int) -> int:
        return row * self.width + ray + (self.shifts[row] if self.shifts else 0)

    @property
    def size(self) -> Tuple[int, int]:
        return self.width, self.height


@dataclass(frozen=True)
class ScanPoint:
    """A point of a pixel."""

    pixel: int
    """row * width + column."""
    depth: Optional[int]
    """None: at the sensor."""
    turn: int
    steps: Vector
    """From the ray; free: from the sensor."""
    symbol: Optional[int]
    colour: Optional[Colour]


@dataclass(frozen=True)
class Scan:
    """The points of a frame."""

    layout: ScanLayout
    points: List[ScanPoint]
    angles: List[int] = field(default_factory=list)
    """Of the columns of a spinning sensor."""
    fields: List[List[int]] = field(default_factory=list)
    """Of each field the numbers of all points."""

    def pasts(self, layout: ScanLayout, angles: List[int]) -> Dict[int, int]:
        """Depths by pixel for the next frame, with its layout and the angles of its
        columns."""
        depths = {p.pixel: p.depth for p in self.points if p.depth is not None}
        if angles == self.angles:
            return depths
        columns = self._nearest_columns(angles)
        pasts = {}
        for row in range(layout.height):
            for ray, nearest in enumerate(columns):
                depth = depths.get(self.layout.pixel_of(row, nearest))
                if depth is not None:
                    pasts[layout.pixel_of(row, ray)] = depth
        return pasts

    def _nearest_columns(self, angles: List[int]) -> List[int]:
        """The column for each of the next frame, which never go back."""
        own = self.angles
        columns = []
        p = 0
        for angle in angles:
            while p + 1 < len(own) and abs(own[p + 1] - angle) <= abs(own[p] - angle):
                p += 1
            columns.append(p)
        return columns

    def places(self, rays: ScanRays) -> List[Vector]:
        """Where the points are from the grid's lowest corner, edges in 2^-32."""
        places = Places(rays, self.angles)
        found = []
        for point in self.points:
            row, ray = self.layout.ray_of(point.pixel)
            found.append(places.place(ray, row, point.depth, point.turn, point.steps))
        return found


@dataclass(frozen=True)
class ScanMemory:
    """What is kept from frame to frame since the last I-frame."""

    before: Optional[Scan] = None
    """The last frame; None if that had no points."""
    models: Models = field(default_factory=Models)
    """Of fields."""
    fields: Tuple[FieldMemory, ...] = ()
    """One of each; none before the first frame with points."""


class _ScanReader:
    """Reads the planes of a frame one after the other."""

    def __init__(self, source: bytes, layout: ScanLayout) -> None:
        self._reader = ByteReader(source)
        self._layout = layout
        self._pixels: List[int] = []

    def read(self, before: Optional[Scan]) -> Tuple[Scan, bytes]:
        """The points without fields, and the bytes of these."""
        layout = self._layout
        if layout.shape == FREE:
            angles: List[int] = []
            depths, steps = self._free_points()
        else:
            has_steps = self._flag()
            angles = self._angles() if layout.shape == SPINNING else []
            pasts = None if before is None else before.pasts(layout, angles)
            depths, steps = self._depths_and_steps(has_steps, pasts)
        turns = len(self._pixels) * [0]
        if layout.shape == SPINNING and self._flag():
            turns = [number - NO_STEPS for number in self._values(NO_STEPS)]
        symbols: List[Optional[int]] = len(self._pixels) * [None]
        if layout.symbol_bits:
            symbols = [*self._values(0)]
            self._require_below(symbols, layout.symbol_bits)
        colours: List[Optional[Colour]] = len(self._pixels) * [None]
        if layout.colour_bits:
            colours = [*self._colours()]
        of_points = zip(self._pixels, depths, turns, steps, symbols, colours)
        points = [ScanPoint(*point) for point in of_points]
        return Scan(layout, points, angles), self._reader.rest()

    def _flag(self) -> bool:
        (flag,) = self._reader.numbers("B")
        require(flag <= 1, "a flag of the scan is neither 0 nor 1")
        return flag == 1

    def _plane(self) -> bytes:
        return self._reader.bytes(self._reader.varint())

    def _values(self, first: int) -> List[int]:
        return read_values(self._plane(), self._layout.size, self._pixels, first)

    def _read_depths(
        self, pasts: Optional[Dict[int, int]], may_have_beside: bool
    ) -> DepthReader:
        """Reads which pixels have points, too."""
        reader = DepthReader(self._plane(), self._layout.size, pasts, may_have_beside)
        reader.read()
        require(
            all(depth < _DEPTHS for depth in reader.depths.values()),
            "a depth is out of its range",
        )
        self._pixels = sorted([*reader.depths, *reader.at_sensor])
        rays = [self._layout.ray_of(pixel)[1] for pixel in self._pixels]
        require(
            all(0 <= ray < self._layout.ray_columns for ray in rays),
            "a point is in a pixel without a ray",
        )
        require(
            len(self._pixels) == self._layout.point_count,
            "other pixels than said have points",
        )
        return reader

    def _free_points(self) -> Tuple[List[Optional[int]], List[Vector]]:
        """Depths, all 0 but those of points at the sensor, and positions."""
        layout = self._layout
        depths: Dict[int, int]
        if layout.is_sequence:
            self._pixels = list(range(layout.point_count))
            depths = dict.fromkeys(self._pixels, 0)
        else:
            depths = self._read_depths(None, False).depths
            require(not any(depths.values()), "a point without a ray has a depth")
        away = [pixel for pixel in self._pixels if pixel in depths]
        positions = dict(zip(away, read_positions(self._plane(), layout.width, away)))
        steps = [positions.get(pixel, (0, 0, 0)) for pixel in self._pixels]
        return [depths.get(pixel) for pixel in self._pixels], steps

    def _depths_and_steps(
        self, has_steps: bool, pasts: Optional[Dict[int, int]]
    ) -> Tuple[List[Optional[int]], List[Vector]]:
        reader = self._read_depths(pasts, not has_steps)
        steps = [reader.beside.get(pixel, (0, 0, 0)) for pixel in self._pixels]
        if has_steps:
            x, y, z = (self._values(NO_STEPS) for _ in range(3))
            of_points = zip(x, y, z)
            steps = [(i - NO_STEPS, j - NO_STEPS, k - NO_STEPS) for i, j, k in of_points]
        require(
            all(abs(n) < MOST_STEPS for of_point in steps for n in of_point),
            "a point is too far beside its ray",
        )
        for pixel, of_point in zip(self._pixels, steps):
            require(
                pixel in reader.depths or not any(of_point),
                "a point at the sensor has steps",
            )
        return [reader.depths.get(pixel) for pixel in self._pixels], steps

    def _angles(self) -> List[int]:
        width = self._layout.ray_columns
        angles = []
        angle = 0
        numbers = read_values(self._plane(), (width, 1), range(width), NO_STEPS)
        for number in numbers:
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


def _read_fields(
    source: bytes, scan: Scan, models: Models, memory: Tuple[FieldMemory, ...]
) -> List[List[int]]:
    """The numbers of all fields; changes models and memory."""
    layout = scan.layout
    reader = NumberReader(source, layout.point_count, models)
    points = PixelPoints([point.pixel for point in scan.points], layout.width)
    numbers = [
        decode_field(reader, described, index, points, memory[index])
        for index, described in enumerate(layout.fields)
    ]
    reader.require_end()
    return numbers


def _require_full_rows(layout: ScanLayout) -> None:
    """Refuses a sequence whose points are not in all of its rows."""
    rows = -(-layout.point_count // layout.width)
    require(rows == layout.height, "a sequence has other rows than its points fill")
    require(
        rows > 1 or layout.width == layout.point_count, "the only row is not full"
    )


def decode_scan(
    source: bytes, layout: ScanLayout, is_i_frame: bool, memory: ScanMemory
) -> Tuple[Scan, ScanMemory]:
    """The points of a frame and the memory after it; `memory` stays as it is."""
    if is_i_frame:
        memory = ScanMemory()
    if layout.point_count == 0:
        require(not source, "a frame without points has a payload")
        return Scan(layout, []), replace(memory, before=None)
    if layout.is_sequence:
        _require_full_rows(layout)
    scan, rest = _ScanReader(source, layout).read(memory.before)
    if not layout.fields:
        require(not rest, "bytes are left behind the scan")
        return scan, replace(memory, before=scan)
    models = memory.models.copy()
    of_fields = memory.fields or tuple(FieldMemory() for _ in layout.fields)
    of_fields = tuple(of_field.copy() for of_field in of_fields)
    scan = replace(scan, fields=_read_fields(rest, scan, models, of_fields))
    return scan, ScanMemory(scan, models, of_fields)
