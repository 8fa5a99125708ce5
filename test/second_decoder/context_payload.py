"""The payload of efforts 1 and 2.

doc/bitstream_context.md; each class of this file holds one of its sections.
"""

from bisect import bisect_right
from collections import Counter
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Set

from coded_frame import MOST_VOXELS, CodedFrame, Voxels
from context_history import ContextHistory, Record, SeenVoxel, fraction_bits
from depth_model import has_rest, point_with_offset, predicted_symbol
from frame_header import from_zigzag
from invalid_frame import require
from morton import BLOCK_BITS, cells_of_block, levels_above_blocks, neighbours
from range_coder import Kind, RangeDecoder


class Kinds:
    """All kinds of decisions: their numbers of ways and their shifts."""

    def __init__(self, effort: int) -> None:
        self.known_voxel = Kind(6, 6, effort)
        self.known_block = Kind(1, 5, effort)
        self.octant = Kind(3, 5, effort)
        self.more_octants = Kind(1, 5, effort)
        self.cell = Kind(4, 5, effort)
        self.more_cells = Kind(1, 5, effort)
        self.branch = Kind(1, 5, effort)
        self.new_block = Kind(1, 5, effort)
        self.more = Kind(4, 5, effort)
        self.differs = Kind(1, 5, effort)
        self.above = Kind(1, 5, effort)
        self.farther = Kind(1, 5, effort)
        self.escape = Kind(1, 5, effort)
        self.rest = Kind(3, 5, effort)
        self.plain = Kind(1, 6, effort)

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

    @staticmethod
    def at_start(effort: int) -> "ContextMemory":
        return ContextMemory(ContextHistory(), Kinds(effort))


@dataclass
class _Payload:
    """A payload being read, and the voxels found so far."""

    frame: CodedFrame
    bits: RangeDecoder
    kinds: Kinds
    history: ContextHistory
    known_cells: Dict[int, List[int]]
    occupied: Set[int] = field(default_factory=set)

    def neighbours(self, key: int) -> Sequence[Optional[int]]:
        return neighbours(key, self.frame.depth)

    def full(self, key: int) -> int:
        """How many of a cell's face neighbours are occupied."""
        return sum(n in self.occupied for n in self.neighbours(key))

    def add(self, key: int) -> None:
        self.occupied.add(key)
        require(
            len(self.occupied) <= self.frame.voxel_count,
            "there are more voxels than the header says",
        )

    def mean_in_sixteenths(self, record: Record) -> int:
        """m of the description."""
        return record.mean << (4 - fraction_bits(self.frame.symbol_bits))

    def escape(self, kind: int) -> int:
        """A number of any size: see "Escape"."""
        b = 0
        while self.kinds.escape.read(self.bits, [17 * kind + b]):
            b += 1
            require(b <= 16, "a number has too many bits")
        return ((1 << b) | self.bits.bypass_bits(b)) - 1


def _class_of(number: int, least: Sequence[int]) -> int:
    """How many of ascending numbers a number reaches."""
    return bisect_right(least, number)


