"""Symbols of occupied voxels, with effort 0.

doc/bitstream_fast.md, "Symbols".
"""

from typing import Dict, List, Tuple

from coded_frame import CodedFrame
from fast_history import Moment
from fast_models import FastModels
from invalid_frame import require
from rans import RansDecoder


def _step_by_rule(value: int) -> int:
    """The step of a value, were it not that of top."""
    if value < 16:
        return value
    e = value.bit_length() - 1
    return 16 + 8 * (e - 4) + (value >> (e - 3)) % 8


def _class_of(moment: Moment) -> Tuple[int, int]:
    """Class and lowest step of a moment."""
    mean, deviation = moment
    level = min(mean // 2, mean // 4 + 6, 24)
    spread = sum(deviation >= least for least in (4, 9, 16, 28))
    return 5 * level + spread, max((mean + 4) // 8 - 7, 0)


_WITHOUT_MOMENT = 125, 0


class FastSymbolReader:
    """Reads the steps of a frame's voxels and the low bits of their symbols."""

    def __init__(
        self,
        rans: RansDecoder,
        frame: CodedFrame,
        models: FastModels,
        moments: Dict[int, Moment],
    ) -> None:
        self._rans = rans
        self._frame = frame
        self._models = models
        self._moments = moments
        """Moments before the frame; voxels that it brings have none."""
        self._top = frame.highest_symbol
        self._top_step = _step_by_rule(self._top) + (self._top >= 16)

    def read(self, keys: List[int]) -> Tuple[List[int], Dict[int, int]]:
        """Symbols of the voxels, keys being ascending; and the step of each voxel."""
        steps: Dict[int, int] = {}
        symbols: List[int] = []
        if self._frame.is_i_frame:
            running = Moment.of_first(2)
            for key in keys:
                number_class, lowest = _class_of(running)
                nibble = self._models.nibble(self._rans, "running", number_class)
                steps[key] = self._step(nibble, lowest)
                symbols.append(self._symbol(steps[key]))
                running = running.after(steps[key])
            return symbols, steps
        classes = [
            _class_of(self._moments[key]) if key in self._moments else _WITHOUT_MOMENT
            for key in keys
        ]
        nibbles = [
            self._models.nibble(self._rans, "symbol", number_class)
            for number_class, _ in classes
        ]
        for key, nibble, (_, lowest) in zip(keys, nibbles, classes):
            steps[key] = self._step(nibble, lowest)
            symbols.append(self._symbol(steps[key]))
        return symbols, steps

    def _step(self, nibble: int, lowest: int) -> int:
        step = lowest + nibble
        if nibble == 15:
            high = self._models.nibble(self._rans, "escape_high")
            step = 16 * high + self._models.nibble(self._rans, "escape_low", high)
            require(not lowest <= step < lowest + 15, "a step is coded the long way")
        require(step <= self._top_step, "a step is above that of the highest symbol")
        return step

    def _symbol(self, step: int) -> int:
        """The symbol of a step, with its low bits."""
        if step < 16:
            return step
        if step == self._top_step:
            return self._top
        size = 1 + (step - 16) // 8
        symbol = (8 + step % 8) << size | self._rans.bits(size)
        require(symbol < self._top, "a symbol is too large")
        return symbol
