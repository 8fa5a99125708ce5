# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Frames of changes, and the last frame that they refer to.

doc/bitstream_changes.md.
"""

from dataclasses import dataclass, field, replace
from typing import Dict, List, Tuple

from coded_frame import Voxels
from fast_models import FastModels
from fast_occupancy import likely_first, ones, read_new_blocks
from invalid_frame import require
from morton import BLOCK_BITS, cells_of_block
from supplement import Models, NumberReader, ResidualReader


@dataclass(frozen=True)
class Block:
    """What is known of a block besides its voxels."""

    recently_changed: int = 0
    change_history: int = 0


@dataclass(frozen=True)
class ChangesMemory:
    """The last frame, and the models since the last I-frame."""

    symbols: Dict[int, int] = field(default_factory=dict)
    """By the keys of the voxels; 0 without intensities."""
    blocks: Dict[int, Block] = field(default_factory=dict)
    """Also those that lately had voxels."""
    masks: FastModels = field(default_factory=FastModels)
    numbers: Models = field(default_factory=Models)
    may_follow: bool = False

    def after_whole(self, voxels: Voxels, is_i_frame: bool) -> "ChangesMemory":
        """The memory after a frame that is not one of changes."""
        start = ChangesMemory() if is_i_frame else self
        symbols = voxels.symbols or len(voxels.keys) * [0]
        return replace(
            start,
            symbols=dict(zip(voxels.keys, symbols)),
            blocks={key >> BLOCK_BITS: Block() for key in voxels.keys},
            may_follow=True,
        )


def _octants(cells: int) -> int:
    return sum(1 << octant for octant in range(8) if cells >> 8 * octant & 255)


class ChangesReader:
    """Reads one frame of changes."""

    def __init__(
        self, payload: bytes, depth: int, bits: int, voxel_count: int, memory: ChangesMemory
    ) -> None:
        self._depth = depth
        self._bits = bits
        self._voxel_count = voxel_count
        self._memory = memory
        self._masks = memory.masks.copy()
        # One state.
        self._reader = NumberReader(payload, 1, memory.numbers.copy())
        self._occupied = {block: 0 for block in memory.blocks}
        for key in memory.symbols:
            self._occupied[key >> BLOCK_BITS] |= 1 << (key & 63)

    def read(self) -> Tuple[Voxels, ChangesMemory]:
        changed = self._read_changed_cells()
        new = read_new_blocks(
            self._reader.rans,
            self._masks,
            self._depth,
            self._voxel_count,
            self._memory.blocks,
        )
        for block, cells in new.items():
            self._require_inside(cells)
            changed[block] = cells
        symbols = self._read_symbols(changed)
        self._reader.require_end()
        require(
            len(symbols) == self._voxel_count,
            "there are not as many voxels as the header says",
        )
        blocks = self._next_blocks(changed, symbols)
        memory = ChangesMemory(
            symbols, blocks, self._masks, self._reader.models, may_follow=True
        )
        keys = list(symbols)
        return Voxels(keys, list(symbols.values()) if self._bits else []), memory

    def _require_inside(self, cells: int) -> None:
        inside = cells_of_block(self._depth)
        require(cells.bit_length() <= inside, "a cell is outside")

    # Sections "Octants" and "Cells"

    def _read_changed_cells(self) -> Dict[int, int]:
        """The changed cells of the blocks that have some."""
        octant_symbols = {}
        for block in sorted(self._memory.blocks):
            change_history = self._memory.blocks[block].change_history
            context = 4 * min((change_history >> 2).bit_count(), 3) + change_history % 4
            symbol = self._masks.nibble(self._reader.rans, "octant", context)
            require(symbol <= 9, "a symbol of a block is none")
            if symbol:
                octant_symbols[block] = symbol
        return {
            block: self._read_cells(block, symbol)
            for block, symbol in octant_symbols.items()
        }

    def _read_cells(self, block: int, symbol: int) -> int:
        occupied = self._occupied[block]
        recently_changed = self._memory.blocks[block].recently_changed
        likely = _octants(occupied | recently_changed)
        if symbol < 9:
            octants = [likely_first(likely, 255)[symbol - 1]]
        else:
            octants = ones(self._masks.mask(self._reader.rans, "several", likely))
            require(len(octants) >= 2, "several octants are fewer than two")
        changed = 0
        for octant in octants:
            near = recently_changed >> 8 * octant & 255 or occupied >> 8 * octant & 255
            rank = self._masks.nibble(self._reader.rans, "cell", near.bit_count())
            require(rank <= 8, "a symbol of an octant is none")
            if rank < 8:
                cells = 1 << likely_first(near, 255)[rank]
            else:
                cells = self._masks.mask(self._reader.rans, "several", near)
                require(cells.bit_count() >= 2, "several cells are fewer than two")
            changed |= cells << 8 * octant
        self._require_inside(changed)
        return changed

    # Section "Symbols"

    def _read_symbols(self, changed: Dict[int, int]) -> Dict[int, int]:
        """The symbols of the frame by the keys of its voxels, ascending."""
        keys = {
            block << BLOCK_BITS | cell
            for block, cells in changed.items()
            for cell in ones(cells)
        }
        highest = (1 << self._bits) - 1
        appeared = ResidualReader(self._reader, highest, "appeared")
        symbols: Dict[int, int] = {}
        last = 0
        for key in sorted(keys | set(self._memory.symbols)):
            before = self._memory.symbols.get(key)
            if key not in keys:
                assert before is not None
                symbols[key] = before
            elif before is not None:
                after = self._changed_symbol(key, before, highest)
                if after < 0:
                    continue
                symbols[key] = after
            else:
                symbols[key] = appeared.value(last) if self._bits else 0
            last = symbols[key]
        return symbols

    def _changed_symbol(self, key: int, before: int, highest: int) -> int:
        """What a symbol changes to; -1 if the voxel vanishes."""
        if not self._bits:
            return -1
        recently_changed = self._memory.blocks[key >> BLOCK_BITS].recently_changed
        number = self._reader.number("change", recently_changed >> (key & 63) & 1)
        if number == 0:
            return -1
        change = (number + 1) // 2 if number % 2 else -(number // 2)
        require(0 <= before + change <= highest, "a symbol is none")
        return before + change

    # Section "Last frame"

    def _next_blocks(
        self, changed: Dict[int, int], symbols: Dict[int, int]
    ) -> Dict[int, Block]:
        occupied: Dict[int, int] = {}
        for key in symbols:
            block = key >> BLOCK_BITS
            occupied[block] = occupied.get(block, 0) | 1 << (key & 63)
        blocks: Dict[int, Block] = {}
        for block in sorted(set(self._memory.blocks) | set(changed)):
            old = self._memory.blocks.get(block, Block())
            change_history = (2 * old.change_history + (block in changed)) % 256
            other = self._occupied.get(block, 0) ^ occupied.get(block, 0)
            if change_history or block in occupied:
                recently_changed = old.recently_changed | other if change_history else 0
                blocks[block] = Block(recently_changed, change_history)
        return blocks


def decode_changes(
    payload: bytes, depth: int, bits: int, voxel_count: int, memory: ChangesMemory
) -> Tuple[Voxels, ChangesMemory]:
    """The voxels of a frame of changes and the memory after it; `memory` stays as it is."""
    require(memory.may_follow, "a frame of changes refers to no frame")
    require(voxel_count > 0, "a frame of changes has no voxels")
    return ChangesReader(payload, depth, bits, voxel_count, memory).read()
