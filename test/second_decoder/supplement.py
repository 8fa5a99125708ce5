# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The supplement: voxels within cells, and what the content has of voxels and points.

doc/bitstream_supplement.md; each class of this file holds one of its sections. Sections
"Numbers" and "Fields" are in supplement_numbers.py and fields.py.
"""

from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Sequence, Tuple

from byte_reader import ByteReader
from coded_frame import Voxels
from fields import FieldMemory, Points, decode_field
from frame_header import Content, FrameHeader
from invalid_frame import require
from morton import neighbours
from supplement_numbers import Models, NumberReader

Colour = Tuple[int, int, int]
"""Red, green, blue."""

_LONGEST_ABSENCE = 8


@dataclass(frozen=True)
class SupplementMemory:
    """What is kept from frame to frame since the last I-frame."""

    models: Models = field(default_factory=Models)
    means: Dict[int, Tuple[Colour, int]] = field(default_factory=dict)
    """By key: the mean colour in sixteenths, and the frames since the voxel's last."""
    fields: Tuple[FieldMemory, ...] = ()
    """One of each field; none before the first frame with voxels."""


class RefinementReader:
    """Section "Refinement"."""

    def __init__(self, reader: NumberReader, levels: int, effort: int) -> None:
        self._reader = reader
        self._levels = levels
        self._is_modelled = effort != 0
        self._last_single = 0

    def read(self, cells: Sequence[int], voxel_count: int) -> List[int]:
        keys: List[int] = []
        last = 0
        for cell in cells:
            last = self._reader.number("count", min(last, 15))
            require(len(keys) + last < voxel_count, "cells have too many voxels")
            bits = 3 * self._levels
            keys += self._part(cell << bits, bits, last + 1)
        require(len(keys) == voxel_count, "cells have too few voxels")
        return keys

    def _part(self, first: int, bits: int, count: int) -> List[int]:
        require(count <= 1 << bits, "a part has too many voxels")
        if count == 1:
            return [first | self._single(bits)]
        bits -= 1
        lower = self._lower_count(bits % 3, count)
        require(lower <= count, "a half has more voxels than the whole")
        keys = self._part(first, bits, lower) if lower else []
        if lower < count:
            keys += self._part(first | 1 << bits, bits, count - lower)
        return keys

    def _lower_count(self, axis: int, count: int) -> int:
        if count <= 14:
            return self._reader.number("split", axis, count)
        kind = self._reader.number("kind", axis)
        if kind < 2:
            return kind * count
        return self._reader.bits(count.bit_length())

    def _single(self, bits: int) -> int:
        if not self._is_modelled:
            return self._reader.bits(bits)
        key = 0
        same = [1, 1, 1]
        for bit in reversed(range(bits)):
            last = self._last_single >> bit & 1
            decision = self._reader.bit("single", bit, 2 * last + same[bit % 3])
            if decision != last:
                same[bit % 3] = 0
            key = 2 * key + decision
        self._last_single = self._last_single >> bits << bits | key
        return key


class ResidualReader:
    """Section "Residuals": those of one kind of value."""

    def __init__(self, reader: NumberReader, highest: int, *kind: object) -> None:
        self._reader = reader
        self._highest = highest
        self._kind = kind
        self._activity = 512

    def value(self, predicted: int) -> int:
        c = 0 if self._activity < 16 else self._activity.bit_length() - 4
        raw = max(c - 5, 0)
        number = self._reader.number("residual", *self._kind, c)
        require(number <= self._highest >> raw, "a residual is too large")
        number = number << raw | self._reader.bits(raw)
        require(number <= self._highest, "a residual is too large")
        reach = min(predicted, self._highest - predicted)
        if number > 2 * reach:
            residual = number - reach
            if predicted > reach:
                residual = -residual
        else:
            residual = -(number + 1) // 2 if number % 2 else number // 2
        self._activity += 16 * abs(residual) - self._activity // 16
        return predicted + residual


