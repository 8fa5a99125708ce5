// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "outliers/frame_ticks.h"
#include "outliers/sensor_rest.h"
#include "outliers/surface_support.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief Tells whether the sensor of a stream moves, where no TemporalVoxelFilter
 * does. */
class FrameMotion {
public:
  /** \brief Takes the stream's next frame.
   * \param[in] frame its voxels
   * \param[in] position of the sensor, metres
   * \param[in] time of the cloud
   * \return as SensorRest::judge()
   */
  io::SensorMotion
  judge(const io::VoxelFrame& frame,
        const std::array<double, 3>& position,
        const std::optional<std::chrono::nanoseconds>& time)
  {
    if (grid_ && (grid_->resolution != frame.grid.resolution ||
                  grid_->origin != frame.grid.origin))
      rest_ = SensorRest();
    grid_ = frame.grid;
    surfaces_.learn(frame, [](std::uint64_t) { return std::uint64_t{0}; });
    return rest_.judge(frame, surfaces_, position, ticks_.take(time));
  }

private:
  std::optional<io::VoxelGrid> grid_; // of the last frame
  FrameTicks ticks_;
  SurfaceSupport surfaces_;
  SensorRest rest_;
};

} // namespace pcl_ext::PCL_EXT_ABI
