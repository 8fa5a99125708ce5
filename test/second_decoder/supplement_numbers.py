# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Models of the supplement, and the numbers that are coded with them.

doc/bitstream_supplement.md, "Numbers".
"""

from typing import Dict

from rans import BitModel, NibbleModel, RansDecoder


class Models:
    """Models by their kind and context, made when they are first used."""

    def __init__(self) -> None:
        self._nibbles: Dict[tuple, NibbleModel] = {}
        self._bits: Dict[tuple, BitModel] = {}

    def copy(self) -> "Models":
        other = Models()
        other._nibbles = {key: model.copy() for key, model in self._nibbles.items()}
        other._bits = {key: model.copy() for key, model in self._bits.items()}
        return other

    def nibble(self, *context: object) -> NibbleModel:
        return self._nibbles.setdefault(context, NibbleModel())

    def bit(self, *context: object) -> BitModel:
        return self._bits.setdefault(context, BitModel())


class NumberReader:
    """Section "Numbers"."""

    def __init__(self, source: bytes, voxel_count: int, models: Models) -> None:
        self.rans = RansDecoder(source, voxel_count)
        self.models = models

    def number(self, *context: object) -> int:
        low = self.models.nibble(*context).read(self.rans)
        if low < 15:
            return low
        length = 2 * self.models.nibble("lengths").read(self.rans) + self.bits(1)
        return ((1 << length) | self.bits(length)) + 14

    def bits(self, size: int) -> int:
        number = 0
        while size > 0:
            part = min(size, 12)
            number = number << part | self.rans.bits(part)
            size -= part
        return number

    def bit(self, *context: object) -> int:
        return self.models.bit(*context).read(self.rans)

    def require_end(self) -> None:
        self.rans.require_end()
