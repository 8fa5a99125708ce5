# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""What efforts 1 and 2 remember of the frames since the last one that replaced it.

doc/bitstream_context.md, "History"; the depth offset's learning is in "Residuals".
"""

from dataclasses import dataclass, field
from typing import Dict, List, NamedTuple

from morton import BLOCK_BITS


class SeenVoxel(NamedTuple):
    """What a frame says of an occupied voxel, for the history to learn."""

    base_symbol: int
    depth_offset: int
    """o of the description: 0 without a residual or without a depth model."""
    roughness: int
    """16 q of the description."""


class Record(NamedTuple):
    """What is remembered of a tracked voxel."""

    probability: int
    recent: int
    age: int
    mean: int
    deviation: int
    depth_offset: int
    roughness: int

    @property
    def age_class(self) -> int:
        return 0 if self.age < 2 else 1 if self.age < 5 else 2

    @property
    def was_in_last_frame(self) -> bool:
        return bool(self.recent & 1)


def fraction_bits(symbol_bits: int) -> int:
    """f: the bits after the point of a mean and of a deviation."""
    return min(4, 16 - symbol_bits)


def _one_frame_on(record: Record, is_occupied: bool) -> Record:
    age = record.age
    t = 1 if age < 2 else 2 if age < 5 else 3 if age < 10 else 4
    probability = record.probability
    if is_occupied:
        probability += (65535 - probability) >> t
    else:
        probability -= probability >> t
    return record._replace(
        probability=probability,
        recent=(2 * record.recent + is_occupied) % 256,
        age=min(age + 1, 31),
    )


def _with_seen(
    record: Record, seen: SeenVoxel, f: int, has_depth_model: bool
) -> Record:
    d = (seen.base_symbol << f) - record.mean
    record = record._replace(
        deviation=record.deviation + ((abs(d) - record.deviation) >> 2),
        mean=record.mean + (d >> 2),
    )
    if not has_depth_model:
        return record
    return record._replace(
        depth_offset=record.depth_offset
        + ((seen.depth_offset - record.depth_offset) >> 2),
        roughness=record.roughness + ((seen.roughness - record.roughness) >> 2),
    )


@dataclass
class ContextHistory:
    """Records by the voxels' keys, and activities by the blocks' keys."""

    records: Dict[int, Record] = field(default_factory=dict)
    activities: Dict[int, int] = field(default_factory=dict)

    def tracked_cells(self) -> Dict[int, List[int]]:
        """The tracked cells of each block, blocks and cells ascending."""
        cells: Dict[int, List[int]] = {}
        for key in sorted(self.records):
            cells.setdefault(key >> BLOCK_BITS, []).append(key & 63)
        return cells

    def after_frame(
        self,
        seen: Dict[int, SeenVoxel],
        is_replaced: bool,
        symbol_bits: int,
        has_depth_model: bool,
    ) -> "ContextHistory":
        """The history after a frame with these occupied voxels.

        is_replaced: it begins with the frame, and was empty before.
        """
        f = fraction_bits(symbol_bits)
        after = ContextHistory()
        for key, record in self.records.items():
            record = _one_frame_on(record, key in seen)
            if key in seen:
                record = _with_seen(record, seen[key], f, has_depth_model)
            if record.probability >= 1000:
                after.records[key] = record
        new_voxels: Dict[int, int] = {}
        for key, voxel in seen.items():
            if key in self.records:
                continue
            mean = voxel.base_symbol << f
            after.records[key] = Record(
                probability=52000 if is_replaced else 26000,
                recent=1,
                age=0,
                mean=mean,
                deviation=max(1 << f, mean >> 2),
                depth_offset=voxel.depth_offset,
                roughness=voxel.roughness,
            )
            block = key >> BLOCK_BITS
            new_voxels[block] = new_voxels.get(block, 0) + 1
        for block in {key >> BLOCK_BITS for key in after.records}:
            before = self.activities.get(block, 0 if is_replaced else 2)
            new = 0 if is_replaced else min(new_voxels.get(block, 0), 7)
            after.activities[block] = min((3 * before + 2 * new + 2) // 4, 7)
        return after
