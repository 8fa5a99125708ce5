"""The payload of efforts 1 and 2.

doc/bitstream_context.md; each class of this file holds one of its sections.
"""

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

from coded_frame import (
    MOST_VOXELS,
    POINT_SYMBOL_BITS,
    CodedFrame,
    Voxels,
    counts_of_symbols,
)
from context_history import ContextHistory, Record, SeenVoxel, fraction_bits
from depth_model import has_residual, point_with_offset, predicted_symbol
from frame_header import from_zigzag
from invalid_frame import require
from morton import (
    BLOCK_BITS,
    cells_of_block,
    levels_above_blocks,
    neighbours,
    node_at,
    position,
)
from range_coder import Choices, Kind, RangeDecoder


# Of the classes of section "New voxels".
_BY_NEIGHBOURS = (2, 16, 128, 512)
_CELL_WEIGHTS = [w for w in _BY_NEIGHBOURS for _ in range(3)] + [*_BY_NEIGHBOURS, 256]
_END_OF_BLOCK = 16


class Kinds:
    """All kinds of decisions: the ways that the effort uses, and their shifts."""

    def __init__(self, effort: int) -> None:
        is_small = effort == 2
        self.tracked_voxel = Kind(2 if is_small else 1, 6)
        self.block = Kind(1, 5)
        self.cell = Choices(_CELL_WEIGHTS)
        self.child = Kind(5 if is_small else 2, 5)
        self.symbol = Kind(4 if is_small else 2, 6)
        self.residual = Kind(3 if is_small else 1, 5)
        self.escape = Kind(1, 5)

    def copy(self) -> "Kinds":
        other = Kinds.__new__(Kinds)
        for name, kind in self.__dict__.items():
            setattr(other, name, kind.copy())
        return other


@dataclass(frozen=True)
class ContextMemory:
    """What is kept from frame to frame since the last I-frame."""

    history: ContextHistory
    kinds: Kinds
    point_history: ContextHistory
    point_kinds: Kinds
    """Of point symbols after intensities."""

    @staticmethod
    def at_start(effort: int) -> "ContextMemory":
        return ContextMemory(
            ContextHistory(), Kinds(effort), ContextHistory(), Kinds(effort)
        )


@dataclass
class _Payload:
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


def _class_of(number: int, least: Sequence[int]) -> int:
    """How many of ascending numbers a number reaches."""
    return bisect_right(least, number)


class _TrackedVoxels:
    """Section "Tracked voxels"."""

    def __init__(self, payload: _Payload) -> None:
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
        c = _class_of(record.mean >> max(self._f - 2, 0), (6, 8, 12, 20))
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

    def __init__(self, payload: _Payload, height: int, present: Set[int]) -> None:
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
        here = position(child)
        c = child & 7
        sides = [1 if c >> (2 - axis) & 1 else -1 for axis in range(3)]

        def beside(*axes: int) -> Optional[int]:
            """The node outside the parent on these axes."""
            place = [here[i] + (sides[i] if i in axes else 0) for i in range(3)]
            return node_at((place[0], place[1], place[2]), self._levels)

        states = []
        for axis in range(3):
            state = self._state(beside(axis))
            if state == 0 and self._has_wall(child, axis, sides[axis]):
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

    def _has_wall(self, child: int, axis: int, side: int) -> bool:
        """Is one of the four nodes present that share the parent's face on a side?"""
        bit = 4 >> axis
        for sibling in range(child & ~7, (child & ~7) + 8):
            if sibling & bit != child & bit:
                continue
            place = list(position(sibling))
            place[axis] += side
            node = node_at((place[0], place[1], place[2]), self._levels)
            if node is not None and self._is_present(node):
                return True
        return False


def _read_new_voxels(payload: _Payload) -> None:
    """Section "New voxels"."""
    cell_count = cells_of_block(payload.frame.depth)
    for block, cells in payload.tracked_cells.items():
        if len(cells) == cell_count:
            continue
        k = _class_of(len(cells), (4, 10, 20))
        context = 4 * payload.history.activities[block] + k
        if payload.kinds.block.read(payload.bits, [context]):
            _read_cells(payload, block, sorted(set(range(cell_count)) - set(cells)))


def _read_cells(payload: _Payload, block: int, open_cells: List[int]) -> None:
    """The new voxels of a tracked block that has some."""
    last: Optional[int] = None
    while open_cells:
        classes: List[List[int]] = [[] for _ in _CELL_WEIGHTS]
        for cell in open_cells:
            around = payload.neighbours(block << BLOCK_BITS | cell)
            f = min(sum(key in payload.occupied for key in around), 3)
            g = min(sum(key in payload.history.records for key in around), 2)
            is_near = last is not None and cell <= last + 3
            classes[12 + f if is_near else 3 * f + g].append(cell)
        if last is not None:
            classes[_END_OF_BLOCK].append(-1)
        counts = [len(cells) for cells in classes]
        chosen, place = payload.kinds.cell.read(payload.bits, counts)
        if chosen == _END_OF_BLOCK:
            return
        last = classes[chosen][place]
        payload.add(block << BLOCK_BITS | last)
        open_cells = [cell for cell in open_cells if cell > last]


