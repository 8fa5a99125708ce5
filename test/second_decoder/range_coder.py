# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Range coder, adaptive bits, their mixing, and choices.

doc/bitstream_context.md, "Range coder", "Adaptive bits", "Mixing" and "Choices".
"""

from typing import Dict, List, Sequence, Tuple

from invalid_frame import require


class RangeDecoder:
    """Reads bits of known probabilities."""

    def __init__(self, payload: bytes) -> None:
        self._payload = payload
        self._at = 0
        self._range = (1 << 32) - 1
        self._code = self._next_bytes(4)

    def _next_bytes(self, size: int) -> int:
        """The next bytes, the first one highest; 0 after the end."""
        taken = self._payload[self._at : self._at + size]
        self._at += size
        return int.from_bytes(taken + bytes(size - len(taken)), "big")

    def bit(self, p: int) -> int:
        """A bit whose probability of being 1 is p / 2^16."""
        bound = self._range * p >> 16
        if self._code < bound:
            bit = 1
            self._range = bound
        else:
            bit = 0
            self._code -= bound
            self._range -= bound
        self._read_ahead()
        return bit

    def choice(self, weights: Sequence[int], counts: Sequence[int]) -> Tuple[int, int]:
        """Class and place of one of some alternatives."""
        total = sum(w * n for w, n in zip(weights, counts))
        unit = self._range // total
        t = min(self._code // unit, total - 1)
        begin = 0
        for chosen, (w, n) in enumerate(zip(weights, counts)):
            if t < begin + w * n:
                break
            begin += w * n
        place = (t - begin) // w
        begin += place * w
        self._code -= unit * begin
        if begin + w == total:
            self._range -= unit * begin
        else:
            self._range = unit * w
        self._read_ahead()
        return chosen, place

    def _read_ahead(self) -> None:
        if self._range < 1 << 16:
            self._range <<= 16
            self._code = self._code << 16 | self._next_bytes(2)

    def bypass_bit(self) -> int:
        """A bit that is 0 as often as 1."""
        return self.bit(1 << 15)

    def bypass_bits(self, size: int) -> int:
        """A number of bypass bits, the highest first."""
        number = 0
        for _ in range(size):
            number = 2 * number + self.bypass_bit()
        return number

    def require_end(self) -> None:
        """Refuses a payload with bytes after the last bit."""
        require(self._at >= len(self._payload), "bytes are left behind the last bit")


def _squash_table() -> Dict[int, int]:
    squash = {}
    e = 1 << 18
    for x in range(2048):
        squash[x] = (e << 16) // (e + (1 << 18))
        squash[-x] = (1 << 16) - squash[x]
        e = e * 0x10100802B >> 32
    return squash


def _stretch_table() -> List[int]:
    stretch = []
    x = -2047
    for i in range(4096):
        while x < 2047 and SQUASH[x] < 16 * i + 8:
            x += 1
        stretch.append(x)
    return stretch


SQUASH = _squash_table()
STRETCH = _stretch_table()

_FIRST_SHIFTS = (1, 2, 3, 3, 3, 3) + 10 * (4,)
_NEW_BIT = (1 << 15, 0)


def _held(low: int, high: int, number: int) -> int:
    return low if number < low else high if number > high else number


class Kind:
    """A kind of decision: the ways of adaptive bits that the effort uses, and the weights
    that mix them.

    Bits and weights are kept for the contexts that have come up; others are as at the
    start.
    """

    def __init__(self, ways: int, shift: int) -> None:
        self._shift = shift
        self._bits: List[Dict[int, Tuple[int, int]]] = [{} for _ in range(ways)]
        self._weights: Dict[int, Tuple[int, ...]] = {}
        self._first_weights = ways * ((6 << 16) // (5 * ways),)

    def copy(self) -> "Kind":
        """A kind that learns without changing this one."""
        other = Kind.__new__(Kind)
        other.__dict__.update(self.__dict__)
        other._bits = [dict(way) for way in self._bits]
        other._weights = dict(self._weights)
        return other

    def read(
        self, coder: RangeDecoder, contexts: Sequence[int], weight_set: int = 0
    ) -> int:
        """Decides, with a context for each way that is used, and learns."""
        if len(self._bits) == 1:
            return self.read_first(coder, contexts[0])
        bits = [way.get(c, _NEW_BIT) for way, c in zip(self._bits, contexts)]
        stretched = [STRETCH[p >> 4] for p, _ in bits]
        weights = self._weights.get(weight_set, self._first_weights)
        x = sum(w * t for w, t in zip(weights, stretched)) >> 16
        p = SQUASH[_held(-2047, 2047, x)]
        bit = coder.bit(p)
        error = (bit << 16) - p
        self._weights[weight_set] = tuple(
            _held(-(1 << 19), 1 << 19, w + ((t * error + (1 << 14)) >> 15))
            for w, t in zip(weights, stretched)
        )
        for way, context, (p, count) in zip(self._bits, contexts, bits):
            way[context] = self._learnt(p, count, bit)
        return bit

    def read_first(self, coder: RangeDecoder, context: int) -> int:
        """Decides with way 0 alone."""
        way = self._bits[0]
        p, count = way.get(context, _NEW_BIT)
        bit = coder.bit(p)
        way[context] = self._learnt(p, count, bit)
        return bit

    def _learnt(self, p: int, count: int, bit: int) -> Tuple[int, int]:
        shift = _FIRST_SHIFTS[count] if count < 16 else self._shift
        return p + (((65488 if bit else 48) - p) >> shift), min(count + 1, 16)


class Choices:
    """The weights of the classes of choices."""

    def __init__(self, weights: Sequence[int]) -> None:
        self._weights = [w << 16 for w in weights]

    def copy(self) -> "Choices":
        """Choices that learn without changing these."""
        other = Choices(())
        other._weights = list(self._weights)
        return other

    def read(self, coder: RangeDecoder, counts: Sequence[int]) -> Tuple[int, int]:
        """Chooses an alternative, given as its class and place, and learns."""
        weights = [weight >> 16 for weight in self._weights]
        chosen, place = coder.choice(weights, counts)
        r = (1 << 32) // sum(w * n for w, n in zip(weights, counts))
        for i, (w, n) in enumerate(zip(weights, counts)):
            error = ((i == chosen) << 16) - (w * n * r >> 16)
            weight = self._weights[i] + (self._weights[i] * error >> 20)
            self._weights[i] = _held(1 << 16, (1 << 26) - 1, weight)
        return chosen, place