class _KnownVoxels:
    """Section "Known voxels"."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._f = fraction_bits(payload.frame.symbol_bits)
        self._coded: Dict[int, int] = {}

    def read(self) -> None:
        payload = self._payload
        for block, cells in payload.known_cells.items():
            surprise = 0
            for cell in cells:
                key = block << BLOCK_BITS | cell
                record = payload.history.records[key]
                p = record.probability
                bit = payload.kinds.known_voxel.read(
                    payload.bits,
                    self._contexts(key, record, surprise),
                    (p >> 13) * 3 + record.age_class,
                )
                surprise += ((65535 - p if bit else -p) - surprise) >> 2
                self._coded[key] = bit
                if bit:
                    payload.add(key)

    def _contexts(self, key: int, record: Record, surprise: int) -> List[int]:
        payload = self._payload
        p, r, g = record.probability, record.recent, record.age_class
        c = _class_of(record.mean >> max(self._f - 2, 0), (6, 8, 12, 20))
        before = came = went = 0
        for neighbour in payload.neighbours(key):
            other = payload.history.records.get(neighbour)
            if other is None:
                continue
            before += other.was_in_last_frame
            if neighbour in self._coded:
                is_occupied = self._coded[neighbour]
                came += bool(is_occupied and not other.was_in_last_frame)
                went += bool(not is_occupied and other.was_in_last_frame)
        m = payload.mean_in_sixteenths(record)
        first_of_octant = key & ~7
        q = sum(
            1 << (other & 7)
            for other in range(first_of_octant, key)
            if other in payload.occupied
        )
        surprise_class = min(max((surprise + (1 << 16)) >> 13, 0), 15)
        return [
            (((p >> 11) * 4 + r % 4) * 3 + g) * 5 + c,
            ((p >> 11) * 7 + before) * 32 + 8 * min(came, 3) + 2 * min(went, 3) + r % 2,
            (4 * r + g) * 4 + (p >> 14),
            ((p >> 11) * 16 + surprise_class) * 4 + r % 4,
            ((p >> 12) * 16 + min(m // 8, 15)) * 8 + min(record.age // 4, 7),
            16 * q + (p >> 12),
        ]


class _OctantsOfBlock:
    """Octants and cells with new voxels in one block, known or new.

    Sections "New voxels in known blocks", "Cells" and the end of "New blocks".
    """

    def __init__(
        self, payload: _Payload, block: int, activity: int, is_new: bool
    ) -> None:
        self._payload = payload
        self._i = int(payload.frame.is_i_frame)
        self._first = block << BLOCK_BITS
        self._activity = activity
        self._is_new = is_new
        self._known = set(payload.known_cells.get(block, ()))

    def read(self) -> None:
        kinds, bits = self._payload.kinds, self._payload.bits
        octants = self._octants()
        found = 0
        for place, octant in enumerate(octants):
            left = len(octants) - place - 1
            is_implied = left == 0 and (found == 0 or not self._is_new)
            if not is_implied and not kinds.octant.read(
                bits,
                self._octant_contexts(octant, found, left),
                2 * min(found, 2) + self._i,
            ):
                continue
            self._read_cells(octant)
            found += 1
            if left and not self._is_new:
                context = 4 * (min(found, 4) - 1) + min(left - 1, 3)
                if not kinds.more_octants.read(bits, [context]):
                    return

    def _octants(self) -> List[int]:
        """The octants that can have new voxels, as they are asked about."""
        cells = cells_of_block(self._payload.frame.depth)
        octants = [o for o in range(cells // 8) if self._unknown_cells(o)]
        if self._is_new:
            return octants
        return sorted(octants, key=lambda o: -_class_of_sum(self._sum_of_full(o)))

    def _unknown_cells(self, octant: int) -> List[int]:
        return [c for c in range(8 * octant, 8 * octant + 8) if c not in self._known]

    def _sum_of_full(self, octant: int) -> int:
        """S of the description."""
        first = self._first | 8 * octant
        return sum(self._payload.full(key) for key in range(first, first + 8))

    def _octant_contexts(self, octant: int, n: int, left: int) -> List[int]:
        total = self._sum_of_full(octant)
        k = 8 - len(self._unknown_cells(octant))
        o = self._occupied_mask(octant).bit_count()
        place = 8 * self._activity + octant
        classes = _class_of_sum(total) * 4 + _class_of(k, (1, 3, 6))
        classes = classes * 3 + _class_of(o, (1, 3))
        return [
            (classes * 9 + _candidate_class(n, left)) * 2 + self._i,
            (min(total, 23) * 9 + k) * 9 + o,
            (place * 10 + min(total, 9)) * 8 + 2 * min(n, 3) + self._i,
        ]

    def _occupied_mask(self, octant: int) -> int:
        first = self._first | 8 * octant
        return sum(
            1 << cell for cell in range(8) if first + cell in self._payload.occupied
        )

    def _read_cells(self, octant: int) -> None:
        kinds, bits = self._payload.kinds, self._payload.bits
        cells = self._unknown_cells(octant)
        full = {cell: self._payload.full(self._first | cell) for cell in cells}
        if not self._is_new:
            cells.sort(key=lambda cell: -full[cell])
        found = 0
        for place, cell in enumerate(cells):
            left = len(cells) - place - 1
            now_full = full[cell]
            if self._is_new:
                now_full = self._payload.full(self._first | cell)
            is_implied = left == 0 and (found == 0 or not self._is_new)
            if not is_implied and not kinds.cell.read(
                bits,
                self._cell_contexts(cell, now_full, found, left),
                2 * now_full + self._i,
            ):
                continue
            self._payload.add(self._first | cell)
            found += 1
            if left and not self._is_new:
                context = 8 * (min(found, 4) - 1) + min(left - 1, 7)
                if not kinds.more_cells.read(bits, [context]):
                    return

    def _cell_contexts(self, cell: int, full: int, n: int, left: int) -> List[int]:
        payload = self._payload
        key = self._first | cell
        empty = a = 0
        for face, neighbour in enumerate(payload.neighbours(key)):
            if neighbour in payload.occupied:
                a |= 1 << face
            elif neighbour is not None and neighbour & ~63 == self._first:
                empty += neighbour & 63 in self._known
        i = self._i
        candidate = 7 - min(left, 7) if n == 0 else 3 + 4 * min(n, 2) + min(left, 3)
        return [
            ((full * 15 + candidate) * 2 + i) * 4 + min(empty, 3),
            8 * self._occupied_mask(cell // 8) + cell % 8,
            28 * a + 7 * min(n, 3) + min(empty, 6),
            ((7 * self._activity + full) * 8 + min(left, 7)) * 2 + i,
        ]


def _candidate_class(found: int, left: int) -> int:
    """Class of one of some candidates, of which at least one is it."""
    return 7 - min(left, 7) if found == 0 else 6 + min(found, 2)


def _class_of_sum(total: int) -> int:
    return _class_of(total, (1, 2, 4, 7, 12))


def _read_new_voxels_in_known_blocks(payload: _Payload) -> None:
    """Section "New voxels in known blocks", but for what _OctantsOfBlock holds."""
    had_new = 0
    for block, cells in payload.known_cells.items():
        if len(cells) == cells_of_block(payload.frame.depth):
            continue
        activity = payload.history.activities[block]
        k = _class_of(len(cells), (4, 10, 20))
        had_new = payload.kinds.known_block.read(
            payload.bits, [(4 * activity + k) * 2 + had_new]
        )
        if had_new:
            _OctantsOfBlock(payload, block, activity, is_new=False).read()


class _NewBlocks:
    """Section "New blocks"."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._i = int(payload.frame.is_i_frame)
        self._occupied_blocks = {key >> BLOCK_BITS for key in payload.occupied}
        self._known_blocks = [
            Counter(block >> (3 * levels) for block in payload.known_cells)
            for levels in range(levels_above_blocks(payload.frame.depth))
        ]

    def read(self) -> None:
        if not self._payload.bits.bypass_bit():
            return
        levels = levels_above_blocks(self._payload.frame.depth)
        if levels:
            self._read_branch(0, levels)
            return
        require(0 not in self._payload.known_cells, "the only block is no new one")
        self._read_block(0)

    def _read_branch(self, branch: int, levels: int) -> None:
        """The parts of a branch so many levels above the blocks."""
        payload = self._payload
        found = 0
        for part in range(8 * branch, 8 * branch + 8):
            if levels == 1 and part in payload.known_cells:
                continue
            is_implied = found == 0 and part % 8 == 7
            if not is_implied and not self._has_new(part, levels, found):
                continue
            found += 1
            if levels == 1:
                self._read_block(part)
            else:
                self._read_branch(part, levels - 1)
        require(found > 0, "a branch has no new blocks after all")

    def _has_new(self, part: int, levels: int, n: int) -> int:
        kinds, bits = self._payload.kinds, self._payload.bits
        candidate = _candidate_class(n, 7 - part % 8)
        if levels == 1:
            across = sum(part ^ axis in self._occupied_blocks for axis in (1, 2, 4))
            return kinds.new_block.read(bits, [(9 * across + candidate) * 2 + self._i])
        b = _class_of(self._known_blocks[levels - 1][part], (1, 2, 4, 8, 16))
        return kinds.branch.read(
            bits, [((b * 9 + candidate) * 4 + min(levels - 2, 3)) * 2 + self._i]
        )

    def _read_block(self, block: int) -> None:
        _OctantsOfBlock(self._payload, block, activity=0, is_new=True).read()
        self._occupied_blocks.add(block)


