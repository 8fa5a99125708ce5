# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Symbols with the tables of a plane, and the numbers that they stand for.

doc/bitstream_scan.md, "Tables" and "Coding".
"""

from itertools import accumulate
from typing import List

from invalid_frame import require
from rans import FOUR_STATES, NibbleModel, RansDecoder

_CONTEXTS = 173
POSITION_CONTEXTS = 252
_SYMBOLS = 80
_SLOTS = 4096
_LARGEST_ENTRY = 12
"""Bits of one."""
_EXACT = 16
"""Numbers below it are symbols."""
_NUMBER_SYMBOLS = 72
"""Symbols of numbers are below it."""


class SymbolReader:
    """Reads the stream of a plane."""

    def __init__(self, source: bytes, contexts: int = _CONTEXTS) -> None:
        self._rans = RansDecoder(source, FOUR_STATES)
        self._widths = [NibbleModel() for _ in range(16)]
        self._starts = [self._table()]
        """Of each context where the slots of symbols start."""
        for _ in range(1, contexts):
            has_table = self._rans.bits(1)
            self._starts.append(self._table() if has_table else self._starts[-1])

    def _table(self) -> List[int]:
        widths: List[int] = []
        left = _SLOTS
        length = 0
        while left > 0:
            require(len(widths) < _SYMBOLS, "a table has slots without a symbol")
            length = self._widths[length].read(self._rans)
            require(length <= 12, "a width of a table is too large")
            width = 1 << (length - 1) | self._bits(length - 1) if length else 0
            require(width <= left, "a table has too many slots")
            widths.append(width)
            left -= width
        return list(accumulate(widths, initial=0))

    def symbol(self, context: int) -> int:
        return self._rans.symbol(self._starts[context])

    def number_of(self, symbol: int) -> int:
        """u of a symbol that was read; reads its low bits."""
        require(symbol < _NUMBER_SYMBOLS, "a symbol is not that of a number")
        if symbol < _EXACT:
            return symbol
        size = (symbol - _EXACT) // 2 + 3
        return (2 + symbol % 2) << size | self._bits(size)

    def _bits(self, size: int) -> int:
        bits = 0
        while size > 0:
            part = min(size, _LARGEST_ENTRY)
            bits = bits << part | self._rans.bits(part)
            size -= part
        return bits

    def require_end(self) -> None:
        self._rans.require_end()
