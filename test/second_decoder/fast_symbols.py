# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Symbols of occupied voxels, with effort 0.

doc/bitstream_fast.md, "Symbols".
"""

from typing import Dict, List, Tuple, Union

from coded_frame import CodedFrame
from fast_history import Statistics
from fast_models import FastModels
from invalid_frame import require
from rans import RansDecoder


def _bin_by_rule(value: int) -> int:
    """The bin of a value, were it not that of top."""
    if value < 16:
        return value
    e = value.bit_length() - 1
    return 16 + 8 * (e - 4) + (value >> (e - 3)) % 8


def _class_of(tracked: Statistics) -> Tuple[int, int]:
    """Class and lowest bin of statistics."""
    mean, deviation = tracked
    level = min(mean // 2, mean // 4 + 6, 24)
    spread = sum(deviation >= least for least in (4, 9, 16, 28))
    return 5 * level + spread, max((mean + 4) // 8 - 7, 0)


_WITHOUT_STATISTICS = 125, 0


def learn_bins(
    before: Dict[int, Statistics], bins: Dict[int, int], after: Dict[int, Statistics]
) -> None:
    """Adapts the statistics of the voxels of a frame."""
    for key, bin_index in bins.items():
        tracked = before.get(key)
        after[key] = (
            Statistics.of_first(bin_index) if tracked is None else tracked.after(bin_index)
        )


class FastSymbolReader:
    """Reads the bins of a frame's voxels and the low bits of their symbols."""

    def __init__(
        self,
        rans: RansDecoder,
        frame: CodedFrame,
        models: FastModels,
        statistics: Dict[int, Statistics],
        is_running: bool,
        *kind: str,
    ) -> None:
        self._rans = rans
        self._frame = frame
        self._models = models
        self._statistics = statistics
        """Statistics before the frame; voxels that it brings have none."""
        self._is_running = is_running
        self._kind = kind
        self._top = frame.highest_symbol
        self._top_bin = _bin_by_rule(self._top) + (self._top >= 16)

    def read(self, keys: List[int]) -> Tuple[List[int], Dict[int, int]]:
        """Symbols of the voxels, keys being ascending; and the bin of each voxel."""
        bins: Dict[int, int] = {}
        symbols: List[int] = []
        if self._is_running:
            running = Statistics.of_first(2)
            for key in keys:
                number_class, lowest = _class_of(running)
                nibble = self._nibble("running", number_class)
                bins[key] = self._bin(nibble, lowest)
                symbols.append(self._symbol(bins[key]))
                running = running.after(bins[key])
            return symbols, bins
        classes = [
            _class_of(self._statistics[key])
            if key in self._statistics
            else _WITHOUT_STATISTICS
            for key in keys
        ]
        nibbles = [
            self._nibble("symbol", number_class)
            for number_class, _ in classes
        ]
        for key, nibble, (_, lowest) in zip(keys, nibbles, classes):
            bins[key] = self._bin(nibble, lowest)
            symbols.append(self._symbol(bins[key]))
        return symbols, bins

    def _nibble(self, *name: Union[str, int]) -> int:
        return self._models.nibble(self._rans, *self._kind, *name)

    def _bin(self, nibble: int, lowest: int) -> int:
        bin_index = lowest + nibble
        if nibble == 15:
            high = self._nibble("escape_high")
            bin_index = 16 * high + self._nibble("escape_low", high)
            require(not lowest <= bin_index < lowest + 15, "a bin is escaped")
        require(bin_index <= self._top_bin, "a bin is above that of top")
        return bin_index

    def _symbol(self, bin_index: int) -> int:
        """The symbol of a bin, with its low bits."""
        if bin_index < 16:
            return bin_index
        if bin_index == self._top_bin:
            return self._top
        size = 1 + (bin_index - 16) // 8
        symbol = (8 + bin_index % 8) << size | self._rans.bits(size)
        require(symbol < self._top, "a symbol is too large")
        return symbol
