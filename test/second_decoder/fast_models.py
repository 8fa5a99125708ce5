# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""All models of effort 0 by name and number, as at the start until they are used.

doc/bitstream_fast.md; names are those of the description.
"""

from typing import Dict, Tuple, Union

from rans import NibbleModel, RansDecoder

_Name = Tuple[Union[str, int], ...]


class FastModels:
    """What effort 0 learns since the last I-frame, except for the history."""

    def __init__(self) -> None:
        self._nibbles: Dict[_Name, NibbleModel] = {}

    def copy(self) -> "FastModels":
        """Models that learn without changing these."""
        other = FastModels.__new__(FastModels)
        other._nibbles = {name: model.copy() for name, model in self._nibbles.items()}
        return other

    def nibble(self, rans: RansDecoder, *name: Union[str, int]) -> int:
        """A nibble with nibble model name[0][name[1]]..."""
        return self._nibbles.setdefault(name, NibbleModel()).read(rans)

    def mask(self, rans: RansDecoder, name: str, likely: int) -> int:
        """A mask of eight children with a mask model."""
        low = self.nibble(rans, name, "low", likely & 15)
        others = min((likely >> 4).bit_count(), 3)
        return 16 * self.nibble(rans, name, "high", low + 16 * others) + low

    def node(self, rans: RansDecoder, likely: int, upper: int) -> int:
        """A mask of eight children of a node, whose neighbours above are known."""
        low = self.nibble(rans, "node", "low", (likely & 15) + 16 * (upper & 3))
        others = min((likely >> 4).bit_count(), 3)
        context = low + 16 * others + 64 * upper
        return 16 * self.nibble(rans, "node", "high", context) + low
