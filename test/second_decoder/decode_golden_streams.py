# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Decodes the golden streams and compares every frame with checksums.txt.

    python3 decode_golden_streams.py test/data/golden

An implementation of the documents alone: decoding the voxels and points that the
library's encoder was given shows that the documents are complete. Each line of
checksums.txt is a frame: stream, I or P, number of voxels or of the points of a scan,
checksum of the voxels (hexadecimal), stamp and frame_id or -, with fields the checksum
of their numbers, of a scan that of its points, and that of a layout. The first frame of each stream must
be refused when it is cut off, when a bit is inverted, and when it is missing. The stream
"disorder" has other bytes between its frames, and frames that must be refused. Ends with
1 at the first difference.
"""

import struct
import sys
from pathlib import Path
from typing import Dict, List

from byte_reader import ByteReader
from companded_scale import LEAST_COUNTS, edges, middle_number
from frame_decoder import Frame, FrameDecoder
from frame_header import Layout
from invalid_frame import InvalidFrame
from scan_points import CloudPoints


def voxel_checksum(frame: Frame) -> int:
    """The checksum of grid, scale, keys and what voxels have, but fields."""
    x, y, z = (index % (1 << 32) for index in frame.grid.first_index)
    scale = frame.scale
    numbers = [x, y, z, frame.grid.depth, scale.bits, scale.number_range or 0]
    numbers.append(len(frame.voxels.keys))
    for i, key in enumerate(frame.voxels.keys):
        numbers.append(key)
        numbers += frame.voxels.symbols[i : i + 1]
        if scale.number_range:
            symbol = frame.voxels.symbols[i]
            numbers.append(middle_number(scale.bits, scale.number_range, symbol))
        for colour in frame.voxels.colours[i : i + 1]:
            numbers += colour
        numbers += frame.voxels.point_counts[i : i + 1]
    return fnv(numbers)


def point_checksum(points: CloudPoints) -> int:
    """The checksum of the size of a cloud, and of what its points have, but fields."""
    numbers = [points.width, points.height]
    for i, (index, position) in enumerate(zip(points.indices, points.positions)):
        numbers += [index, *struct.unpack("<3I", struct.pack("<3f", *position))]
        numbers += points.symbols[i : i + 1]
        for colour in points.colours[i : i + 1]:
            numbers += colour
    return fnv(numbers)


def layout_checksum(layout: Layout) -> int:
    """The checksum of how messages are laid out."""
    numbers = []
    for field, offset in layout.fields:
        numbers += [*field.name, field.type, field.value_count, offset]
    return fnv([*numbers, layout.point_step, layout.row_padding])


def fnv(numbers: List[int]) -> int:
    """FNV-1a with 64 bits over 64-bit numbers."""
    checksum = 0xCBF29CE484222325
    for number in numbers:
        for byte in number.to_bytes(8, "little"):
            checksum = (checksum ^ byte) * 0x100000001B3 % (1 << 64)
    return checksum


def line_of(name: str, frame: Frame) -> str:
    """The line of a frame in checksums.txt."""
    kind = "I" if frame.is_i_frame else "P"
    stamp = "-"
    if frame.stamp is not None:
        stamp = f"{frame.stamp} '{frame.frame_id.decode()}'"
    count, numbers, points = len(frame.voxels.keys), frame.voxels.fields, ""
    if frame.points is not None:
        count, numbers = len(frame.points.indices), frame.points.fields
        points = f" points {point_checksum(frame.points):016x}"
    fields = ""
    if any(numbers):
        fields = f" fields {fnv([n for of_field in numbers for n in of_field]):016x}"
    layout = ""
    if frame.layout is not None:
        layout = f" layout {layout_checksum(frame.layout):016x}"
    checksum = voxel_checksum(frame)
    return f"{name} {kind} {count} {checksum:016x} {stamp}{fields}{points}{layout}"


def require_stream(name: str, stream: bytes, lines: List[str]) -> None:
    """Refuses a stream whose frames differ from the lines."""
    reader = ByteReader(stream)
    decoder = FrameDecoder()
    for index, line in enumerate(lines):
        try:
            found = line_of(name, decoder.decode(reader))
        except InvalidFrame as error:
            raise InvalidFrame(f"{name}, frame {index}: {error}") from error
        if found != line:
            raise InvalidFrame(f"{name}, frame {index}: '{found}' is not '{line}'")
    if reader.at != len(stream):
        raise InvalidFrame(f"{name}: bytes are left behind the last frame")


def require_disorder(name: str, stream: bytes, lines: List[str]) -> None:
    """Refuses a stream of whose frames others are decoded than the lines say."""
    reader = ByteReader(stream)
    decoder = FrameDecoder()
    for index, line in enumerate([*lines, None]):
        frame = decoder.next_frame(reader)
        found = None if frame is None else line_of(name, frame)
        if found != line:
            raise InvalidFrame(f"{name}, frame {index}: '{found}' is not '{line}'")


def is_refused(stream: bytes) -> bool:
    """Whether the first frame of a stream is."""
    try:
        FrameDecoder().decode(ByteReader(stream))
    except InvalidFrame:
        return True
    return False


def require_refusals(name: str, stream: bytes, lines: List[str]) -> None:
    """Refuses a stream whose first frame decodes when it is damaged, or that
    decodes without it though a P-frame follows."""
    reader = ByteReader(stream)
    FrameDecoder().decode(reader)
    size = reader.at
    for at in range(size):
        if not is_refused(stream[:at]):
            raise InvalidFrame(f"{name} decodes where only {at} bytes are left of it")
        flipped = bytes([stream[at] ^ 1 << at % 8])
        if not is_refused(stream[:at] + flipped + stream[at + 1 :]):
            raise InvalidFrame(f"{name} decodes with a bit of byte {at} flipped")
    p_frame_follows = len(lines) == 1 or lines[1].split()[1] == "P"
    if p_frame_follows and not is_refused(stream[size:]):
        raise InvalidFrame(f"{name} decodes without its first frame")


def require_folder(folder: Path) -> None:
    """Decodes all streams of a folder."""
    lines: Dict[str, List[str]] = {}
    for line in (folder / "checksums.txt").read_text().splitlines():
        lines.setdefault(line.split()[0], []).append(line)
    if not lines:
        raise InvalidFrame(f"{folder} names no stream")
    for name, lines_of_stream in lines.items():
        stream = (folder / f"{name}.pcxi").read_bytes()
        if name == "disorder":
            require_disorder(name, stream, lines_of_stream)
        else:
            require_stream(name, stream, lines_of_stream)
            require_refusals(name, stream, lines_of_stream)
        print(f"{name}: {len(lines_of_stream)} frames, {len(stream)} bytes")


def main(arguments: List[str]) -> int:
    if len(arguments) < 2:
        print(__doc__)
        return 1
    for bits, counts in LEAST_COUNTS.items():
        if [edge + 1 for edge in edges(bits, 254)[:-1]] != counts:
            print(f"levels of {bits} bits are not those of the document")
            return 1
    try:
        for folder in arguments[1:]:
            require_folder(Path(folder))
    except (InvalidFrame, OSError) as error:
        print(error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
