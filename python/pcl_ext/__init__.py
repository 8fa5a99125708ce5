# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Compresses streams of point clouds into voxels, each with an intensity.

    import numpy, pcl_ext
    encoder = pcl_ext.Encoder(resolution=0.04)
    decoder = pcl_ext.Decoder()
    frame = encoder.encode(numpy.random.rand(1000, 3))   # bytes
    cloud = decoder.decode(frame)                        # x, y, z, intensity
    print(len(frame), "bytes,", len(cloud), "voxels,", cloud["x"].max())

Coordinates are metres, times are seconds. See the classes for what they take.
"""

from ._native import version as __version__
from .bags import BagSummary, EncodingSummary, StreamSummary, encode_bag
from .cloud import Cloud
from .codec import CompressionWarning, Decoder, Encoder, VoxelChanges
from .frames import FrameField, FrameSize, frame_size, laws, positions, sensors
from .order import arrange_by_ring, sort_by_time
from .outliers import OutlierRemoval, PointOutlierRemoval
from .recording import (
    Damage,
    RecordedFrame,
    RecordedStream,
    Recording,
    RecordingWarning,
    open,
)
from .recording_writer import RecordingWriter
from .statistics import CloudStatistics, FrameStatistics, RateControlStatus
from .status import Error, Status
from .temporal_filter import TemporalVoxelFilter

__all__ = [
    "BagSummary",
    "Cloud",
    "CloudStatistics",
    "CompressionWarning",
    "Damage",
    "Decoder",
    "Encoder",
    "EncodingSummary",
    "Error",
    "FrameField",
    "FrameSize",
    "FrameStatistics",
    "OutlierRemoval",
    "PointOutlierRemoval",
    "RateControlStatus",
    "RecordedFrame",
    "RecordedStream",
    "Recording",
    "RecordingWarning",
    "RecordingWriter",
    "Status",
    "StreamSummary",
    "TemporalVoxelFilter",
    "VoxelChanges",
    "__version__",
    "arrange_by_ring",
    "encode_bag",
    "frame_size",
    "laws",
    "open",
    "positions",
    "sensors",
    "sort_by_time",
]