class _Numbers:
    """Section "Numbers"."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._to_sixteenths = 4 - fraction_bits(payload.frame.symbol_bits)
        self._running: Optional[int] = None
        self._lowest = 0

    def read(self, keys: Sequence[int]) -> Dict[int, int]:
        """The number of each voxel."""
        bits, symbol_bits = self._payload.bits, self._payload.frame.symbol_bits
        if bits.bypass_bit():
            return {key: self._read_plain(bits, symbol_bits) for key in keys}
        self._lowest = 0 if bits.bypass_bit() else 1
        highest = self._payload.frame.highest_symbol
        numbers: Dict[int, int] = {}
        for key in keys:
            number = self._read_number(key, numbers)
            require(number <= highest, "a number is too large")
            numbers[key] = number
            if self._running is None:
                self._running = 16 * number
            else:
                self._running += (16 * number - self._running) >> 2
        return numbers

    def _read_plain(self, bits: RangeDecoder, symbol_bits: int) -> int:
        """A number of which nothing is expected."""
        node = 1
        for _ in range(min(symbol_bits, 8)):
            node = 2 * node + self._payload.kinds.plain.read(bits, [node])
        for _ in range(symbol_bits - 8):
            node = 2 * node + bits.bypass_bit()
        return node - (1 << symbol_bits)

    def _read_number(self, key: int, numbers: Dict[int, int]) -> int:
        record = self._payload.history.records.get(key)
        if record is not None:
            expected = self._payload.mean_in_sixteenths(record)
        else:
            expected = 16 if self._running is None else self._running
        if expected < 160:
            return self._near(expected, record, self._class_of_neighbours(key, numbers))
        deviation = (
            expected // 4 if record is None else record.deviation << self._to_sixteenths
        )
        return self._far(expected, deviation, record is not None)

    def _class_of_running(self) -> int:
        """R of the description."""
        if self._running is None:
            return 0
        return 1 + _class_of(self._running, (17, 32, 48, 80, 128, 256))

    def _class_of_neighbours(self, key: int, numbers: Dict[int, int]) -> int:
        """C of the description."""
        below = [numbers[n] for n in self._payload.neighbours(key)[:3] if n in numbers]
        if not below:
            return 0
        average = 16 * sum(below) // len(below)
        return 1 + _class_of(average, (17, 25, 33, 41, 49, 65, 81, 113, 161, 257))

    def _near(self, e: int, record: Optional[Record], c: int) -> int:
        """A number where a small one is expected."""
        r = self._class_of_running()
        if record is not None:
            d = record.deviation << self._to_sixteenths
            rows = [
                e // 8 * 8 + r,
                min(e // 4, 39) * 15 + min(d // 6, 14),
                ((record.probability >> 12) * 16 + e // 10) * 2 + record.recent % 2,
                20 * c + e // 10,
            ]
        else:
            rows = [
                (20 + e // 16) * 8 + r,
                600 + min((self._running or 0) // 8, 39),
                r,
                20 * c + 16 + r // 2,
            ]
        more, bits = self._payload.kinds.more, self._payload.bits
        for t in range(self._lowest, 24):
            if not more.read(bits, [24 * x + t for x in rows], min(t, 9)):
                return t
        return 24 + self._payload.escape(0)

    def _far(self, e: int, deviation: int, is_known: bool) -> int:
        """A number by its distance from the large one that is expected."""
        kinds, bits = self._payload.kinds, self._payload.bits
        k = next((k for k in range(12) if deviation >> (4 + k) <= 6), 12)
        x = 4 * min((deviation >> k) >> 3, 13) + (2 if k > 0 else 0) + is_known
        upper = (e // 16) >> k
        if kinds.differs.read(bits, [x]):
            above = kinds.above.read(bits, [x])
            t = 0
            while t < 28 and kinds.farther.read(bits, [28 * (2 * x + above) + t]):
                t += 1
            distance = 1 + (t if t < 28 else 28 + self._payload.escape(1))
            upper += distance if above else -distance
            require(upper >= 0, "a number is below 0")
        return upper << k | bits.bypass_bits(k)


class _Symbols:
    """Section "Rests", and what is said of the symbols in doc/bitstream.md."""

    def __init__(self, payload: _Payload) -> None:
        self._payload = payload
        self._average = 16

    def read(self, keys: Sequence[int], numbers: Dict[int, int]) -> Dict[int, int]:
        """The symbol of each voxel; what there is to learn goes into `seen`."""
        self.seen: Dict[int, SeenVoxel] = {}
        return {key: self._symbol(key, numbers[key]) for key in keys}

    def _symbol(self, key: int, number: int) -> int:
        frame = self._payload.frame
        record = self._payload.history.records.get(key)
        if frame.depth_model is None:
            return self._without_rest(key, number)
        c = frame.depth_model.point_at_centre(key)
        w = point_with_offset(c, record.depth_offset if record else 0)
        if not has_rest(w):
            return self._without_rest(key, number)
        exact = number * w
        rest = self._read_rest(exact, number, record)
        symbol = predicted_symbol(exact, frame.highest_symbol) + from_zigzag(rest)
        require(0 <= symbol <= frame.highest_symbol, "a symbol is out of its range")
        offset = 0
        if number and symbol < frame.highest_symbol:
            offset = _quotient((((symbol << 16) - number * c) << 14), number * c)
        offset = min(max(offset, -(1 << 13)), 1 << 13)
        self.seen[key] = SeenVoxel(number, offset, 16 * min(rest, 15))
        return symbol

    def _without_rest(self, key: int, number: int) -> int:
        self.seen[key] = SeenVoxel(number, 0, 0)
        return number

    def _read_rest(self, exact: int, number: int, record: Optional[Record]) -> int:
        z = min(exact >> 17, 127).bit_length()
        w = 1 + _class_of(record.roughness, (6, 14, 24, 48)) if record else 0
        n = _class_of(number, (2, 3, 6))
        quarter = 4 * z + (exact >> 14) % 4
        rows = [
            quarter * 6 + w,
            (16 * z + (exact >> 12) % 16) * 6 + w,
            (quarter * 4 + min(self._average // 8, 3)) * 4 + n,
        ]
        rest = 0
        while rest < 32 and self._payload.kinds.rest.read(
            self._payload.bits, [32 * x + rest for x in rows], min(rest, 7)
        ):
            rest += 1
        if rest == 32:
            rest += self._payload.escape(2)
        self._average += 16 * min(rest, 64) // 8 - self._average // 8
        return rest


def _quotient(a: int, b: int) -> int:
    """a / b towards 0, b being above 0."""
    return a // b if a >= 0 else -(-a // b)


MOST_RECORDS = min(8 * MOST_VOXELS + (1 << 16), 2 * MOST_VOXELS + (1 << 20))
"""See "History"; a P-frame's history may be larger only behind larger limits."""


