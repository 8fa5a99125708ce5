# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Which of several candidates for a number is expected: the one with the lowest cost.

doc/bitstream_scan.md, "Numbers of a plane" and "Positions".
"""

from typing import Sequence


def highest_bit(number: int) -> int:
    """The largest k with 2^k <= number."""
    return number.bit_length() - 1


class Costs:
    """Costs of candidates, of which the first ones are always there."""

    def __init__(self, count: int, decay: int) -> None:
        self._costs = count * [0]
        self._decay = decay

    def best(self, count: int) -> int:
        """Which of the first candidates has the lowest cost, the first of equals."""
        return min(range(count), key=lambda i: self._costs[i])

    def learn(self, candidates: Sequence[int], number: int) -> None:
        for i, candidate in enumerate(candidates):
            gain = 64 * highest_bit(2 * abs(candidate - number) + 1)
            self._costs[i] += gain - self._costs[i] // self._decay
