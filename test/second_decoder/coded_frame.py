"""Input and output of a payload's coder.

doc/bitstream.md, "Payload".
"""

from dataclasses import dataclass, field
from typing import List, Optional, Tuple

from depth_model import DepthModel

MOST_VOXELS = 1 << 20
"""Of a frame: this decoder's limit, and the library's default."""


@dataclass(frozen=True)
class CodedFrame:
    """What is known before the payload's coder begins."""

    is_i_frame: bool
    effort: int
    voxel_count: int
    symbol_bits: int
    depth: int
    depth_model: Optional[DepthModel]

    @property
    def highest_symbol(self) -> int:
        return (1 << self.symbol_bits) - 1


@dataclass(frozen=True)
class Voxels:
    """Occupied voxels: Morton keys, ascending, and what the content has of each."""

    keys: List[int]
    symbols: List[int]
    colours: List[Tuple[int, int, int]] = field(default_factory=list)
    point_counts: List[int] = field(default_factory=list)
