// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/rigid_pose.h>

#include "codec/scan/scan_frame.h"
#include "voxelizing/ring_columns.h"
#include "voxelizing/sensor_cloud.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Gives the points of a spinning sensor, whose rings are known, columns: those in
 * which it fires its lasers where the cloud has that order, else those of their
 * azimuths. */
class ScanColumns {
public:
  /** \brief Whether rings are numbers of the rows of a sensor. */
  static bool
  areRows(const std::vector<std::uint32_t>& rings);

  /** \brief Finds the columns of a cloud.
   * \param[in,out] cloud with rings that are rows; its pixels are set
   * \param[in] to_sensor world -> sensor, metres
   * \param[in] may_refit learn the order of the rings again, or the columns of a turn
   * \param[in] most_pixels that the scan may have
   * \param[out] layout size and order are set
   * \return false if there are none, or too many, or if others than those of before fit
   * the cloud but may not be learnt
   */
  bool
  find(SensorCloud& cloud,
       const WorldPose& to_sensor,
       bool may_refit,
       std::uint64_t most_pixels,
       scan::ScanLayout& layout);

  /** \brief Column of each point of the cloud. */
  const std::vector<std::uint32_t>&
  columns() const
  {
    return columns_;
  }

  /** \brief Angle between columns that are not firings, radians. */
  double
  step() const
  {
    return by_azimuth_.step();
  }

  /** \brief How far such columns are turned since their step was found, radians. */
  double
  shift() const
  {
    return shift_;
  }

  void
  releaseMemory();

private:
  bool
  setLayout(std::uint64_t most_pixels, scan::ScanLayout& layout) const;

  bool
  findFirings(const SensorCloud& cloud, std::uint64_t most_pixels);

  bool
  findByAzimuth(const SensorCloud& cloud,
                const WorldPose& to_sensor,
                bool may_refit,
                std::uint64_t most_pixels);

  std::uint32_t ring_count_ = 0;
  bool are_firings_ = false;
  std::vector<std::uint32_t> firing_ranks_; // of rings
  RingColumns by_azimuth_;
  double shift_ = 0.0;
  std::uint32_t turns_ = 1;       // that columns by azimuth have
  std::size_t fitted_points_ = 0; // that by_azimuth_ was fitted to
  // Of the current cloud; members so that their memory is reused.
  std::vector<std::uint32_t> columns_;
  std::vector<PixelPoint> points_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
