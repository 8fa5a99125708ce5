# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Frames of a stream one after the other, and what is kept between them.

doc/bitstream.md, "Payload", "State of a decoder" and "What a decoder may refuse".
"""

from dataclasses import dataclass, replace
from typing import Optional, Union

from byte_reader import ByteReader
from changes_payload import ChangesMemory, decode_changes
from coded_frame import MOST_VOXELS, POINT_SYMBOL_BITS, CodedFrame, Voxels
from context_payload import ContextMemory, decode_context_payload
from depth_model import DepthModel, read_depth_model
from fast_payload import FastMemory, decode_fast_payload
from frame_header import (
    MAGIC,
    Content,
    FrameHeader,
    Grid,
    IntensityScale,
    Layout,
    read_header,
    require_checksum,
)
from frame_order import FrameOrder
from invalid_frame import InvalidFrame, require
from scan import ScanLayout, ScanMemory, decode_scan
from scan_header import ORGANISED, ScanTable
from scan_points import CloudPoints, cloud_of
from supplement import SupplementMemory, decode_supplement

MOST_BYTES = 16 << 20
MOST_FIELD_VALUES = 1 << 24


@dataclass(frozen=True)
class Kept:
    """What a decoder keeps of the frames so far."""

    number: int
    checksum: int
    grid: Grid
    scale: IntensityScale
    content: Content
    effort: int
    depth_model: Optional[DepthModel]
    stamp: int
    frame_id: bytes
    memory: Union[ContextMemory, FastMemory]
    supplement_memory: SupplementMemory
    changes_memory: ChangesMemory
    scan_memory: ScanMemory


def _memory_at_start(effort: int) -> Union[ContextMemory, FastMemory]:
    return FastMemory.at_start() if effort == 0 else ContextMemory.at_start(effort)


@dataclass(frozen=True)
class Frame:
    """A decoded frame."""

    is_i_frame: bool
    number: int
    grid: Grid
    scale: IntensityScale
    stamp: Optional[int]
    frame_id: bytes
    voxels: Voxels
    """None of a scan."""
    points: Optional[CloudPoints] = None
    """Of a scan."""
    layout: Optional[Layout] = None
    """Of messages."""


class FrameDecoder:
    """Decodes frames in the order of the stream."""

    def __init__(self) -> None:
        self._kept: Optional[Kept] = None
        self._order = FrameOrder()

    def decode(self, reader: ByteReader) -> Frame:
        """The frame at the reader. One that fails changes nothing, but that old ones are
        counted."""
        start = reader.at
        header = read_header(reader)
        require(header.payload_size <= MOST_BYTES, "the payload is too large")
        require(header.voxel_count <= MOST_VOXELS, "there are too many voxels")
        payload = reader.bytes(header.payload_size)
        depended_on = 0
        if not header.is_i_frame:
            self._require_new(header)
            depended_on = self._frame_before(header).checksum
        require_checksum(header, reader.since(start), depended_on)
        if header.is_i_frame:
            self._require_new(header)
        kept = self._with_header(header)
        content = kept.content
        points = header.point_count if content.has_point_counts else header.voxel_count
        if content.scan and content.scan.order == ORGANISED:
            points = content.scan.pixel_count
        values = points * sum(field.value_count for field in content.fields)
        require(values <= MOST_FIELD_VALUES, "there are too many values of fields")
        frame = self._with_payload(header, kept, payload)
        self._order.decoded(
            header.number,
            header.checksum,
            bool(header.voxel_count) or header.stamp is not None,
        )
        return frame

    def next_frame(self, reader: ByteReader) -> Optional[Frame]:
        """The next frame that decodes, wherever it begins after the reader."""
        while reader.skip_to(MAGIC):
            begin = reader.at
            try:
                return self.decode(reader)
            except InvalidFrame:
                reader.at = begin + 1
        return None

    def _require_new(self, header: FrameHeader) -> None:
        self._order.require_new(header.number, header.checksum, header.is_i_frame)

    def _frame_before(self, header: FrameHeader) -> Kept:
        if self._kept is None or (self._kept.number + 1) % (1 << 32) != header.number:
            raise InvalidFrame("the frame before this P-frame is missing")
        return self._kept

    def _with_header(self, header: FrameHeader) -> Kept:
        """What is to be kept of the header; depth model and memory are as before."""
        if header.is_i_frame:
            assert header.grid is not None and header.scale is not None
            return Kept(
                header.number,
                header.checksum,
                header.grid,
                header.scale,
                header.content,
                header.effort,
                None,
                header.stamp or 0,
                header.frame_id or b"",
                _memory_at_start(header.effort),
                SupplementMemory(),
                ChangesMemory(),
                ScanMemory(),
            )
        kept = self._frame_before(header)
        require(header.effort == kept.effort, "a P-frame has another effort")
        colour_bits = kept.content.colour_bits if header.content.colour_bits else 0
        has_intensities = kept.content.has_intensities
        require(
            header.is_of_changes
            or replace(
                header.content,
                colour_bits=colour_bits,
                has_intensities=has_intensities,
                fields=kept.content.fields,
                viewpoint=kept.content.viewpoint,
                scan=kept.content.scan,
                layout=kept.content.layout,
                has_placement=False,
            )
            == kept.content,
            "a P-frame has another content",
        )
        content = kept.content
        if header.placement is not None:
            assert content.scan is not None
            content = replace(content, scan=content.scan.placed(header.placement))
        return replace(
            kept,
            number=header.number,
            checksum=header.checksum,
            content=content,
            stamp=(kept.stamp + (header.stamp or 0)) % (1 << 64),
            frame_id=kept.frame_id if header.frame_id is None else header.frame_id,
        )

    def _with_payload(self, header: FrameHeader, kept: Kept, payload: bytes) -> Frame:
        if header.is_of_changes:
            voxels, changes_memory = decode_changes(
                payload,
                kept.grid.depth,
                kept.scale.bits,
                header.voxel_count,
                kept.changes_memory,
            )
            self._kept = replace(kept, changes_memory=changes_memory)
            return self._frame(header, kept, voxels)
        unpadded = len(payload) - header.padding_size
        require(not any(payload[unpadded:]), "padding has other bytes than 0")
        payload = payload[:unpadded]
        if kept.content.scan is not None:
            return self._with_scan(header, kept, kept.content.scan, payload)
        model = kept.depth_model
        if header.has_depth_model:
            require(
                header.is_i_frame or model is not None, "the I-frame has no depth model"
            )
            reader = ByteReader(payload)
            model = read_depth_model(reader)
            payload = payload[reader.at :]
            require(
                kept.content.has_intensities and not kept.content.levels,
                "a depth model without intensities",
            )
        require(header.supplement_size <= len(payload), "the supplement is too large")
        supplement = payload[len(payload) - header.supplement_size :]
        payload = payload[: len(payload) - header.supplement_size]
        require(header.voxel_count <= 8**kept.grid.depth, "the grid has fewer voxels")
        levels = kept.content.levels
        coded_count = header.coarse_voxel_count if levels else header.voxel_count
        require(bool(coded_count) or not payload, "a frame without voxels has a payload")
        has_intensities = kept.content.has_intensities and not levels
        has_points = kept.content.has_point_counts and not levels
        symbol_bits = POINT_SYMBOL_BITS if has_points else 0
        coded = CodedFrame(
            header.is_i_frame,
            kept.effort,
            coded_count,
            kept.scale.bits if has_intensities else symbol_bits,
            kept.grid.depth - levels,
            model,
            has_intensities,
            has_points,
        )
        memory: Union[ContextMemory, FastMemory]
        if isinstance(kept.memory, FastMemory):
            voxels, memory = decode_fast_payload(payload, coded, kept.memory)
        else:
            voxels, memory = decode_context_payload(payload, coded, kept.memory)
        voxels, supplement_memory = decode_supplement(
            supplement,
            header,
            kept.content,
            kept.grid.depth,
            kept.scale.bits,
            voxels,
            kept.supplement_memory,
        )
        require(
            sum(voxels.point_counts) == header.point_count,
            "the numbers of points have another sum",
        )
        changes_memory = ChangesMemory()
        if kept.content.has_voxels_alone:
            changes_memory = kept.changes_memory.after_whole(
                voxels, header.is_i_frame
            )
        self._kept = replace(
            kept,
            depth_model=model,
            memory=memory,
            supplement_memory=supplement_memory,
            changes_memory=changes_memory,
        )
        return self._frame(header, kept, voxels)

    def _with_scan(
        self, header: FrameHeader, kept: Kept, table: ScanTable, payload: bytes
    ) -> Frame:
        layout = ScanLayout(
            table.width,
            table.height,
            table.shape,
            table.is_sequence,
            table.shifts,
            header.point_count,
            kept.scale.bits,
            kept.content.colour_bits,
            kept.content.fields,
        )
        scan, scan_memory = decode_scan(
            payload, layout, header.is_i_frame, kept.scan_memory
        )
        self._kept = replace(
            kept, scan_memory=scan_memory, changes_memory=ChangesMemory()
        )
        value_counts = [described.value_count for described in kept.content.fields]
        points = cloud_of(scan, table, kept.grid, value_counts)
        return self._frame(header, kept, Voxels([], []), points)

    @staticmethod
    def _frame(
        header: FrameHeader,
        kept: Kept,
        voxels: Voxels,
        points: Optional[CloudPoints] = None,
    ) -> Frame:
        return Frame(
            header.is_i_frame,
            header.number,
            kept.grid,
            kept.scale,
            None if header.stamp is None else kept.stamp,
            kept.frame_id,
            voxels,
            points,
            kept.content.layout,
        )
