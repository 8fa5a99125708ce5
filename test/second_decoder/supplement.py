"""The supplement: voxels within cells, and what the content has of voxels and points.

doc/bitstream_supplement.md; each class of this file holds one of its sections. Sections
"Numbers", "Fields" and "Image" are in supplement_numbers.py, fields.py and image.py.
"""

from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Sequence, Tuple

from coded_frame import Voxels
from fields import AnyPoints, FieldMemory, PixelPoints, Points, decode_field
from frame_header import ByteReader, Content, FrameHeader, Image
from image import ImageReader
from invalid_frame import require
from morton import neighbours, node_at
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
    past: Dict[int, int] = field(default_factory=dict)
    """Of pixels of an image."""


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

    def read_image(self, voxels: Voxels, width: int) -> List[Colour]:
        """The colours where the voxels are those of an image."""
        of_pixel: Dict[int, int] = {}
        first_pixels = []
        pixels = iter(voxels.image[2::2])
        for voxel, count in enumerate(voxels.point_counts):
            of_voxel = [next(pixels) for _ in range(count)]
            first_pixels.append((of_voxel[0], voxel))
            of_pixel.update((pixel, voxel) for pixel in of_voxel)
        found: Dict[int, Colour] = {}
        for pixel, voxel in sorted(first_pixels):
            column = pixel % width
            beside = (
                of_pixel.get(pixel - 1) if column else None,
                of_pixel.get(pixel - width),
                of_pixel.get(pixel - width - 1) if column else None,
            )
            left, up, corner = (None if v is None else found[v] for v in beside)
            found[voxel] = self._colour(0, self._near(left, up, corner))
        return [colour for _, colour in sorted(found.items())]

    def _near(
        self, left: Optional[Colour], up: Optional[Colour], corner: Optional[Colour]
    ) -> Sequence[int]:
        left, up = left or up, up or left
        if left is None or up is None:
            return self._last
        near = []
        for one, other, plane in zip(left, up, corner or up):
            low, high = sorted((one, other))
            near.append(16 * min(max(one + other - plane, low), high))
        return near

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


def _in_order_of_voxels(
    pixels: Sequence[int], content: Content, numbers: List[List[int]]
) -> List[List[int]]:
    """Numbers in the order of the voxels of those in the order of the pixels."""
    places = {pixel: place for place, pixel in enumerate(sorted(pixels))}
    ordered = []
    for described, of_field in zip(content.fields, numbers):
        n = described.value_count
        ordered.append(
            [x for pixel in pixels for x in of_field[places[pixel] * n :][:n]]
        )
    return ordered


def _read_image(
    reader: NumberReader, image: Image, header: FrameHeader, depth: int, past: dict
) -> Tuple[Voxels, Dict[int, int]]:
    """The voxels of the points of an image, and the past of its pixels after it."""
    image_reader = ImageReader(reader, image, depth, past)
    points, past = image_reader.read(header.point_count)
    of_keys: Dict[Optional[int], List[int]] = {}
    for pixel, point in points.items():
        x, y, z = point.position
        of_keys.setdefault(node_at((x, y, z), depth), []).append(pixel)
    require(len(of_keys) == header.voxel_count, "an image has other voxels")
    voxels = Voxels([], [], image=[image.width, image.height])
    for key, pixels in sorted(of_keys.items()):
        voxels.keys.append(key)
        voxels.point_counts.append(len(pixels))
        for pixel in pixels:
            voxels.image.extend((pixel, points[pixel].depth))
    return voxels, past


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
    image = content.image
    if not content.has_supplement or not header.voxel_count:
        require(not source, "a frame without voxels has a supplement")
        if image is not None:
            voxels = replace(voxels, image=[image.width, image.height])
        return voxels, memory
    models = memory.models.copy()
    count = header.voxel_count
    past = memory.past
    if content.has_voxels:
        bytes_left = ByteReader(source)
        part = bytes_left.bytes(bytes_left.varint())
        reader = NumberReader(part, count, models)
        if image is not None:
            voxels, past = _read_image(reader, image, header, depth, past)
        else:
            refinement = RefinementReader(reader, content.levels, header.effort)
            voxels = Voxels(refinement.read(voxels.keys, count), [])
        reader.require_end()
        source = source[bytes_left.at :]
    reader = NumberReader(source, count, models)
    if content.has_voxels and symbol_bits:
        voxels = replace(voxels, symbols=_read_intensities(reader, count, symbol_bits))
    if content.levels and content.has_point_counts:
        counts = _read_point_counts(reader, count)
        voxels = replace(voxels, point_counts=counts)
    means = memory.means
    if content.colour_bits:
        tracked = {} if content.has_voxels else means
        colour_reader = ColourReader(reader, content.colour_bits, tracked)
        if image is not None:
            colours = colour_reader.read_image(voxels, image.width)
        else:
            colours = colour_reader.read(voxels.keys, None if content.levels else depth)
        voxels = replace(voxels, colours=colours)
        if not content.has_voxels:
            means = _next_means(means, voxels.keys, colours)
    fields = memory.fields
    if content.fields:
        require(
            not content.has_point_counts
            or sum(voxels.point_counts) == header.point_count,
            "the numbers of points have another sum",
        )
        points: AnyPoints
        if image is not None:
            points = PixelPoints(voxels.image[2::2], image.width)
        else:
            points = Points(voxels.keys, voxels.point_counts, depth, content.viewpoint)
        fields = tuple(of_field.copy() for of_field in fields)
        fields = fields or tuple(FieldMemory() for _ in content.fields)
        numbers = [
            decode_field(reader, described, index, points, fields[index])
            for index, described in enumerate(content.fields)
        ]
        if image is not None:
            numbers = _in_order_of_voxels(voxels.image[2::2], content, numbers)
        voxels = replace(voxels, fields=numbers)
    reader.require_end()
    return voxels, SupplementMemory(models, means, fields, past)
