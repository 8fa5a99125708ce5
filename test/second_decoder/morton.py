# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Morton keys, their neighbours and blocks.

doc/bitstream.md, "What a frame says"; doc/bitstream_context.md, beginning.
"""

from functools import lru_cache
from typing import Optional, Tuple

BLOCK_BITS = 6
"""Bits of a key that are a voxel's cell; those above are its block's key."""

_EVERY_THIRD = sum(1 << (3 * level) for level in range(21))
_AXES = (_EVERY_THIRD << 2, _EVERY_THIRD << 1, _EVERY_THIRD)
"""Bits of a key that belong to x, y and z."""

Neighbours = Tuple[Optional[int], ...]


@lru_cache(maxsize=1 << 16)
def position(key: int) -> Tuple[int, int, int]:
    """A voxel's position in the grid."""
    x = y = z = 0
    for level in range(21):
        child = key >> (3 * level)
        x |= (child >> 2 & 1) << level
        y |= (child >> 1 & 1) << level
        z |= (child & 1) << level
    return x, y, z


@lru_cache(maxsize=1 << 16)
def neighbours(key: int, depth: int) -> Neighbours:
    """Keys across the faces -x, -y, -z, +x, +y, +z; None outside the grid."""
    grid = (1 << (3 * depth)) - 1
    below, above = [], []
    for all_levels in _AXES:
        axis = all_levels & grid
        others = key & ~axis
        place = key & axis
        below.append((place - 1) & axis | others if place else None)
        above.append(((place | ~axis) + 1) & axis | others if place != axis else None)
    return tuple(below + above)


def cells_of_block(depth: int) -> int:
    """How many of a block's cells lie in the grid: a grid of depth 1 is octant 0."""
    return 8 if depth == 1 else 64


def levels_above_blocks(depth: int) -> int:
    """L of the payloads' descriptions."""
    return max(depth - 2, 0)
