# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What the stages of a payload of efforts 1 and 2 share (doc/bitstream_context.md)."""

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Set

from coded_frame import CodedFrame
from context_history import ContextHistory, Record, fraction_bits
from invalid_frame import require
from morton import neighbours
from range_coder import Choices, Kind, RangeDecoder

# Of the classes of section "New voxels".
_BY_NEIGHBOURS = (2, 16, 128, 512)
CELL_WEIGHTS = [w for w in _BY_NEIGHBOURS for _ in range(3)] + [*_BY_NEIGHBOURS, 256]
END_OF_BLOCK = 16


class LocalModels:
    """What section "Local expectation" learns."""

    def __init__(self) -> None:
        self.shares = [0] * 64
        self.errors = [1 << 14] * 64
        self.gains = [0, 0]

    def copy(self) -> "LocalModels":
        other = LocalModels()
        other.shares, other.errors = self.shares[:], self.errors[:]
        other.gains = self.gains[:]
        return other


class Kinds:
    """All kinds of decisions: the ways that the effort uses, and their shifts."""

    def __init__(self, effort: int) -> None:
        is_small = effort == 2
        self.tracked_voxel = Kind(2 if is_small else 1, 6)
        self.block = Kind(1, 5)
        self.cell = Choices(CELL_WEIGHTS)
        self.child = Kind(5 if is_small else 2, 5)
        self.symbol = Kind(4 if is_small else 2, 6)
        self.local = LocalModels()
        self.residual = Kind(3 if is_small else 1, 5)
        self.escape = Kind(1, 5)

    def copy(self) -> "Kinds":
        other = Kinds.__new__(Kinds)
        for name, kind in self.__dict__.items():
            setattr(other, name, kind.copy())
        return other


@dataclass
class Payload:
    """A payload being read, and the voxels found so far."""

    frame: CodedFrame
    bits: RangeDecoder
    kinds: Kinds
    history: ContextHistory
    tracked_cells: Dict[int, List[int]]
    occupied: Set[int] = field(default_factory=set)

    def neighbours(self, key: int) -> Sequence[Optional[int]]:
        return neighbours(key, self.frame.depth)

    def add(self, key: int) -> None:
        self.occupied.add(key)
        require(
            len(self.occupied) <= self.frame.voxel_count,
            "there are more voxels than the header says",
        )

    def mean_in_sixteenths(self, record: Record) -> int:
        """m of the description."""
        return record.mean << (4 - fraction_bits(self.frame.symbol_bits))

    def escape(self, most: int) -> int:
        """u of section "Residuals"; b is `most` at most."""
        b = 0
        while self.kinds.escape.read(self.bits, [b]):
            b += 1
            require(b <= most, "an escaped number has too many bits")
        return ((1 << b) | self.bits.bypass_bits(b)) - 1


def class_of(number: int, least: Sequence[int]) -> int:
    """How many of ascending numbers a number reaches."""
    return bisect_right(least, number)
