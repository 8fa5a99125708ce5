// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include "voxelizing/field_collector.h"
#include "voxels/memory_rule.h"

#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Sets the further fields of a stream's frames of voxels. */
class PointContents {
public:
  /** \param[in] settings as accepted by checkSettings() */
  explicit PointContents(const EncoderSettings& settings) : fields_(settings) {}

  /** \brief Chooses the fields of a cloud for a scan; see FieldCollector::select().
   * collect() chooses those for voxels. */
  CompressionStatus
  select(const PointBatches& points)
  {
    return fields_.select(points.fields(), false);
  }

  /** \brief The fields of the cloud, as they were chosen. */
  const FieldCollector&
  fields() const
  {
    return fields_;
  }

  /** \brief Sets the fields of a voxelized frame, and from where they are predicted.
   * \param[in] points the cloud
   * \param[in] sensor_pose sensor -> grid, metres
   * \param[in] settings in force
   * \param[in] points_used of the cloud, in voxels
   * \param[in,out] frame with its voxels
   */
  CompressionStatus
  collect(PointBatches& points,
          const WorldPose& sensor_pose,
          const EncoderSettings& settings,
          std::size_t points_used,
          VoxelFrame& frame);

private:
  FieldCollector fields_;
  MemoryRule memory_rule_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
