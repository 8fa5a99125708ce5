"""Regions of coarse voxels: their table in a frame header, and which voxels are coarse.

doc/bitstream.md, "Regions".
"""

from dataclasses import dataclass
from typing import List, Tuple

from byte_reader import ByteReader
from invalid_frame import require
from morton import position

_MOST_REGIONS = 64
_MOST_LEVELS = 5
_FARTHEST = 1 << 22
_WHOLE = 1 << 14
_SENSOR_FRAME, _LEFT_OUT, _BY_DISTANCE = 8, 8, 16

Vector = Tuple[int, int, int]
LEFT_OUT = -1


def _vector(reader: ByteReader) -> Vector:
    return reader.svarint(), reader.svarint(), reader.svarint()


def _are_within(numbers: Tuple[int, ...], most: int) -> bool:
    return all(-most <= number <= most for number in numbers)


@dataclass(frozen=True)
class Box:
    """A region."""

    levels: int
    is_in_sensor_frame: bool
    lowest: Vector
    end: Vector

    def has(self, point: Vector, unit: int) -> bool:
        """Whether a point in shares of a voxel is in the box."""
        return all(
            unit * low <= at < unit * end
            for low, at, end in zip(self.lowest, point, self.end)
        )


@dataclass(frozen=True)
class RegionPose:
    """Where the sensor is."""

    position: Vector = (0, 0, 0)
    rotation: Tuple[Vector, Vector, Vector] = ((0, 0, 0),) * 3
    """Its rows."""


@dataclass(frozen=True)
class Regions:
    """Where voxels are coarse."""

    boxes: Tuple[Box, ...]
    levels_outside: int
    leaves_out_outside: bool
    coarser_beyond: int
    pose: RegionPose = RegionPose()

    @property
    def has_sensor_boxes(self) -> bool:
        return any(box.is_in_sensor_frame for box in self.boxes)

    @property
    def depends_on_pose(self) -> bool:
        return self.coarser_beyond > 0 or self.has_sensor_boxes

    @property
    def most_levels(self) -> int:
        return max([self.levels_outside, *(box.levels for box in self.boxes)])

    def require_pose(self) -> None:
        """Refuses what is too far away, or no rotation."""
        require(_are_within(self.pose.position, _FARTHEST), "the sensor is too far away")
        most = _WHOLE if self.has_sensor_boxes else 0
        for row in self.pose.rotation:
            require(_are_within(row, most), "the rotation of regions is none")

    def require_grid(self, first_index: Vector, depth: int) -> None:
        """Refuses a grid whose faces cut coarse voxels."""
        require(depth >= self.most_levels, "coarse voxels are larger than the grid")
        require(
            all(index % (1 << self.most_levels) == 0 for index in first_index),
            "coarse voxels cross a face of the grid",
        )

    def levels_of(self, keys: List[int], first_index: Vector) -> List[int]:
        """The levels of the coarse voxels that have these keys; refuses other keys."""
        return [self._levels_of(key, first_index) for key in keys]

    def _levels_of(self, key: int, first_index: Vector) -> int:
        for levels in range(self.most_levels, -1, -1):
            lowest_key = key >> 3 * levels << 3 * levels
            x, y, z = (
                2 * (first + at) + (1 << levels)
                for first, at in zip(first_index, position(lowest_key))
            )
            if self._levels_at((x, y, z)) >= levels:
                require(key == lowest_key, "a coarse voxel has another key")
                return levels
        require(not self.leaves_out_outside, "a voxel is outside of all regions")
        return 0

    def _levels_at(self, point: Vector) -> int:
        """The levels of a point in half voxels."""
        x, y, z = (p - (2 * s + 1) for p, s in zip(point, self.pose.position))
        for box in self.boxes:
            if box.is_in_sensor_frame:
                one, two, three = self.pose.rotation
                turned = tuple(
                    one[i] * x + two[i] * y + three[i] * z for i in range(3)
                )
                is_in = box.has((turned[0], turned[1], turned[2]), 2 * _WHOLE)
            else:
                is_in = box.has(point, 2)
            if is_in:
                return box.levels
        if self.leaves_out_outside:
            return LEFT_OUT
        if self.coarser_beyond == 0:
            return self.levels_outside
        levels, beyond = 0, 2 * self.coarser_beyond
        while levels < self.levels_outside and x * x + y * y + z * z >= beyond * beyond:
            levels, beyond = levels + 1, 2 * beyond
        return levels


def _box(reader: ByteReader) -> Box:
    (flags,) = reader.numbers("B")
    box = Box(flags & 7, bool(flags & _SENSOR_FRAME), _vector(reader), _vector(reader))
    require(flags < 16 and box.levels <= _MOST_LEVELS, "a region is of an unknown kind")
    require(_are_within(box.lowest + box.end, _FARTHEST), "a region is too far away")
    require(
        all(low < end for low, end in zip(box.lowest, box.end)), "a region is empty"
    )
    return box


def read_region_pose(reader: ByteReader) -> RegionPose:
    """The pose of regions at the reader."""
    position = _vector(reader)
    (has_rotation,) = reader.numbers("B")
    require(has_rotation <= 1, "the pose of regions is none")
    if not has_rotation:
        return RegionPose(position)
    return RegionPose(position, (_vector(reader), _vector(reader), _vector(reader)))


def read_regions(reader: ByteReader) -> Regions:
    """The table of regions at the reader."""
    count = reader.varint()
    require(count <= _MOST_REGIONS, "there are too many regions")
    boxes = tuple(_box(reader) for _ in range(count))
    (flags,) = reader.numbers("B")
    levels = flags & 7
    require(flags < 32 and levels <= _MOST_LEVELS, "what is outside is unknown")
    leaves_out, is_by_distance = bool(flags & _LEFT_OUT), bool(flags & _BY_DISTANCE)
    require(bool(boxes) or is_by_distance, "there are no regions")
    require(not leaves_out or not flags & ~_LEFT_OUT, "what is left out has no voxels")
    require(bool(levels) or not is_by_distance, "the distance doubles no edge")
    beyond = reader.varint() if is_by_distance else 0
    require(not is_by_distance or 0 < beyond <= _FARTHEST, "the distance is none")
    regions = Regions(boxes, levels, leaves_out, beyond)
    if regions.depends_on_pose:
        regions = Regions(boxes, levels, leaves_out, beyond, read_region_pose(reader))
        regions.require_pose()
    return regions
