# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Base symbols and symbols of the voxels of a payload of efforts 1 and 2.

Sections "Numbers" and "Residuals" of doc/bitstream_context.md.
"""

from typing import Dict, Optional, Sequence

from byte_reader import from_zigzag
from context_frame import Payload, class_of
from context_history import Record, SeenVoxel, fraction_bits
from depth_model import has_residual, point_with_offset, predicted_symbol
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


def _log(x: int) -> int:
    """log(x) of section "Local expectation"."""
    h = x.bit_length() - 1
    return 64 * (h - 1) + (64 * x >> h)


def _clamp(x: int, least: int, most: int) -> int:
    return min(max(x, least), most)


class LocalExpectation:
    """Section "Local expectation", of a frame."""

    def __init__(self, payload: Payload) -> None:
        self._payload = payload
        self._learnt = payload.kinds.local
        self._smoothed: Dict[int, int] = {}
        self._row = 640

    def expect(self, key: int) -> None:
        neighbours = self._payload.neighbours(key)
        occupied = self._payload.occupied
        self.faces = sum((n in occupied) << face for face, n in enumerate(neighbours))
        below = [self._smoothed[n] for n in neighbours[:3] if n in self._smoothed]
        self._around = sum(below) // len(below) if below else self._row
        share = self._learnt.shares[self.faces] >> 8
        self.logarithm = _clamp(_log(self._around) - 256 + share, 192, 1343)
        self.error = self._learnt.errors[self.faces] >> 8

    def e(self) -> int:
        return ((64 + self.logarithm % 64 << self.logarithm // 64) >> 6) - 8

    def is_used(self, is_tracked: bool) -> bool:
        return self._learnt.gains[is_tracked] >= 0

    def learn(self, key: int, base_symbol: int, otherwise: int, is_tracked: bool) -> None:
        learnt, n = self._learnt, 16 * base_symbol + 8
        z = _clamp(_log(n) - self.logarithm, -256, 256)
        gain = 256 * (abs(_log(n) - _log(otherwise + 8)) - abs(z))
        learnt.gains[is_tracked] += (gain - learnt.gains[is_tracked]) >> 7
        error = learnt.errors[self.faces]
        learnt.errors[self.faces] += (256 * abs(z) - error) >> 6
        share = learnt.shares[self.faces] + 8 * z
        learnt.shares[self.faces] = _clamp(share, -(1 << 17), 1 << 17)
        self._smoothed[key] = self._around - self._around // 4 + 16 * n // 4
        self._row += 16 * n // 4 - self._row // 4


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
        local: Optional[LocalExpectation] = None
        if self._effort == 2 or self._payload.bits.bypass_bit():
            local = LocalExpectation(self._payload)
        base_symbols: Dict[int, int] = {}
        for key in keys:
            record = self._payload.history.records.get(key)
            if local:
                local.expect(key)
            self._expect(key, record, base_symbols, local)
            base_symbol = self._read_base_symbol()
            if not self._is_by_record:
                self._error += (abs(16 * base_symbol - self._e) - self._error) >> 3
            if local:
                local.learn(key, base_symbol, self._otherwise, record is not None)
            change = 16 * base_symbol - self._running
            self._running += change >> 2 if base_symbols else change
            base_symbols[key] = base_symbol
        return base_symbols

    def _average(self, key: int, base_symbols: Dict[int, int]) -> int:
        """a of the description."""
        neighbours = self._payload.neighbours(key)
        below = [base_symbols[n] for n in neighbours[:3] if n in base_symbols]
        if self._effort == 1 or not below:
            return self._running
        return 16 * sum(below) // len(below)

    def _expect(
        self,
        key: int,
        record: Optional[Record],
        base_symbols: Dict[int, int],
        local: Optional[LocalExpectation],
    ) -> None:
        """What the contexts of a base symbol's decisions have in common."""
        average = self._otherwise = self._average(key, base_symbols)
        level = 0
        if record is not None:
            self._otherwise = self._payload.mean_in_sixteenths(record)
            level = 8 * _octave_class(self._otherwise // 4, 48)
        is_local = local is not None and local.is_used(record is not None)
        self._is_by_record = record is not None and not is_local
        running = _octave_class(self._running // 16, 8)
        if local is not None and is_local:
            self._e = local.e()
            d = self._e * local.error // 64
            first = 384 + 4 * ((local.logarithm - 192) // 32)
            first += class_of(local.error, (18, 36, 64))
        elif record is not None:
            self._e = self._otherwise
            d = record.deviation << self._to_sixteenths
            first = level + running
        else:
            self._e = self._otherwise
            d = self._error
            first = 528 + running
        self._scale = (d + 4).bit_length() - 1
        self._rows = [first]
        if self._effort == 2 and local is not None:
            fourth = 384 + 8 * ((local.logarithm - 192) // 32)
            fourth += _clamp((_log(self._running + 8) - local.logarithm >> 6) + 4, 0, 7)
            if record is not None:
                fourth = level + (record.probability >> 13)
            self._rows += [24 * local.faces + _octave_class(average // 16, 24), fourth]

    def _read_length(self) -> int:
        symbol_bits = self._payload.frame.symbol_bits
        if self._shortest == symbol_bits:
            return symbol_bits
        length = (max(self._e, 8) // 8).bit_length() - 1
        length = _clamp(length, self._shortest, symbol_bits - 1)
        if self._is_longer(_first_node(length), length):
            length += 1
            while length < symbol_bits and self._is_longer(_first_node(length), length):
                length += 1
            return length
        while length > self._shortest:
            length -= 1
            if self._is_longer(96 + length, length):
                return length + 1
        return length

    def _is_longer(self, node: int, length: int) -> int:
        return self._decide(node, True, 1 << length, max(length, 1))

    def _read_base_symbol(self) -> int:
        length = self._read_length()
        if length < 2:
            return length
        q = 1
        for j in reversed(range(length - 1)):
            if q >= 16 and j + 7 <= self._scale:
                q = 2 * q + self._payload.bits.bypass_bit()
                continue
            node = _first_node(length) + q if q < 16 else 80 + j
            q = 2 * q + self._decide(node, False, (2 * q + 1) << j, j + 1)
        return q

    def _decide(self, node: int, is_length: bool, middle: int, w: int) -> int:
        kind, bits = self._payload.kinds.symbol, self._payload.bits
        contexts = [112 * row + node for row in self._rows]
        if self._effort == 1 and (is_length or node < 8):
            return kind.read_first(bits, contexts[0])
        x = (16 * middle - 8 - self._e) * 8 >> self._scale
        place = 16 * self._is_by_record + min(self._scale, 15)
        place = 8 * place + min(max(w + 6 - self._scale, 0), 7)
        place = (2 * place + (x >= 0)) * 21
        place += _octave_class(x if x >= 0 else -1 - x, 21)
        contexts.insert(1, place)
        return kind.read(bits, contexts, 2 * node + self._is_by_record)


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
