# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The cloud of a scan: positions of its points, and their order.

doc/bitstream_scan.md, "Positions" and "Order of the cloud".
"""

from dataclasses import dataclass, field
from typing import List, Sequence, Tuple

from frame_header import Grid
from scan import Colour, Scan
from scan_header import COLUMN_BY_COLUMN, ORGANISED, ScanTable, Vector
from scan_rays import ScanRays

Position = Tuple[float, float, float]


@dataclass(frozen=True)
class CloudPoints:
    """The points of a cloud, in its order."""

    width: int
    height: int
    indices: List[int]
    """Of each point, row * width + column of the cloud."""
    positions: List[Position]
    symbols: List[int] = field(default_factory=list)
    colours: List[Colour] = field(default_factory=list)
    fields: List[List[int]] = field(default_factory=list)
    """Of each field the numbers of all points."""


def _coordinate(place: int, axis: int, grid: Grid, is_on_lattice: bool) -> float:
    first, origin = grid.first_index[axis], grid.origin[axis]
    edges = float(place >> 32) + 0.5 if is_on_lattice else 2.0**-32 * float(place)
    return (float(first) + edges) * grid.resolution + origin


def _position(place: Vector, grid: Grid, is_on_lattice: bool) -> Position:
    x, y, z = (_coordinate(place[i], i, grid, is_on_lattice) for i in range(3))
    return x, y, z


def _order(scan: Scan, table: ScanTable) -> List[int]:
    """The points in the order of the cloud, as indices of those of the scan."""
    order = list(range(len(scan.points)))
    if table.order == COLUMN_BY_COLUMN:
        ranks = {row: rank for rank, row in enumerate(table.firing_order)}

        def place(point: int) -> Tuple[int, int]:
            row, ray = scan.layout.ray_of(scan.points[point].pixel)
            return ray, ranks[row]

        order.sort(key=place)
    return order


def _of_points(order: Sequence[int], numbers: List[int], size: int) -> List[int]:
    return [n for i in order for n in numbers[size * i : size * (i + 1)]]


def cloud_of(
    scan: Scan, table: ScanTable, grid: Grid, value_counts: Sequence[int]
) -> CloudPoints:
    """The cloud of a scan, whose fields have so many values of a point."""
    pixels = [point.pixel for point in scan.points]
    order = _order(scan, table)
    points = [scan.points[i] for i in order]
    placement = table.placement
    rays = ScanRays(
        table.shape,
        placement.pose,
        placement.motion,
        table.has_half_depths,
        table.turns,
        table.rows,
    )
    places = scan.places(rays)
    is_organised = table.order == ORGANISED
    return CloudPoints(
        table.width if is_organised else len(points),
        table.height if is_organised else 1,
        pixels if is_organised else list(range(len(points))),
        [_position(places[i], grid, table.is_on_lattice) for i in order],
        [point.symbol for point in points if point.symbol is not None],
        [point.colour for point in points if point.colour is not None],
        [
            _of_points(order, numbers, size)
            for numbers, size in zip(scan.fields, value_counts)
        ],
    )
