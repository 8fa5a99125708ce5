# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The voxels of a payload of efforts 1 and 2.

Sections "Tracked voxels", "New voxels", "New blocks" and "Children" of
doc/bitstream_context.md.
"""

from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

from context_frame import CELL_WEIGHTS, END_OF_BLOCK, Payload, class_of
from context_history import Record, fraction_bits
from invalid_frame import require
from morton import BLOCK_BITS, cells_of_block, levels_above_blocks, neighbours


class _TrackedVoxels:
    """Section "Tracked voxels"."""

    def __init__(self, payload: Payload) -> None:
        self._payload = payload
        self._f = fraction_bits(payload.frame.symbol_bits)
        self._coded: Dict[int, int] = {}

    def read(self) -> None:
        payload = self._payload
        for block, cells in payload.tracked_cells.items():
            for cell in cells:
                key = block << BLOCK_BITS | cell
                record = payload.history.records[key]
                bit = payload.kinds.tracked_voxel.read(
                    payload.bits,
                    self._contexts(key, record),
                    (record.probability >> 13) * 3 + record.age_class,
                )
                self._coded[key] = bit
                if bit:
                    payload.add(key)

    def _contexts(self, key: int, record: Record) -> List[int]:
        p, r, g = record.probability, record.recent, record.age_class
        c = class_of(record.mean >> max(self._f - 2, 0), (6, 8, 12, 20))
        before = came = went = 0
        for neighbour in self._payload.neighbours(key):
            other = self._payload.history.records.get(neighbour)
            if other is None:
                continue
            before += other.was_in_last_frame
            if neighbour in self._coded:
                is_occupied = self._coded[neighbour]
                came += bool(is_occupied and not other.was_in_last_frame)
                went += bool(not is_occupied and other.was_in_last_frame)
        changes = 3 * min(came, 2) + min(went, 2)
        return [
            (((p >> 12) * 7 + before) * 9 + changes) * 2 + r % 2,
            (((p >> 11) * 4 + r % 4) * 3 + g) * 5 + c,
        ]


class _Level:
    """The nodes of one height while they are asked about: section "Children"."""

    def __init__(self, payload: Payload, height: int, present: Set[int]) -> None:
        self._payload = payload
        self._levels = payload.frame.depth - height
        self._present = present
        self._found: Set[int] = set()
        self._pending_parents: Set[int] = set()

    def read(
        self, parents: Sequence[int], candidates: Callable[[int], List[int]]
    ) -> List[int]:
        """The children of some nodes that have what is asked for."""
        self._pending_parents = set(parents)
        found: List[int] = []
        for parent in parents:
            found += self._children(candidates(parent))
            self._pending_parents.remove(parent)
            require(
                len(found) <= self._payload.frame.voxel_count,
                "there are more nodes than voxels",
            )
        return found

    def _children(self, candidates: List[int]) -> List[int]:
        require(candidates, "a node has no candidates")
        found: List[int] = []
        for place, child in enumerate(candidates):
            left = len(candidates) - place - 1
            if left or found:
                contexts, f = self._contexts(child, len(found), left)
                if not self._payload.kinds.child.read(self._payload.bits, contexts, f):
                    continue
            found.append(child)
            self._found.add(child)
        return found

    def _state(self, node: Optional[int]) -> int:
        """3 present, 2 pending, 0 absent."""
        if node is None:
            return 0
        if node in self._present or node in self._found:
            return 3
        return 2 if node >> 3 in self._pending_parents else 0

    def _contexts(self, child: int, n: int, left: int) -> Tuple[List[int], int]:
        c = child & 7
        faces = [axis + 3 * (c >> (2 - axis) & 1) for axis in range(3)]

        def beside(*axes: int) -> Optional[int]:
            """The node outside the parent on these axes."""
            node: Optional[int] = child
            for axis in axes:
                if node is not None:
                    node = neighbours(node, self._levels)[faces[axis]]
            return node

        states = []
        for axis in range(3):
            state = self._state(beside(axis))
            if state == 0 and self._has_wall(child, axis, faces[axis]):
                state = 1
            states.append(state)
        s = sum(
            (state >> 1) << (5 - axis) | (state & 1) << (2 - axis)
            for axis, state in enumerate(states)
        )
        first = child & ~7
        q = (1 << c) + sum(
            1 << (node & 7) for node in range(first, child) if self._state(node) == 3
        )
        a = sum(axis for axis in (4, 2, 1) if self._is_present(child ^ axis))
        f = states.count(3) + a.bit_count()
        u = states.count(2)
        candidate = min(6 + n, 8) if n else 7 - left
        e = 0
        for axes in ((0, 1), (0, 2), (1, 2), (0, 1, 2)):
            e = 2 * e + (self._state(beside(*axes)) > 0)
        contexts = [
            256 * s + q,
            ((4 * f + u) * 9 + candidate) * 2 + (child in self._present),
            (8 * s + a) * 3 + min(n, 2),
            (16 * s + e) * 8 + c,
            q,
        ]
        return contexts, f

    def _is_present(self, node: int) -> bool:
        return node in self._present or node in self._found

    def _has_wall(self, child: int, axis: int, face: int) -> bool:
        """Is one of the four nodes present that share the parent's face on a side?"""
        bit = 4 >> axis
        for sibling in range(child & ~7, (child & ~7) + 8):
            if sibling & bit != child & bit:
                continue
            node = neighbours(sibling, self._levels)[face]
            if node is not None and self._is_present(node):
                return True
        return False


