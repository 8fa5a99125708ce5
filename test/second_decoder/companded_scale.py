# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Companded scales: levels of numbers.

doc/bitstream.md, "Companded scales".
"""

from functools import lru_cache
from typing import Dict, List

LEAST_COUNTS: Dict[int, List[int]] = {
    1: [1, 2],
    2: [1, 2, 3, 5],
    3: [1, 2, 3, 4, 5, 21, 68, 146],
    4: [1, 2, 3, 4, 5, 7, 13, 22, 35, 51, 70, 93, 119, 148, 180, 216],
}
"""The document's table: by bits, the edges of range 254, plus 1."""


@lru_cache(maxsize=8)
def edges(bits: int, number_range: int) -> List[int]:
    """The lowest number of each level, and the one after the highest of all."""
    if bits == 1:
        first = [0, 1]
    elif bits == 2:
        first = [0, 1, 2, 4]
    else:
        n = (1 << bits) - 4
        wide = number_range - 3 - n
        return [0, 1, 2, 3] + [4 + j + wide * j**2 // n**2 for j in range(n + 1)]
    return first + [number_range + 1]


def middle_number(bits: int, number_range: int, symbol: int) -> int:
    """The number that a symbol stands for."""
    edge = edges(bits, number_range)
    return (edge[symbol] + edge[symbol + 1] - 1) // 2
