// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Counts of a voxelized cloud. Each point is exactly one of: used, not finite,
 * outside the box, outside the grid. */
struct VoxelizationStatistics {
  double resolution = 0.0;                  ///< voxel edge that was used, metres
  std::size_t points = 0;                   ///< points of the input
  std::size_t points_used = 0;              ///< points that are in the frame
  std::size_t points_not_finite = 0;        ///< a coordinate is NaN or infinite
  std::size_t points_outside_box = 0;       ///< outside the fixed bounding box
  std::size_t points_outside_grid = 0;      ///< more than 2^20 voxels from the origin
  std::size_t points_behind_sensor = 0;     ///< of negative depth
  std::size_t intensities_not_finite = 0;   ///< points used with intensity 0 instead
  std::size_t intensities_out_of_range = 0; ///< voxels clamped to an end of the scale
  std::size_t intensities_vanished = 0;     ///< voxels that became as 0 is, but are not
  std::size_t colours_left_out = 0;         ///< points whose colour has no field
  std::size_t alphas_left_out = 0; ///< points of a scan whose colour is not opaque
  /** \brief Occupied, before any filter; of a scan, whose intensities are those of
   * points, its points. */
  std::size_t voxels = 0;
};

/** \brief Figures of an encoded frame. */
struct CodedFrameStatistics {
  std::uint32_t frame_number = 0; ///< number of the frame in the stream
  bool is_i_frame = false;        ///< decodes without any other frame
  bool is_of_changes = false;     ///< a P-frame that has only what changed
  std::size_t voxels = 0;         ///< occupied, after all filters; of a scan, which has
                                  ///< none, its points
  std::size_t bytes = 0;          ///< the whole frame
  std::size_t header_bytes = 0;   ///< of these: frame header
  /** \brief Of these: which voxels are occupied, and of effort fast without a depth model
   * their intensities, which are coded with them; of a scan where its points are; padding.
   * All of the payload of a frame of changes, and of a decoded scan. */
  std::size_t occupancy_bytes = 0;
  /** \brief Of these: the voxels' intensities, unless they are above or beside numbers of
   * points; of an encoded scan all that its points have. */
  std::size_t intensity_bytes = 0;
  std::size_t attribute_bytes = 0; ///< of these: what else a voxel or its points have
  std::size_t skipped_bytes = 0;   ///< decoding: bytes skipped before the frame
  /** \brief Whether it is coded as points in the order of their sensor; see
   * VoxelFrame::points. */
  bool has_points = false;
};

/** \brief Whether a sensor moves, by its positions, or by what comes and goes. */
enum class SensorMotion {
  Unknown, ///< as of the first frame
  AtRest,
  Moving
};

/** \brief All figures of the last frame that was encoded or decoded. */
struct FrameStatistics {
  VoxelizationStatistics voxelization; ///< encoding only
  CodedFrameStatistics coding;
  std::size_t voxels_hidden = 0; ///< by the temporal filter, encoding only: occupied
                                 ///< ones that are not coded
  std::size_t voxels_held = 0;   ///< likewise: coded ones that are not occupied
  bool exceeds_limits = false;   ///< encoding only: decoders with the decoder_limits of
                                 ///< the settings refuse the frame
  /** \brief Encoding only: where it is Moving, the temporal filter leaves the frame as it
   * is. Unknown where the filter is off and max_rate may not turn it on. */
  SensorMotion sensor_motion = SensorMotion::Unknown;
  bool is_step_new = false; ///< encoding only: the first frame on a step of the rate
                            ///< control

  /** \brief Bytes per occupied voxel; 0 for an empty frame. */
  double
  bytesPerVoxel() const
  {
    return coding.voxels == 0
               ? 0.0
               : static_cast<double>(coding.bytes) / static_cast<double>(coding.voxels);
  }

  /** \brief Size of the input at 16 bytes per point (PointXYZ in memory) divided by the
   * size of the frame; encoding only. */
  double
  compressionRatio() const
  {
    return coding.bytes == 0 ? 0.0
                             : 16.0 * static_cast<double>(voxelization.points) /
                                   static_cast<double>(coding.bytes);
  }
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
