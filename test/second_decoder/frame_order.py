# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Which frames are dropped because they come late or again.

doc/bitstream.md, "Old frames"; of an input that ends nothing comes after it here.
"""

from typing import List, Optional, Tuple

from invalid_frame import InvalidFrame

_KNOWN_FRAMES = 256
_NUMBERS = 1 << 32
_Frame = Tuple[int, int]
"""Number and checksum."""


class FrameOrder:
    """Tells old frames from new ones."""

    def __init__(self) -> None:
        self._last: Optional[_Frame] = None
        self._known: List[_Frame] = []
        self._old_in_a_row = 0

    def require_new(self, number: int, checksum: int, is_i_frame: bool) -> None:
        """Refuses an old frame that is not to be decoded."""
        if self._last is None or number == (self._last[0] + 1) % _NUMBERS:
            return
        frame = (number, checksum)
        is_copy = frame in self._known
        is_above = 0 < (number - self._last[0]) % _NUMBERS < 1 << 31
        if is_above and not is_copy:
            return
        if is_i_frame:
            least_old = 24 if is_copy else 0 if number == 1 else 2
            if frame == self._last or self._old_in_a_row >= least_old:
                return
        self._old_in_a_row += 1
        raise InvalidFrame("the frame is old")

    def decoded(self, number: int, checksum: int, is_identifiable: bool) -> None:
        """A frame was decoded; without voxels and stamp it has no known copies."""
        self._last = (number, checksum)
        self._old_in_a_row = 0
        if is_identifiable:
            self._known = self._known[1 - _KNOWN_FRAMES :] + [self._last]
