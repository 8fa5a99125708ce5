# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What a point is worth where intensities depend on the depth in a sensor's frame.

doc/bitstream.md, "Depth model".
"""

from dataclasses import dataclass
from typing import Tuple

from byte_reader import ByteReader
from invalid_frame import require
from morton import position


@dataclass(frozen=True)
class DepthModel:
    """Relative depths in 2^-32, the symbol of a share of 1 in 2^-8."""

    exponent: int
    full_symbol: int
    origin: int
    step: Tuple[int, int, int]

    def point_at_centre(self, key: int) -> int:
        """c: what a point at a voxel's centre adds to its symbol, in 2^-16."""
        depth = self.origin + sum(s * p for s, p in zip(self.step, position(key)))
        r = min(max(depth, 0), 1 << 32) >> 8
        share = r if self.exponent == 1 else r * r >> 24
        return share * self.full_symbol >> 16


def read_depth_model(reader: ByteReader) -> DepthModel:
    """The model at the beginning of a payload."""
    exponent, full_symbol, origin, *step = reader.numbers("BIq3i")
    require(exponent in (1, 2), "the depth model's exponent is unknown")
    require(full_symbol < 1 << 24, "the depth model's full symbol is too large")
    require(-(1 << 56) <= origin <= 1 << 56, "the depth model's origin is too far away")
    return DepthModel(exponent, full_symbol, origin, (step[0], step[1], step[2]))


def point_with_offset(at_centre: int, depth_offset: int) -> int:
    """w: what a point is worth in a voxel of that depth offset, in 2^-16."""
    return at_centre * ((1 << 14) + depth_offset) >> 14


def has_residual(point: int) -> bool:
    """Whether a voxel has a residual besides its number of points."""
    return point >= 1 << 16


def predicted_symbol(exact: int, highest_symbol: int) -> int:
    """The symbol that an exact one, in 2^-16, is rounded to."""
    return min((exact + (1 << 15)) >> 16, highest_symbol)
