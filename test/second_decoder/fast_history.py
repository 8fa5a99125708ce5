# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What effort 0 remembers of voxels and blocks since the last I-frame.

doc/bitstream_fast.md, "History", and "Statistics" in "Symbols".
"""

from dataclasses import dataclass, field
from typing import Dict, List, NamedTuple

from morton import BLOCK_BITS


class Statistics(NamedTuple):
    """Mean, in eighths of a bin, and deviation of a voxel's bins."""

    mean: int
    deviation: int

    @staticmethod
    def of_first(bin_index: int) -> "Statistics":
        return Statistics(8 * bin_index, 8 + bin_index if bin_index < 32 else 40)

    def after(self, bin_index: int) -> "Statistics":
        d = 8 * bin_index - self.mean
        a = min(abs(d), 63)
        return Statistics(
            self.mean + ((d + 2) >> 2), self.deviation + ((a - self.deviation + 2) >> 2)
        )


def first_share(past: int) -> int:
    """The share of a past at the start, in 2^-16."""
    share = 26000
    below_leading = bin(past)[3:]
    for place, bit in enumerate(below_leading):
        t = 1 if place < 2 else 2
        share += ((65535 if bit == "1" else 0) - share) >> t
    return share


def next_past(past: int, is_occupied: int) -> int:
    """A past one frame on."""
    q = 2 * past + is_occupied
    return 128 + q % 128 if past >= 128 else q


def is_forgotten(past: int) -> bool:
    return past >= 64 and past % 64 == 0


@dataclass
class FastHistory:
    """Buckets by past, shares by past, statistics of symbols and of point symbols
    after intensities by key, activities by block."""

    buckets: Dict[int, List[int]] = field(default_factory=dict)
    shares: Dict[int, int] = field(default_factory=dict)
    statistics: Dict[int, Statistics] = field(default_factory=dict)
    point_statistics: Dict[int, Statistics] = field(default_factory=dict)
    activities: Dict[int, int] = field(default_factory=dict)

    def share(self, past: int) -> int:
        return self.shares.get(past, first_share(past))

    def kept_point_statistics(self, before: "FastHistory") -> Dict[int, Statistics]:
        """Those of the history before the frame, of voxels that still have some."""
        return {
            key: before.point_statistics[key]
            for key in self.statistics
            if key in before.point_statistics
        }

    def tracked_cells(self) -> Dict[int, int]:
        """The mask of tracked cells of each block, ascending."""
        masks: Dict[int, int] = {}
        for key in sorted(key for bucket in self.buckets.values() for key in bucket):
            block = key >> BLOCK_BITS
            masks[block] = masks.get(block, 0) | 1 << (key & 63)
        return masks
