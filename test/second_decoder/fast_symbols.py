"""Symbols of occupied voxels, with effort 0.

doc/bitstream_fast.md, "Symbols".
"""

from typing import Dict, List, Optional, Tuple

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
    lowest = max((mean + 4) // 8 - 7, 0)
    if lowest > 0:
        level = 24
    else:
        level = mean // 2 if mean < 24 else 12 + (mean - 24) // 4
    spread = sum(deviation >= least for least in (4, 9, 16, 28))
    return 5 * level + spread, lowest


class FastSymbolReader:
    """Reads the steps of a frame's voxels and the low bits of their values."""

    def __init__(
        self,
        rans: RansDecoder,
        frame: CodedFrame,
        models: FastModels,
        moments: Dict[int, Moment],
        few: bool,
    ) -> None:
        self._rans = rans
        self._frame = frame
        self._models = models
        self._moments = moments
        """Moments before the frame; voxels that it brings have none."""
        self._few = few
        self.is_plain = rans.bits(1) == 1
        self._origin = 0 if self.is_plain else rans.bits(1)
        self._top = frame.highest_symbol - self._origin
        self._top_step = _step_by_rule(self._top) + (self._top >= 16)
        self._steps: Dict[int, int] = {}
        self._values: Dict[int, int] = {}

    def read(self, keys: List[int]) -> Tuple[List[int], Dict[int, int]]:
        """Symbols of the voxels, keys being ascending; and the step of each voxel, of
        which there are none if they are plain."""
        if self.is_plain:
            return [self._plain_symbol() for _ in keys], {}
        fours: List[List[int]] = []
        second: List[int] = []
        third: List[int] = []
        for low_class in range(4):
            of_class = [key for key in keys if self._low_class(key) == low_class]
            in_fours = len(of_class) // 4 * 4
            fours.append(of_class[:in_fours])
            if low_class < 3:
                second += reversed(of_class[in_fours:])
            else:
                third = of_class[in_fours:]
        high = [key for key in keys if self._low_class(key) is None]
        second = [key for key in high if key in self._moments] + second
        third = sorted(third + [key for key in high if key not in self._moments])
        for low_class, of_class in enumerate(fours):
            self._read_fours(low_class, of_class)
        late = [key for key in second if self._read_with_moment(key)]
        self._read_without_moment(third)
        for low_class, of_class in enumerate(fours):
            for key in of_class:
                self._read_rest_of_four(low_class, key)
        for key in late:
            self._read_rest_with_moment(key)
        require(
            self._origin == 1 or 0 in self._values.values(),
            "whether a symbol is 0 is not as the origin says",
        )
        return [self._values[key] + self._origin for key in keys], self._steps

    def _plain_symbol(self) -> int:
        """A byte of high bits, then the others."""
        low_bits = max(self._frame.symbol_bits - 8, 0)
        symbol = self._models.byte(self._rans, "plain")
        if low_bits:
            symbol = symbol << low_bits | self._rans.bits(low_bits)
        require(symbol <= self._frame.highest_symbol, "a symbol has too many bits")
        return symbol

    def _low_class(self, key: int) -> Optional[int]:
        moment = self._moments.get(key)
        if moment is None:
            return 3 if self._few and not self._frame.is_i_frame else None
        if moment.mean >= 16:
            return None
        return 0 if moment.mean < 4 else 1 if moment.mean < 10 else 2

    def _set_step(self, key: int, step: int) -> None:
        require(step <= self._top_step, "a step is above that of the highest symbol")
        self._steps[key] = step
        if step < 16:
            self._values[key] = step

    def _whole_step(self) -> int:
        high = self._models.nibble(self._rans, "escape_high")
        return 16 * high + self._models.nibble(self._rans, "escape_low", high)

    def _read_low_bits(self, key: int) -> None:
        step = self._steps[key]
        if step < 16:
            return
        if step == self._top_step:
            self._values[key] = self._top
            return
        size = 1 + (step - 16) // 8
        value = (8 + step % 8) << size | self._rans.bits(size)
        require(value < self._top, "a symbol is too large")
        self._values[key] = value

    def _read_fours(self, low_class: int, keys: List[int]) -> None:
        for first in range(0, len(keys), 4):
            four = self._models.four(self._rans, low_class)
            for key, number in zip(keys[first : first + 4], four):
                self._set_step(key, number)

    def _read_with_moment(self, key: int) -> bool:
        """Whether more of the voxel follows late."""
        number_class, lowest = _class_of(self._moments[key])
        nibble = self._models.nibble(self._rans, "known_symbol", number_class)
        if nibble == 15:
            return True
        self._set_step(key, lowest + nibble)
        return self._steps[key] >= 16

    def _read_without_moment(self, keys: List[int]) -> None:
        f = int(self._frame.is_i_frame)
        running = Moment.of_first(2)
        for key in keys:
            number_class, lowest = _class_of(running)
            nibble = self._models.nibble(self._rans, "new_symbol", f, number_class)
            if nibble < 15:
                self._set_step(key, lowest + nibble)
            else:
                self._set_step(key, self._whole_step_but_of(lowest))
            self._read_low_bits(key)
            running = running.after(self._steps[key])

    def _whole_step_but_of(self, lowest: int) -> int:
        step = self._whole_step()
        require(not lowest <= step < lowest + 15, "a step is coded the long way")
        return step

    def _read_rest_of_four(self, low_class: int, key: int) -> None:
        if self._steps[key] < 3:
            return
        nibble = self._models.nibble(self._rans, "quad_escape", low_class)
        step = 3 + nibble
        if nibble == 15:
            step = self._whole_step()
            require(step >= 18, "a step is coded the long way")
        self._set_step(key, step)
        self._read_low_bits(key)

    def _read_rest_with_moment(self, key: int) -> None:
        if key not in self._steps:
            _, lowest = _class_of(self._moments[key])
            self._set_step(key, self._whole_step_but_of(lowest))
        self._read_low_bits(key)
