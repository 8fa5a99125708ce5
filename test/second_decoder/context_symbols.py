"""Base symbols and symbols of the voxels of a payload of efforts 1 and 2.

Sections "Numbers" and "Residuals" of doc/bitstream_context.md.
"""

from typing import Dict, Optional, Sequence

from context_frame import Payload, class_of
from context_history import Record, SeenVoxel, fraction_bits
from depth_model import has_residual, point_with_offset, predicted_symbol
from frame_header import from_zigzag
from invalid_frame import require


def _octave_class(x: int, n: int) -> int:
    """class(x, n) of section "Numbers"."""
    if x < 4:
        return x
    h = x.bit_length() - 1
    return min(4 * (h - 1) + (x >> (h - 2)) % 4, n - 1)


def _first_node(length: int) -> int:
    """first of section "Numbers"."""
    return (1 << length) // 2 if length < 5 else 16 * (min(length, 8) - 4)


class BaseSymbols:
    """Section "Numbers"."""

    def __init__(self, payload: Payload) -> None:
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


class Symbols:
    """Section "Residuals", and what is said of the symbols in doc/bitstream.md."""

    def __init__(self, payload: Payload) -> None:
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
        w = 1 + class_of(record.roughness, (6, 14, 24, 48)) if record else 0
        n = class_of(base_symbol, (2, 3, 6))
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
