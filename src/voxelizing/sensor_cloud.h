// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "voxelizing/common_step.h"
#include "voxelizing/field_collector.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The usable points of a cloud that has a sensor's order, in the order of the
 * cloud. */
struct SensorCloud {
  ImageSize image;                              ///< columns and rows, if it has any
  std::vector<std::uint32_t> pixels;            ///< then; or of a scan of the cloud
  std::uint32_t columns = 0;                    ///< of these, from row to row
  std::vector<std::uint32_t> rings;             ///< else, if it has any; or most_side
  std::vector<std::array<double, 3>> positions; ///< world coordinates, metres
  std::vector<double> intensities;              ///< if they are asked for
  CommonStep intensity_step;                    ///< of these
  std::vector<std::uint32_t> colours;           ///< likewise, as PointView::colours
  std::vector<std::vector<std::uint64_t>> numbers; ///< of each selected field
  VoxelizationStatistics statistics;

  std::size_t
  size() const
  {
    return positions.size();
  }

  /** \brief Of its rows and columns; 0 without. */
  std::size_t
  pixelCount() const
  {
    return std::size_t{image.width} * image.height;
  }
};

inline Eigen::Vector3d
vectorOf(const std::array<double, 3>& position)
{
  return {position[0], position[1], position[2]};
}

/** \brief Reads clouds, with their rows and columns or their field `ring`. */
class SensorCloudReader {
public:
  /** \brief What to read of each point. */
  struct Contents {
    bool intensities = false;
    bool colours = false;
    std::optional<BoundingBox> box; ///< of the points to use
    const FieldCollector* fields = nullptr;
  };

  /** \brief Reads a cloud.
   * \param[in,out] cloud its memory is reused
   * \return false if it has too many rows or columns, or pixels outside of these
   */
  bool
  read(PointBatches& points, const Contents& contents, SensorCloud& cloud);

private:
  template <typename NumberT>
  bool
  readBatch(const PointView& points, const NumberT* coordinates, SensorCloud& cloud);

  template <typename NumberT>
  bool
  readPart(const PointView& points,
           const NumberT* coordinates,
           std::size_t begin,
           std::size_t end,
           SensorCloud& cloud);

  void
  readAttributes(const PointView& points, SensorCloud& cloud) const;

  Contents contents_;
  std::optional<std::size_t> ring_;
  std::size_t first_ = 0;            // index in the cloud of the batch's first point
  std::size_t used_ = 0;             // usable points so far
  std::vector<std::uint32_t> batch_; // usable points of the current batch
};

} // namespace pcl_ext::PCL_EXT_ABI::io
