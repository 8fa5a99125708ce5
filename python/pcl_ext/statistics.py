# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Figures of clouds and frames."""

from __future__ import annotations

from typing import NamedTuple


class FrameStatistics(NamedTuple):
    """Figures of a frame. Sizes are in bytes."""

    frame_number: int = 0  #: number of the frame in the stream
    is_i_frame: bool = False  #: decodes without any other frame
    is_of_changes: bool = False  #: has only what changed since the frame before
    has_points: bool = False  #: coded as points in the order of their sensor
    voxels: int = 0  #: occupied voxels, after all filters; its points, if has_points
    bytes: int = 0  #: the whole frame
    header_bytes: int = 0  #: of these: header
    occupancy_bytes: int = 0  #: of these: which voxels are occupied
    intensity_bytes: int = 0  #: of these: the voxels' intensities
    attribute_bytes: int = 0  #: of these: what else a voxel has
    skipped_bytes: int = 0  #: decoding: bytes skipped before the frame


class CloudStatistics(NamedTuple):
    """Figures of an encoded cloud. Each point is exactly one of: used, not finite, outside
    the box, outside the grid."""

    resolution: float = 0.0  #: voxel edge that was used, metres
    points: int = 0  #: points of the cloud
    points_used: int = 0  #: points that are in the frame
    points_not_finite: int = 0  #: a coordinate is NaN or infinite
    points_outside_box: int = 0  #: outside the bounding box
    points_outside_grid: int = 0  #: more than 2**20 voxels from the origin
    points_behind_sensor: int = 0  #: of negative depth, with a law that uses the depth
    intensities_not_finite: int = 0  #: points used with intensity 0 instead
    intensities_out_of_range: int = 0  #: voxels clamped to an end of the scale
    intensities_vanished: int = 0  #: voxels above 0 that became 0
    colours_left_out: int = 0  #: points whose colour has no field
    alphas_left_out: int = 0  #: points of a scan whose colour is not opaque
    voxels_hidden: int = 0  #: occupied ones that the temporal filter left out
    voxels_held: int = 0  #: ones that it added, which are not occupied now
    is_sensor_moving: bool = False  #: so that the temporal filter leaves the frame as it is


class RateControlStatus(NamedTuple):
    """What the rate control of an encoder chose, and why. Without `max_rate` and
    `max_encode_ms` nothing changes."""

    max_rate: float = 0.0  #: bits a second; 0: no limit
    used_rate: float = 0.0  #: likewise, of the frames of the last second
    encode_ms: float = 0.0  #: mean of the last frames
    resolution: float = 0.0  #: voxel edge, metres
    step: int = 0  #: number of the step; 0: the settings as they are
    last_step: int = 0  #: number of the coarsest step
    changes: int = 0  #: of the step
    clouds_left_out: int = 0  #: as there was no room for them
    choice: str = ""  #: the step in words
    reason: str = ""  #: why it was chosen
    not_kept: str = ""  #: what is not kept by the step alone; empty: nothing
