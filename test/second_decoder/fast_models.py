"""All models of effort 0 by name and number, as at the start until they are used.

doc/bitstream_fast.md; names are those of the description.
"""

from typing import Dict, Tuple, Union

from rans import BitModel, NibbleModel, QuadModel, RansDecoder

_Name = Tuple[Union[str, int], ...]


class FastModels:
    """What effort 0 learns since the last I-frame, but for the history."""

    def __init__(self) -> None:
        self._nibbles: Dict[_Name, NibbleModel] = {}
        self._quads: Dict[int, QuadModel] = {}
        self.has_new_blocks = BitModel()

    def copy(self) -> "FastModels":
        """Models that learn without changing these."""
        other = FastModels.__new__(FastModels)
        other._nibbles = {name: model.copy() for name, model in self._nibbles.items()}
        other._quads = {name: model.copy() for name, model in self._quads.items()}
        other.has_new_blocks = self.has_new_blocks.copy()
        return other

    def nibble(self, rans: RansDecoder, *name: Union[str, int]) -> int:
        """A nibble with nibble model name[0][name[1]]..."""
        return self._nibbles.setdefault(name, NibbleModel()).read(rans)

    def byte(
        self, rans: RansDecoder, *name: Union[str, int], low_model: int = 0
    ) -> int:
        """A byte with byte models: the low nibble chooses the high one's model."""
        low = self.nibble(rans, *name, "low", low_model)
        return 16 * self.nibble(rans, *name, "high", low) + low

    def four(self, rans: RansDecoder, low_class: int) -> "list[int]":
        """Four numbers 0..3 with quad[low_class]."""
        return self._quads.setdefault(low_class, QuadModel()).read(rans)
