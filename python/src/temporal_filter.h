// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "shared_filter.h"

#include <array>
#include <chrono>
#include <optional>

namespace pcl_ext::python {

struct TemporalFilterSettings {
  unsigned int frames = TemporalVoxelFilter::usual_frames;
  std::optional<std::array<double, 3>> sensor_position; ///< metres; none: unknown
};

class TemporalFilter : public SharedFilter<TemporalVoxelFilter, TemporalFilterStatus> {
public:
  explicit TemporalFilter(const TemporalFilterSettings& settings)
  : SharedFilter(settings.frames), sensor_position_(settings.sensor_position)
  {}

  /** \brief Filters the stream's next frame.
   * \param[in] time of its cloud, by any clock; none: a twentieth of a second after the
   * last
   */
  void
  filter(io::VoxelFrame& frame, const std::optional<std::chrono::nanoseconds>& time)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    status_ = filter_.filter(frame, {sensor_position_, time});
  }

private:
  std::optional<std::array<double, 3>> sensor_position_;
};

} // namespace pcl_ext::python