def decode_context_payload(
    bytes_of_payload: bytes, frame: CodedFrame, memory: ContextMemory
) -> "tuple[Voxels, ContextMemory]":
    """The voxels of a frame and the memory behind it; `memory` stays as it is.

    A frame without voxels has an empty payload.
    """
    if frame.is_i_frame:
        memory = ContextMemory.at_start(frame.effort)
    history = memory.history
    require(len(history.records) <= MOST_RECORDS, "the history is too large")
    kinds = memory.kinds.copy()
    keys: List[int] = []
    symbols: Dict[int, int] = {}
    seen: Dict[int, SeenVoxel] = {}
    if frame.voxel_count:
        payload = _Payload(
            frame, RangeDecoder(bytes_of_payload), kinds, history, history.known_cells()
        )
        _KnownVoxels(payload).read()
        _read_new_voxels_in_known_blocks(payload)
        _NewBlocks(payload).read()
        require(
            len(payload.occupied) == frame.voxel_count,
            "there are fewer voxels than the header says",
        )
        keys = sorted(payload.occupied)
        numbers = dict.fromkeys(keys, 0)
        if frame.symbol_bits:
            numbers = _Numbers(payload).read(keys)
        reader = _Symbols(payload)
        symbols = reader.read(keys, numbers)
        seen = reader.seen
        payload.bits.require_end()
    has_model = frame.depth_model is not None
    after = history.after_frame(
        seen, frame.is_i_frame, frame.effort, frame.symbol_bits, has_model
    )
    coded = [symbols[key] for key in keys] if frame.symbol_bits else []
    return Voxels(keys, coded), ContextMemory(after, kinds)
