# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""rANS decoder, and the models of bits, nibbles and bytes.

doc/bitstream_fast.md, "Entropy coder".
"""

import struct
from bisect import bisect_right
from functools import lru_cache
from itertools import accumulate
from typing import List, Sequence

from invalid_frame import require

_SLOTS = 4096
_LEAST_STATE = 1 << 15
FOUR_STATES = 1024
"""Streams of so many symbols have four states, shorter ones one."""


class RansDecoder:
    """Reads symbols that own slots; symbol i uses state i mod S."""

    def __init__(self, source: bytes, length: int) -> None:
        count = 1 if length < FOUR_STATES else 4
        require(
            len(source) >= 4 * count and len(source) % 2 == 0,
            "the rANS stream is cut off",
        )
        self._states = list(struct.unpack_from(f"<{count}I", source))
        words = len(source) // 2 - 2 * count
        self._words = struct.unpack_from(f"<{words}H", source, 4 * count)
        self._next_word = 0
        self._next_state = 0
        require(
            all(_LEAST_STATE <= x < 1 << 31 for x in self._states), "a state is none"
        )

    def symbol(self, starts: Sequence[int]) -> int:
        """The symbol i that owns the slots starts[i] .. starts[i + 1] - 1."""
        x = self._states[self._next_state]
        slot = x % _SLOTS
        symbol = bisect_right(starts, slot) - 1
        start = starts[symbol]
        x = (starts[symbol + 1] - start) * (x // _SLOTS) + slot - start
        if x < _LEAST_STATE:
            require(self._next_word < len(self._words), "the rANS stream is cut off")
            x = x << 16 | self._words[self._next_word]
            self._next_word += 1
        self._states[self._next_state] = x
        self._next_state = (self._next_state + 1) % len(self._states)
        return symbol

    def bits(self, size: int) -> int:
        """A number of 1 to 12 bits."""
        return self.symbol(range(0, _SLOTS + 1, _SLOTS >> size))

    def require_end(self) -> None:
        """Refuses a stream that does not end where its encoder began."""
        require(
            all(x == _LEAST_STATE for x in self._states)
            and self._next_word == len(self._words),
            "the rANS stream does not end with its last symbol",
        )


class BitModel:
    """A bit whose probability of being 1 is p / 2^16."""

    def __init__(self, p: int = 1 << 15) -> None:
        self._p = min(max(p, 512), 65024)

    def copy(self) -> "BitModel":
        return BitModel(self._p)

    def read(self, rans: RansDecoder) -> int:
        bit = rans.symbol((0, _SLOTS - self._p // 16, _SLOTS))
        self._p += ((65024 if bit else 512) - self._p) >> 4
        return bit


class NibbleModel:
    """A nibble; learns at the end of each period."""

    def __init__(self) -> None:
        self._s = [2048 * i for i in range(17)]
        self._counts = 16 * [0]
        self._k = 2
        self._left = 4

    def copy(self) -> "NibbleModel":
        other = NibbleModel.__new__(NibbleModel)
        other._s = list(self._s)
        other._counts = list(self._counts)
        other._k = self._k
        other._left = self._left
        return other

    def read(self, rans: RansDecoder) -> int:
        nibble = rans.symbol([s // 8 for s in self._s])
        self._counts[nibble] += 1
        self._left -= 1
        if self._left == 0:
            self._end_period()
        return nibble

    def _end_period(self) -> None:
        unit = 32640 >> self._k
        shift = 1 if self._k < 5 else 2
        for i, before in enumerate(accumulate(self._counts[:15], initial=0)):
            self._s[i] += (8 * i + unit * before - self._s[i]) >> shift
        self._counts = 16 * [0]
        self._k = min(self._k + 1, 5)
        self._left = 1 << self._k


def _byte_table(weights: Sequence[int]) -> List[int]:
    before = accumulate(weights, initial=0)
    starts = [v + (3840 * total >> 32) for v, total in enumerate(before)]
    starts[256] = _SLOTS
    return starts


@lru_cache(maxsize=None)
def _occupancy_table_of(q: int) -> List[int]:
    products = [q**ones * (128 - q) ** (8 - ones) for ones in range(9)]
    return _byte_table([products[v.bit_count()] >> 24 for v in range(256)])


def occupancy_table(share: int) -> List[int]:
    """The byte table of eight voxels that are occupied with a share in 2^-16."""
    q = max(share >> 9, 1)
    return _occupancy_table_of(q // 4 * 4 + 2 if 8 <= q < 120 else q)
