# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Which voxels are occupied, with effort 0.

doc/bitstream_fast.md, "History".
"""

from dataclasses import dataclass
from typing import Container, Dict, List, Tuple

from coded_frame import CodedFrame
from fast_history import FastHistory, is_forgotten, next_past
from fast_models import FastModels
from invalid_frame import require
from morton import BLOCK_BITS, cells_of_block, levels_above_blocks
from rans import BitModel, RansDecoder, occupancy_table


@dataclass(frozen=True)
class FastOccupancy:
    """Occupied voxels, tracked ones and those that the frame brings, and what follows.

    `history` is the one after the frame, with the statistics of the one before.
    """

    tracked: List[int]
    brought: List[int]
    history: FastHistory


def ones(mask: int) -> List[int]:
    return [bit for bit in range(mask.bit_length()) if mask >> bit & 1]


def _beside(mask: int) -> int:
    """The cells of a block that share a face with one of a mask."""
    beside = 0
    for cell in ones(mask):
        for axis in (0b001001, 0b010010, 0b100100):
            place = cell & axis
            if place:
                beside |= 1 << ((place - 1) & axis | cell & ~axis)
            if place != axis:
                beside |= 1 << (((place | ~axis) + 1) & axis | cell & ~axis)
    return beside


def likely_first(likely: int, children: int) -> List[int]:
    """Children of a mask: the likely ones, then the others."""
    return ones(likely) + ones(children & ~likely)


_AXIS_BITS = [sum(4 >> axis << shift for shift in range(0, 63, 3)) for axis in range(3)]


def _below(node: int, axis: int) -> int:
    """The Morton key of the next node below on an axis; -1 if there is none."""
    bits = _AXIS_BITS[axis]
    place = node & bits
    return (place - 1) & bits | node & ~bits if place else -1


def _read_masks(
    rans: RansDecoder, models: FastModels, nodes: List[int]
) -> Dict[int, int]:
    """The children of the nodes of a level."""
    masks: Dict[int, int] = {}
    upper = dict.fromkeys(nodes, 0)
    for node in nodes:
        for axis in range(3):
            below = _below(node, axis)
            if below in upper:
                upper[below] |= 4 >> axis
    for node in nodes:
        likely = 0
        for axis, toward in enumerate((0b1111, 0b110011, 0b1010101)):
            step = 4 >> axis
            neighbour = masks.get(_below(node, axis), 0)
            likely |= neighbour >> step & toward
        masks[node] = models.node(rans, likely, upper[node])
    return masks


def read_new_blocks(
    rans: RansDecoder,
    models: FastModels,
    depth: int,
    voxel_count: int,
    known_blocks: Container[int],
) -> Dict[int, int]:
    """The mask of cells of each new block. Section "New blocks"."""
    nodes = [0]
    for level in range(levels_above_blocks(depth) + 2):
        masks = _read_masks(rans, models, nodes)
        require(all(masks.values()) or level == 0, "a node has no children")
        nodes = [8 * node + child for node in nodes for child in ones(masks[node])]
        require(len(nodes) <= voxel_count, "there are too many nodes")
    blocks: Dict[int, int] = {}
    for key in nodes:
        block = key >> BLOCK_BITS
        require(block not in known_blocks, "a new block is a known one")
        blocks[block] = blocks.get(block, 0) | 1 << (key & 63)
    return blocks


class HistoryUpdate:
    """The history after a frame, as its voxels become known."""

    def __init__(self, before: FastHistory) -> None:
        self._before = before
        self._after = FastHistory(
            shares=dict(before.shares), statistics=dict(before.statistics)
        )

    def move_on(self, past: int, occupied: List[int]) -> None:
        """The voxels of a bucket, in its order: which of them are occupied."""
        bucket = self._before.buckets[past]
        for key, bit in zip(bucket, occupied):
            new_past = next_past(past, bit)
            if is_forgotten(new_past):
                self._after.statistics.pop(key, None)
            else:
                self._after.buckets.setdefault(new_past, []).append(key)
        n, m = len(bucket), sum(occupied)
        share = self._before.share(past)
        self._after.shares[past] = (32 * share + 65535 * m) // (32 + n)

    def end(
        self, brought: List[int], renewed: Container[int], is_apart: bool
    ) -> FastHistory:
        """Voxels that were not tracked, and the tracked blocks among theirs."""
        first_past = 3 if is_apart else 1
        self._after.buckets.setdefault(first_past, []).extend(brought)
        tracked_before = self._before.tracked_cells()
        for block in self._after.tracked_cells():
            if block in tracked_before:
                activity = self._before.activities[block]
                self._after.activities[block] = (2 * activity + (block in renewed)) % 16
            else:
                self._after.activities[block] = 1
        return self._after


def history_with(before: FastHistory, keys: List[int]) -> FastHistory:
    """The history after a frame that was coded without it."""
    update = HistoryUpdate(before)
    occupied = set(keys)
    for past in sorted(before.buckets):
        if before.buckets[past]:
            update.move_on(past, [int(key in occupied) for key in before.buckets[past]])
    cells = before.tracked_cells()
    brought = [
        key for key in keys if not cells.get(key >> BLOCK_BITS, 0) >> (key & 63) & 1
    ]
    # Those of tracked blocks first.
    brought.sort(key=lambda key: key >> BLOCK_BITS not in cells)
    renewed = {key >> BLOCK_BITS for key in brought} & set(cells)
    return update.end(brought, renewed, False)


class FastOccupancyReader:
    """Reads tracked voxels, new voxels in tracked blocks and new blocks, in this order."""

    def __init__(
        self,
        rans: RansDecoder,
        frame: CodedFrame,
        models: FastModels,
        history: FastHistory,
        is_apart: bool,
    ) -> None:
        self._is_apart = is_apart
        """The frame is coded without the history, which is empty."""
        self._rans = rans
        self._frame = frame
        self._models = models
        self._history = history
        self._update = HistoryUpdate(history)
        self._tracked_cells = history.tracked_cells()
        self._occupied_cells = {block: 0 for block in self._tracked_cells}
        self._tracked: List[int] = []
        self._brought: List[int] = []

    def read(self) -> FastOccupancy:
        self._read_tracked_voxels()
        new_cells = self._read_new_voxels_in_tracked_blocks()
        for block in sorted(new_cells):
            self._bring(block, new_cells[block])
        new_blocks = read_new_blocks(
            self._rans,
            self._models,
            self._frame.depth,
            self._frame.voxel_count,
            self._tracked_cells,
        )
        for block, cells in new_blocks.items():
            self._bring(block, cells)
        require(
            len(self._tracked) + len(self._brought) == self._frame.voxel_count,
            "there are not as many voxels as the header says",
        )
        history = self._update.end(self._brought, set(new_cells), self._is_apart)
        return FastOccupancy(self._tracked, self._brought, history)

    def _bring(self, block: int, cells: int) -> None:
        keys = [block << BLOCK_BITS | cell for cell in ones(cells)]
        require(keys[-1] & 63 < cells_of_block(self._frame.depth), "a cell is outside")
        self._brought += keys

    # Tracked voxels

    def _read_tracked_voxels(self) -> None:
        for past in sorted(self._history.buckets):
            bucket = self._history.buckets[past]
            if not bucket:
                continue
            share = self._history.share(past)
            occupied = self._occupied_of(bucket, share)
            self._update.move_on(past, occupied)
            for key, bit in zip(bucket, occupied):
                if bit:
                    self._tracked.append(key)
                    self._occupied_cells[key >> BLOCK_BITS] |= 1 << (key & 63)

    def _occupied_of(self, bucket: List[int], share: int) -> List[int]:
        table = occupancy_table(share)
        occupied: List[int] = []
        for _ in range(len(bucket) // 8):
            byte = self._rans.symbol(table)
            occupied += [byte >> k & 1 for k in range(8)]
        rest = BitModel(share)
        occupied += [rest.read(self._rans) for _ in range(len(bucket) % 8)]
        return occupied

    # New voxels in tracked blocks

    def _read_new_voxels_in_tracked_blocks(self) -> Dict[int, int]:
        """The mask of new cells of each tracked block that has some."""
        in_one_octant: Dict[int, List[int]] = {}
        in_several: Dict[int, List[int]] = {}
        for block in self._tracked_cells:
            activity = self._history.activities[block]
            is_empty = self._occupied_cells[block] == 0
            symbol = self._models.nibble(self._rans, "octant", 2 * activity + is_empty)
            require(symbol <= 9, "a symbol of a block is none")
            if symbol == 9:
                in_several[block] = []
            elif symbol:
                likely = self._occupied_octants(block)
                in_one_octant[block] = [likely_first(likely, 255)[symbol - 1]]
        for block in in_several:
            likely = self._occupied_octants(block)
            octants = ones(self._models.mask(self._rans, "several", likely))
            require(len(octants) >= 2, "several octants are fewer than two")
            in_several[block] = octants
        new_octants = [
            (block, octant)
            for blocks in (in_one_octant, in_several)
            for block, octants in blocks.items()
            for octant in octants
        ]
        new_cells: Dict[int, int] = {}
        have_several = []
        for block, octant in new_octants:
            cell = self._single_cell(block, octant)
            if cell < 0:
                have_several.append((block, octant))
            else:
                new_cells[block] = new_cells.get(block, 0) | 1 << cell
        for block, octant in have_several:
            _, likely = self._open_and_likely(block, octant)
            cells = self._models.mask(self._rans, "several", likely)
            require(cells.bit_count() >= 2, "several voxels are fewer than two")
            cells <<= 8 * octant
            require(not cells & self._tracked_cells[block], "a new voxel is a tracked one")
            new_cells[block] = new_cells.get(block, 0) | cells
        return new_cells

    def _occupied_octants(self, block: int) -> int:
        occupied = self._occupied_cells[block]
        return sum(1 << o for o in range(8) if occupied >> 8 * o & 255)

    def _open_and_likely(self, block: int, octant: int) -> Tuple[int, int]:
        """The open cells of an octant, and those of them that are likely."""
        open_cells = ~self._tracked_cells[block] >> 8 * octant & 255
        return open_cells, open_cells & _beside(self._occupied_cells[block]) >> 8 * octant

    def _single_cell(self, block: int, octant: int) -> int:
        """The only new cell of an octant; -1 if there are several."""
        open_cells, likely = self._open_and_likely(block, octant)
        count = open_cells.bit_count()
        c = 0 if count == 8 else 1 if count > 4 else 2
        rank = self._models.nibble(
            self._rans, "cell", 3 * min(likely.bit_count(), 3) + c
        )
        if rank == 8:
            return -1
        require(rank < count, "a new voxel is in none of the open cells")
        return 8 * octant + likely_first(likely, open_cells)[rank]