def _read_new_voxels(payload: Payload) -> None:
    """Section "New voxels"."""
    cell_count = cells_of_block(payload.frame.depth)
    for block, cells in payload.tracked_cells.items():
        if len(cells) == cell_count:
            continue
        k = class_of(len(cells), (4, 10, 20))
        context = 4 * payload.history.activities[block] + k
        if payload.kinds.block.read(payload.bits, [context]):
            _read_cells(payload, block, sorted(set(range(cell_count)) - set(cells)))


def _read_cells(payload: Payload, block: int, open_cells: List[int]) -> None:
    """The new voxels of a tracked block that has some."""
    last: Optional[int] = None
    while open_cells:
        classes: List[List[int]] = [[] for _ in CELL_WEIGHTS]
        for cell in open_cells:
            around = payload.neighbours(block << BLOCK_BITS | cell)
            f = min(sum(key in payload.occupied for key in around), 3)
            g = min(sum(key in payload.history.records for key in around), 2)
            is_near = last is not None and cell <= last + 3
            classes[12 + f if is_near else 3 * f + g].append(cell)
        if last is not None:
            classes[END_OF_BLOCK].append(-1)
        counts = [len(cells) for cells in classes]
        chosen, place = payload.kinds.cell.read(payload.bits, counts)
        if chosen == END_OF_BLOCK:
            return
        last = classes[chosen][place]
        payload.add(block << BLOCK_BITS | last)
        open_cells = [cell for cell in open_cells if cell > last]


def _read_blocks(payload: Payload) -> List[int]:
    """Step 1 of "New blocks"."""
    if not payload.bits.bypass_bit():
        return []
    depth = payload.frame.depth
    tracked = payload.tracked_cells
    if levels_above_blocks(depth) == 0:
        require(0 not in tracked, "the only block is no new one")
        return [0]
    nodes = [0]
    for height in range(depth - 1, 1, -1):
        present = {block >> 3 * (height - 2) for block in tracked}

        def candidates(parent: int, height: int = height) -> List[int]:
            children = range(8 * parent, 8 * parent + 8)
            return [c for c in children if height > 2 or c not in tracked]

        nodes = _Level(payload, height, present).read(nodes, candidates)
    return nodes


def _read_new_blocks(payload: Payload) -> None:
    """Section "New blocks"."""
    octant_count = cells_of_block(payload.frame.depth) // 8
    present = {key >> 3 for key in payload.occupied}
    octants = _Level(payload, 1, present).read(
        _read_blocks(payload),
        lambda block: list(range(8 * block, 8 * block + octant_count)),
    )
    voxels = _Level(payload, 0, set(payload.occupied)).read(
        octants, lambda octant: list(range(8 * octant, 8 * octant + 8))
    )
    for key in voxels:
        payload.add(key)


def read_voxels(payload: Payload) -> List[int]:
    """The keys of all voxels, ascending."""
    _TrackedVoxels(payload).read()
    _read_new_voxels(payload)
    _read_new_blocks(payload)
    require(
        len(payload.occupied) == payload.frame.voxel_count,
        "there are fewer voxels than the header says",
    )
    return sorted(payload.occupied)
