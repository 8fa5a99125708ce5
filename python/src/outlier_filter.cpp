// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outlier_filter.h"

namespace pcl_ext {
namespace python {

void
OutlierFilter::filter(io::VoxelFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  status_ = filter_.filter(frame);
}

std::vector<float>
OutlierFilter::score(const io::VoxelFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<float> log_odds;
  status_ = filter_.score(frame, log_odds);
  return log_odds;
}

DensityUnit
OutlierFilter::unit() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return filter_.unit();
}

std::vector<float>
PointFilter::score(const CloudColumns& cloud)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  // As if all fields were kept, of which it reads one.
  io::StreamSettings settings;
  settings.fields = {{io::all_fields, 0.0}};
  settings.colour_bits = 0;
  CloudColumns points = cloud;
  points.packed_colour.reset();
  points.channels.reset();
  std::vector<float> log_odds;
  status_ = filter_.score(viewOf(points, false, settings, memory_), log_odds);
  return log_odds;
}

void
Denoising::apply(io::VoxelFrame& frame,
                 const std::optional<std::chrono::nanoseconds>& time) const
{
  if (outliers != nullptr)
    outliers->filter(frame);
  if (temporal_filter != nullptr)
    temporal_filter->filter(frame, time);
  if (min_intensity)
    removeVoxelsBelow(frame, *min_intensity);
}

} // namespace python
} // namespace pcl_ext