def _read_blocks(payload: _Payload) -> List[int]:
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


def _read_new_blocks(payload: _Payload) -> None:
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


def _octave_class(x: int, n: int) -> int:
    """class(x, n) of section "Numbers"."""
    if x < 4:
        return x
    h = x.bit_length() - 1
    return min(4 * (h - 1) + (x >> (h - 2)) % 4, n - 1)


def _first_node(length: int) -> int:
    """first of section "Numbers"."""
    return (1 << length) // 2 if length < 5 else 16 * (min(length, 8) - 4)


class _BaseSymbols:
    """Section "Numbers"."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._effort = payload.frame.effort
        self._to_sixteenths = 4 - fraction_bits(payload.frame.symbol_bits)
        self._running = 16
        self._error = 64
        self._shortest = 0

    def read(self, keys: Sequence[int]) -> Dict[int, int]:
        """The base symbol of each voxel."""
        self._shortest = 0 if self._payload.bits.bypass_bit() else 1
        base_symbols: Dict[int, int] = {}
        for key in keys:
            record = self._payload.history.records.get(key)
            self._expect(key, record, base_symbols)
            base_symbol = self._read_base_symbol()
            if record is None:
                self._error += (abs(16 * base_symbol - self._e) - self._error) >> 3
            change = 16 * base_symbol - self._running
            self._running += change >> 2 if base_symbols else change
            base_symbols[key] = base_symbol
        return base_symbols

    def _expect(
        self, key: int, record: Optional[Record], base_symbols: Dict[int, int]
    ) -> None:
        """What the contexts of a base symbol's decisions have in common."""
        average = self._running
        neighbours = self._payload.neighbours(key)
        below = [base_symbols[n] for n in neighbours[:3] if n in base_symbols]
        if self._effort == 2 and below:
            average = 16 * sum(below) // len(below)
        self._is_tracked = record is not None
        if record is not None:
            self._e = self._payload.mean_in_sixteenths(record)
            d = record.deviation << self._to_sixteenths
            level = 8 * _octave_class(self._e // 4, 48)
            way_3 = record.probability >> 13
        else:
            self._e = average
            d = self._error
            level = 384
            way_3 = _octave_class(average // 16, 8)
        self._scale = (d + 4).bit_length() - 1
        shape = 0
        for axis in range(3):
            shape *= 3
            for neighbour in (neighbours[axis], neighbours[axis + 3]):
                shape += neighbour in self._payload.occupied
        self._rows = (
            level + _octave_class(self._running // 16, 8),
            24 * shape + _octave_class(average // 16, 24),
            level + way_3,
        )

    def _read_base_symbol(self) -> int:
        bits, symbol_bits = self._payload.bits, self._payload.frame.symbol_bits
        length = self._shortest
        while length < symbol_bits and self._decide(
            _first_node(length), 2, 1 << length, max(length, 1)
        ):
            length += 1
        if length < 2:
            return length
        q = 1
        for j in reversed(range(length - 1)):
            if q >= 16 and j + 7 <= self._scale:
                q = 2 * q + bits.bypass_bit()
                continue
            node = _first_node(length) + q if q < 16 else 80 + j
            q = 2 * q + self._decide(node, 0, (2 * q + 1) << j, j + 1)
        return q

    def _decide(self, node: int, weights: int, middle: int, w: int) -> int:
        kind, bits = self._payload.kinds.symbol, self._payload.bits
        first, second, third = (96 * row + node for row in self._rows)
        if self._effort == 1 and node < 8:
            return kind.read_first(bits, first)
        x = (16 * middle - 8 - self._e) * 8 >> self._scale
        place = 16 * self._is_tracked + min(self._scale, 15)
        place = 8 * place + min(max(w + 6 - self._scale, 0), 7)
        place = (2 * place + (x >= 0)) * 21
        place += _octave_class(x if x >= 0 else -1 - x, 21)
        contexts = [first, place, second, third]
        if self._effort == 1:
            contexts = contexts[:2]
        return kind.read(bits, contexts, weights + self._is_tracked)


class _Symbols:
    """Section "Residuals", and what is said of the symbols in doc/bitstream.md."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._average = 16

    def read(self, keys: Sequence[int], base_symbols: Dict[int, int]) -> Dict[int, int]:
        """The symbol of each voxel; what there is to learn goes into `seen`."""
        self.seen: Dict[int, SeenVoxel] = {}
        return {key: self._symbol(key, base_symbols[key]) for key in keys}

    def _symbol(self, key: int, base_symbol: int) -> int:
        frame = self._payload.frame
        record = self._payload.history.records.get(key)
        if frame.depth_model is None:
            return self._without_rest(key, base_symbol)
        c = frame.depth_model.point_at_centre(key)
        w = point_with_offset(c, record.depth_offset if record else 0)
        if not has_residual(w):
            return self._without_rest(key, base_symbol)
        exact = base_symbol * w
        residual = self._read_residual(exact, base_symbol, record)
        symbol = predicted_symbol(exact, frame.highest_symbol) + from_zigzag(residual)
        require(0 <= symbol <= frame.highest_symbol, "a symbol is out of its range")
        offset = 0
        if base_symbol and symbol < frame.highest_symbol:
            offset = _quotient((((symbol << 16) - base_symbol * c) << 14), base_symbol * c)
        offset = min(max(offset, -(1 << 13)), 1 << 13)
        self.seen[key] = SeenVoxel(base_symbol, offset, 16 * min(residual, 15))
        return symbol

    def _without_rest(self, key: int, base_symbol: int) -> int:
        self.seen[key] = SeenVoxel(base_symbol, 0, 0)
        return base_symbol

    def _read_residual(self, exact: int, base_symbol: int, record: Optional[Record]) -> int:
        z = min(exact >> 17, 127).bit_length()
        w = 1 + _class_of(record.roughness, (6, 14, 24, 48)) if record else 0
        n = _class_of(base_symbol, (2, 3, 6))
        quarter = 4 * z + (exact >> 14) % 4
        rows = [
            quarter * 6 + w,
            (16 * z + (exact >> 12) % 16) * 6 + w,
            (quarter * 4 + min(self._average // 8, 3)) * 4 + n,
        ]
        residual = 0
        while residual < 32 and self._payload.kinds.residual.read(
            self._payload.bits, [32 * x + residual for x in rows], min(residual, 7)
        ):
            residual += 1
        if residual == 32:
            residual += self._payload.escape(16)
        self._average += 16 * min(residual, 64) // 8 - self._average // 8
        return residual


def _quotient(a: int, b: int) -> int:
    """a / b towards 0, b being above 0."""
    return a // b if a >= 0 else -(-a // b)


MOST_RECORDS = min(8 * MOST_VOXELS + (1 << 16), 2 * MOST_VOXELS + (1 << 20))
"""See "History"; a P-frame's history may be larger only behind larger limits."""


def decode_context_payload(
    bytes_of_payload: bytes, frame: CodedFrame, memory: ContextMemory
) -> "tuple[Voxels, ContextMemory]":
    """The voxels of a frame and the memory after it; `memory` stays as it is.

    A frame without voxels has an empty payload.
    """
    if frame.is_i_frame:
        memory = ContextMemory.at_start(frame.effort)
    history = memory.history
    require(len(history.records) <= MOST_RECORDS, "the history is too large")
    point_history = memory.point_history
    is_history_used = not frame.is_i_frame
    kinds, point_kinds = memory.kinds.copy(), memory.point_kinds.copy()
    keys: List[int] = []
    symbols: Dict[int, int] = {}
    seen: Dict[int, SeenVoxel] = {}
    point_symbols: Dict[int, int] = {}
    counts: List[int] = []
    if frame.voxel_count:
        bits = RangeDecoder(bytes_of_payload)
        if not frame.is_i_frame and not bits.bypass_bit():
            history = point_history = ContextHistory()
            is_history_used = False
        payload = _Payload(frame, bits, kinds, history, history.tracked_cells())
        _TrackedVoxels(payload).read()
        _read_new_voxels(payload)
        _read_new_blocks(payload)
        require(
            len(payload.occupied) == frame.voxel_count,
            "there are fewer voxels than the header says",
        )
        keys = sorted(payload.occupied)
        base_symbols = dict.fromkeys(keys, 0)
        if frame.symbol_bits:
            base_symbols = _BaseSymbols(payload).read(keys)
        reader = _Symbols(payload)
        symbols = reader.read(keys, base_symbols)
        seen = reader.seen
        if frame.has_points:
            if frame.has_intensities:
                payload = replace(
                    payload,
                    frame=frame.of_points(),
                    kinds=point_kinds,
                    history=point_history,
                )
                point_symbols = _BaseSymbols(payload).read(keys)
            counts = counts_of_symbols(
                [(point_symbols or symbols)[key] for key in keys],
                lambda: payload.escape(31),
            )
        bits.require_end()
    has_model = frame.depth_model is not None
    after = history.after_frame(seen, is_history_used, frame.symbol_bits, has_model)
    point_after = point_history.after_frame(
        {key: SeenVoxel(symbol, 0, 0) for key, symbol in point_symbols.items()},
        is_history_used,
        POINT_SYMBOL_BITS,
        False,
    )
    coded = [symbols[key] for key in keys] if frame.has_intensities else []
    return (
        Voxels(keys, coded, [], counts),
        ContextMemory(after, kinds, point_after, point_kinds),
    )
