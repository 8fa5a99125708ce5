// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include "voxelizing/field_collector.h"
#include "voxelizing/image_collector.h"
#include "voxels/memory_rule.h"

#include <cstddef>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Sets what the voxels of a stream's frames have of their points: further fields,
 * and the order that the sensor gave them. */
class PointContents {
public:
  /** \brief What the next frame may have. */
  struct Frame {
    std::size_t points_used = 0; ///< of the cloud, in voxels
    bool is_i_frame_due = false; ///< it will be an I-frame
    bool takes_images = false;   ///< see FrameEncoder::takesImages()
  };

  /** \param[in] settings as accepted by checkSettings() */
  explicit PointContents(const EncoderSettings& settings) : fields_(settings) {}

  /** \brief Chooses the fields of a cloud; see FieldCollector::select(). */
  CompressionStatus
  select(const PointBatches& points)
  {
    return fields_.select(points.fields());
  }

  /** \brief Sets fields and image of a voxelized frame, and from where fields are
   * predicted.
   * \param[in] points the cloud
   * \param[in] sensor_pose sensor -> grid, metres
   * \param[in] settings in force
   * \param[in] next what is known of the frame
   * \param[in,out] frame with its voxels
   */
  CompressionStatus
  collect(PointBatches& points,
          const WorldPose& sensor_pose,
          const EncoderSettings& settings,
          const Frame& next,
          VoxelFrame& frame);

private:
  std::uint64_t
  mostPixels(const EncoderSettings& settings,
             const Frame& next,
             const VoxelFrame& frame) const;

  FieldCollector fields_;
  ImageCollector image_;
  MemoryRule memory_rule_; // of both
};

} // namespace io
} // namespace pcl_ext
