# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The payload of effort 0, with residuals where there is a depth model.

doc/bitstream_fast.md; "Classed rows" and "Residuals" are in this file.
"""

from dataclasses import dataclass, replace
from typing import Dict, List, Tuple

from byte_reader import ByteReader, from_zigzag
from coded_frame import CodedFrame, Voxels, counts_of_symbols
from depth_model import has_residual, predicted_symbol
from fast_history import FastHistory
from fast_models import FastModels
from fast_occupancy import FastOccupancyReader, history_with
from fast_symbols import FastSymbolReader, learn_bins
from invalid_frame import require
from rans import RansDecoder


@dataclass(frozen=True)
class FastMemory:
    """What is kept from frame to frame since the last I-frame."""

    history: FastHistory
    models: FastModels
    models_of_rests: FastModels

    @staticmethod
    def at_start() -> "FastMemory":
        return FastMemory(FastHistory(), FastModels(), FastModels())


def _decode_base_symbols(
    source: bytes, frame: CodedFrame, memory: FastMemory
) -> Tuple[Voxels, FastMemory]:
    """Voxels with base symbols: numbers of points where there is a depth model."""
    models = memory.models.copy()
    rans = RansDecoder(source, frame.voxel_count)
    is_history_used = not frame.is_i_frame and rans.bits(1)
    is_history_kept = not frame.is_i_frame and (is_history_used or rans.bits(1))
    before = memory.history if is_history_used else FastHistory()
    shares = memory.history.shares
    reader = FastOccupancyReader(rans, frame, models, before, not is_history_used)
    occupancy = reader.read()
    keys = sorted(occupancy.tracked + occupancy.brought)
    symbols: List[int] = []
    bins: Dict[int, int] = {}
    point_bins: Dict[int, int] = {}
    counts: List[int] = []
    if frame.symbol_bits:
        symbol_reader = FastSymbolReader(
            rans, frame, models, before.statistics, not is_history_used
        )
        symbols, bins = symbol_reader.read(keys)
        point_symbols = symbols
        if frame.has_intensities and frame.has_points:
            point_reader = FastSymbolReader(
                rans,
                frame.of_points(),
                models,
                occupancy.history.kept_point_statistics(before),
                not is_history_used,
                "points",
            )
            point_symbols, point_bins = point_reader.read(keys)
        if frame.has_points:
            counts = counts_of_symbols(point_symbols, lambda: _excess(rans))
    rans.require_end()
    history = occupancy.history
    if is_history_kept and not is_history_used:
        before = memory.history
        history = history_with(before, keys)
    elif not is_history_used:
        history.shares = {} if frame.is_i_frame else dict(shares)
    history.point_statistics = history.kept_point_statistics(before)
    learn_bins(before.statistics, bins, history.statistics)
    learn_bins(before.point_statistics, point_bins, history.point_statistics)
    voxels = Voxels(keys, symbols if frame.has_intensities else [], [], counts)
    return voxels, replace(memory, history=history, models=models)


def _excess(rans: RansDecoder) -> int:
    """Section "Excess"."""
    left = rans.bits(5)
    u = 1
    while left:
        part = min(left, 12)
        u = u << part | rans.bits(part)
        left -= part
    return u - 1


def _classed_row(source: bytes, classes: List[int], models: FastModels) -> List[int]:
    """Section "Classed rows"."""
    rans = RansDecoder(source, len(classes))
    row = []
    for number_class in classes:
        number = models.nibble(rans, "number", number_class)
        if number == 15:
            b = models.nibble(rans, "length")
            u = 1
            for size in (max(b - 8, 0), min(b, 8)):
                if size:
                    u = u << size | rans.bits(size)
            number = u + 14
            require(number < 1 << 16, "a number of a row is too large")
        row.append(number)
    rans.require_end()
    return row


def _decode_with_rests(
    source: bytes, frame: CodedFrame, memory: FastMemory
) -> Tuple[Voxels, FastMemory]:
    """Section "Residuals"."""
    model = frame.depth_model
    assert model is not None
    reader = ByteReader(source)
    size = reader.varint()
    base, memory = _decode_base_symbols(reader.bytes(size), frame, memory)
    exact = {}
    for key, base_symbol in zip(base.keys, base.symbols):
        w = model.point_at_centre(key)
        if has_residual(w):
            exact[key] = base_symbol * w
    classes = []
    for e in exact.values():
        length = min(e >> 17, 127).bit_length()
        classes.append(4 * (max(length, 4) - 4) + (e >> 14) % 4)
    models = memory.models_of_rests.copy()
    row = _classed_row(source[reader.at :], classes, models)
    symbols = dict(zip(base.keys, base.symbols))
    for key, residual in zip(exact, row):
        predicted = predicted_symbol(exact[key], frame.highest_symbol)
        symbol = predicted + from_zigzag(residual)
        require(0 <= symbol <= frame.highest_symbol, "a symbol is out of its range")
        symbols[key] = symbol
    return (
        replace(base, symbols=list(symbols.values())),
        replace(memory, models_of_rests=models),
    )


def decode_fast_payload(
    source: bytes, frame: CodedFrame, memory: FastMemory
) -> Tuple[Voxels, FastMemory]:
    """The voxels of a frame and the memory after it; `memory` stays as it is."""
    if frame.is_i_frame:
        memory = FastMemory.at_start()
    if not frame.voxel_count:
        return Voxels([], []), memory
    if frame.depth_model is None:
        return _decode_base_symbols(source, frame, memory)
    return _decode_with_rests(source, frame, memory)