def _read_intensities(reader: NumberReader, count: int, bits: int) -> List[int]:
    """Section "Intensities"."""
    highest = (1 << bits) - 1
    residuals = ResidualReader(reader, highest, "intensity")
    mean = 8 * highest
    symbols = []
    for _ in range(count):
        symbol = residuals.value((mean + 8) // 16)
        symbols.append(symbol)
        mean += int((16 * symbol - mean) / 2)
    return symbols


def _read_point_counts(reader: NumberReader, count: int) -> List[int]:
    """Section "Numbers of points"."""
    counts: List[int] = []
    last_class = 0
    for _ in range(count):
        counts.append(reader.number("points", last_class) + 1)
        last_class = min(counts[-1].bit_length() - 1, 7)
    return counts


class ColourReader:
    """Section "Colours"."""

    def __init__(
        self, reader: NumberReader, bits: int, means: Dict[int, Tuple[Colour, int]]
    ) -> None:
        self._highest = (1 << bits) - 1
        self._residuals = [
            [ResidualReader(reader, self._highest, "colour", past, i) for i in range(3)]
            for past in range(2)
        ]
        self._means = means
        self._last: Sequence[int] = 3 * (8 << bits,)
        self._error_of_near = self._error_of_past = 256
        self._weight = 8
        self._tracked = 0

    def read(self, keys: Sequence[int], depth: Optional[int]) -> List[Colour]:
        """The colours; without a depth voxels have no neighbours."""
        found: Dict[int, Colour] = {}
        for key in keys:
            near = self._last
            if depth is not None:
                lower = [found[n] for n in neighbours(key, depth)[:3] if n in found]
                if lower:
                    near = [16 * sum(of) // len(lower) for of in zip(*lower)]
            found[key] = self._voxel(key, near)
        return list(found.values())

    def _voxel(self, key: int, near: Sequence[int]) -> Colour:
        if key not in self._means:
            return self._colour(0, near)
        past = self._means[key][0]
        w = self._weight
        colour = self._colour(
            1, [(m * w + n * (16 - w)) // 16 for m, n in zip(past, near)]
        )
        self._error_of_near += self._distance(near) - self._error_of_near // 16
        self._error_of_past += self._distance(past) - self._error_of_past // 16
        self._tracked += 1
        if self._tracked % 32 == 0:
            errors = self._error_of_near + self._error_of_past
            self._weight = 16 * self._error_of_near // errors
        return colour

    def _colour(self, past: int, prediction: Sequence[int]) -> Colour:
        channels = [0, 0, 0]
        of_green = 0
        for i, channel in enumerate((1, 0, 2)):
            predicted = (prediction[channel] + 8) // 16 + of_green
            predicted = min(max(predicted, 0), self._highest)
            channels[channel] = self._residuals[past][i].value(predicted)
            if i == 0:
                of_green = channels[channel] - predicted
        self._last = [16 * channel for channel in channels]
        return (channels[0], channels[1], channels[2])

    def _distance(self, prediction: Sequence[int]) -> int:
        return 1 + sum(abs(p - c) for p, c in zip(prediction, self._last))


def _next_means(
    means: Dict[int, Tuple[Colour, int]], keys: Sequence[int], colours: List[Colour]
) -> Dict[int, Tuple[Colour, int]]:
    after = {
        key: (mean, absent + 1)
        for key, (mean, absent) in means.items()
        if absent + 1 < _LONGEST_ABSENCE
    }
    for key, colour in zip(keys, colours):
        r, g, b = (16 * channel for channel in colour)
        if key in means:
            old = means[key][0]
            r, g, b = ((3 * m + c + 2) // 4 for m, c in zip(old, (r, g, b)))
        after[key] = ((r, g, b), 0)
    return after


class SupplementReader:
    """Reads the supplement of one frame with voxels."""

    def __init__(
        self,
        source: bytes,
        header: FrameHeader,
        content: Content,
        depth: int,
        memory: SupplementMemory,
    ) -> None:
        self._source = ByteReader(source)
        self._header = header
        self._content = content
        self._depth = depth
        self._memory = memory
        self._models = memory.models.copy()
        self._means = memory.means
        self._fields = memory.fields or tuple(FieldMemory() for _ in content.fields)
        self._fields = tuple(of_field.copy() for of_field in self._fields)

    def read(self, voxels: Voxels, symbol_bits: int) -> Voxels:
        content = self._content
        count = self._header.voxel_count
        if content.levels:
            voxels = self._read_refinement(voxels.keys)
        reader = self._number_reader(self._source.rest())
        if content.levels and symbol_bits:
            symbols = _read_intensities(reader, count, symbol_bits)
            voxels = replace(voxels, symbols=symbols)
        if content.levels and content.has_point_counts:
            counts = _read_point_counts(reader, count)
            voxels = replace(voxels, point_counts=counts)
        if content.colour_bits:
            voxels = replace(voxels, colours=self._read_colours(reader, voxels))
        if content.fields:
            voxels = replace(voxels, fields=self._read_fields(reader, voxels))
        reader.require_end()
        return voxels

    def memory(self) -> SupplementMemory:
        """That after the frame."""
        return SupplementMemory(self._models, self._means, self._fields)

    def _number_reader(self, source: bytes) -> NumberReader:
        return NumberReader(source, self._header.voxel_count, self._models)

    def _read_refinement(self, cells: Sequence[int]) -> Voxels:
        reader = self._number_reader(self._source.bytes(self._source.varint()))
        refinement = RefinementReader(
            reader, self._content.levels, self._header.effort
        )
        keys = refinement.read(cells, self._header.voxel_count)
        reader.require_end()
        return Voxels(keys, [])

    def _read_colours(self, reader: NumberReader, voxels: Voxels) -> List[Colour]:
        keys = voxels.keys
        is_refined = bool(self._content.levels)
        tracked = {} if is_refined else self._means
        colour_reader = ColourReader(reader, self._content.colour_bits, tracked)
        colours = colour_reader.read(keys, None if is_refined else self._depth)
        if not is_refined:
            self._means = _next_means(self._means, keys, colours)
        return colours

    def _read_fields(self, reader: NumberReader, voxels: Voxels) -> List[List[int]]:
        """Of each field the numbers of all points, voxel by voxel."""
        content = self._content
        require(
            not content.has_point_counts
            or sum(voxels.point_counts) == self._header.point_count,
            "the numbers of points have another sum",
        )
        points = Points(
            voxels.keys, voxels.point_counts, self._depth, content.viewpoint
        )
        return [
            decode_field(reader, described, index, points, self._fields[index])
            for index, described in enumerate(content.fields)
        ]


def decode_supplement(
    source: bytes,
    header: FrameHeader,
    content: Content,
    depth: int,
    symbol_bits: int,
    voxels: Voxels,
    memory: SupplementMemory,
) -> Tuple[Voxels, SupplementMemory]:
    """The voxels of a frame and the memory after it; `memory` stays as it is.

    `voxels` are the cells where there is a refinement.
    """
    if header.is_i_frame:
        memory = SupplementMemory()
    if not content.has_supplement or not header.voxel_count:
        require(not source, "a frame without voxels has a supplement")
        return voxels, memory
    reader = SupplementReader(source, header, content, depth, memory)
    voxels = reader.read(voxels, symbol_bits)
    return voxels, reader.memory()
