# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The payload of efforts 1 and 2 (doc/bitstream_context.md)."""

from dataclasses import dataclass, replace
from typing import Dict, List

from coded_frame import (
    MOST_VOXELS,
    POINT_SYMBOL_BITS,
    CodedFrame,
    Voxels,
    counts_of_symbols,
)
from context_frame import Kinds, Payload
from context_history import ContextHistory, SeenVoxel
from context_symbols import BaseSymbols, Symbols
from context_voxels import read_voxels
from invalid_frame import require
from range_coder import RangeDecoder


@dataclass(frozen=True)
class ContextMemory:
    """What is kept from frame to frame since the last I-frame."""

    history: ContextHistory
    kinds: Kinds
    point_history: ContextHistory
    point_kinds: Kinds
    """Of point symbols after intensities."""

    @staticmethod
    def at_start(effort: int) -> "ContextMemory":
        return ContextMemory(
            ContextHistory(), Kinds(effort), ContextHistory(), Kinds(effort)
        )


MOST_RECORDS = min(8 * MOST_VOXELS + (1 << 16), 2 * MOST_VOXELS + (1 << 20))
"""See "History"; a P-frame's history may be larger only behind larger limits."""


def decode_context_payload(
    bytes_of_payload: bytes, frame: CodedFrame, memory: ContextMemory
) -> "tuple[Voxels, ContextMemory]":
    """The voxels of a frame and the memory after it; `memory` stays as it is.

    A frame without voxels has an empty payload.
    """
    if frame.is_i_frame:
        memory = ContextMemory.at_start(frame.effort)
    history = memory.history
    require(len(history.records) <= MOST_RECORDS, "the history is too large")
    point_history = memory.point_history
    is_replaced = frame.is_i_frame
    kinds, point_kinds = memory.kinds.copy(), memory.point_kinds.copy()
    keys: List[int] = []
    symbols: Dict[int, int] = {}
    seen: Dict[int, SeenVoxel] = {}
    point_symbols: Dict[int, int] = {}
    counts: List[int] = []
    if frame.voxel_count:
        bits = RangeDecoder(bytes_of_payload)
        coding_history, coding_points = history, point_history
        if not frame.is_i_frame and not bits.bypass_bit():
            coding_history = coding_points = ContextHistory()
            if not bits.bypass_bit():
                history = point_history = ContextHistory()
                is_replaced = True
        payload = Payload(
            frame, bits, kinds, coding_history, coding_history.tracked_cells()
        )
        keys = read_voxels(payload)
        base_symbols = dict.fromkeys(keys, 0)
        if frame.symbol_bits:
            base_symbols = BaseSymbols(payload).read(keys)
        reader = Symbols(payload)
        symbols = reader.read(keys, base_symbols)
        seen = reader.seen
        if frame.has_points:
            if frame.has_intensities:
                payload = replace(
                    payload,
                    frame=frame.of_points(),
                    kinds=point_kinds,
                    history=coding_points,
                )
                point_symbols = BaseSymbols(payload).read(keys)
            counts = counts_of_symbols(
                [(point_symbols or symbols)[key] for key in keys],
                lambda: payload.escape(31),
            )
        bits.require_end()
    has_model = frame.depth_model is not None
    after = history.after_frame(seen, is_replaced, frame.symbol_bits, has_model)
    point_after = point_history.after_frame(
        {key: SeenVoxel(symbol, 0, 0) for key, symbol in point_symbols.items()},
        is_replaced,
        POINT_SYMBOL_BITS,
        False,
    )
    coded = [symbols[key] for key in keys] if frame.has_intensities else []
    return (
        Voxels(keys, coded, [], counts),
        ContextMemory(after, kinds, point_after, point_kinds),
    )
