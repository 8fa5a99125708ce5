# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Input and output of a payload's coder.

doc/bitstream.md, "Payload".
"""

from dataclasses import dataclass, field, replace
from typing import Callable, List, Optional, Tuple

from depth_model import DepthModel
from invalid_frame import require

MOST_VOXELS = 1 << 20
"""Of a frame: this decoder's limit; the library has others."""

POINT_SYMBOL_BITS = 12
HIGHEST_POINT_SYMBOL = (1 << POINT_SYMBOL_BITS) - 1


@dataclass(frozen=True)
class CodedFrame:
    """What is known before the payload's coder begins."""

    is_i_frame: bool
    effort: int
    voxel_count: int
    symbol_bits: int
    """Of intensities, without these of point symbols; 0 without either."""
    depth: int
    depth_model: Optional[DepthModel]
    has_intensities: bool
    has_points: bool

    @property
    def highest_symbol(self) -> int:
        return (1 << self.symbol_bits) - 1

    def of_points(self) -> "CodedFrame":
        """The same frame with point symbols, where they are after intensities."""
        return replace(self, symbol_bits=POINT_SYMBOL_BITS, depth_model=None)


@dataclass(frozen=True)
class Voxels:
    """Occupied voxels: Morton keys, ascending, and what the content has of each."""

    keys: List[int]
    symbols: List[int]
    colours: List[Tuple[int, int, int]] = field(default_factory=list)
    point_counts: List[int] = field(default_factory=list)
    fields: List[List[int]] = field(default_factory=list)
    """Of each field the numbers of all points."""


def counts_of_symbols(symbols: List[int], excess: Callable[[], int]) -> List[int]:
    """Section "Numbers of points" of doc/bitstream.md."""
    counts = []
    for symbol in symbols:
        count = symbol
        if symbol == HIGHEST_POINT_SYMBOL:
            count += excess()
        require(1 <= count < 1 << 32, "a number of points is out of its range")
        counts.append(count)
    return counts
