# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Numbers of a frame header.

doc/bitstream.md, beginning.
"""

import struct

from invalid_frame import require


class ByteReader:
    """Numbers one after the other; refuses to read past the end."""

    def __init__(self, source: bytes, at: int = 0) -> None:
        self._source = source
        self.at = at

    def bytes(self, size: int) -> bytes:
        require(self.at + size <= len(self._source), "the frame is cut off")
        self.at += size
        return self._source[self.at - size : self.at]

    def rest(self) -> bytes:
        return self.bytes(len(self._source) - self.at)

    def skip_to(self, wanted: bytes) -> bool:
        """Goes on to the next place of some bytes; whether there is one."""
        place = self._source.find(wanted, self.at)
        self.at = len(self._source) if place < 0 else place
        return place >= 0

    def since(self, start: int) -> bytes:
        """What was read from a place on."""
        return self._source[start : self.at]

    def numbers(self, layout: str) -> tuple:
        """Little-endian numbers by the letters of `struct`."""
        return struct.unpack("<" + layout, self.bytes(struct.calcsize("<" + layout)))

    def varint(self) -> int:
        """Seven bits a byte, the lowest first; 64 bits at most; no byte too many."""
        number = shift = 0
        while True:
            (byte,) = self.numbers("B")
            number |= (byte & 0x7F) << shift
            require(number < 1 << 64 and shift < 70, "a varint has more than 64 bits")
            if byte < 0x80:
                require(byte != 0 or shift == 0, "a varint ends with a byte 0")
                return number
            shift += 7

    def svarint(self) -> int:
        """A varint of a number with a sign."""
        return from_zigzag(self.varint())


def from_zigzag(code: int) -> int:
    """0, -1, 1, -2, 2, ... of 0, 1, 2, 3, 4, ..."""
    return -((code + 1) // 2) if code % 2 else code // 2
