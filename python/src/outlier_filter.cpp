// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outlier_filter.h"

#include "outliers/unit_choice.h"

#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace pcl_ext::python {

void
OutlierFilter::setStream(const std::optional<IntensityLaw>& law, bool is_of_lidar)
{
  const DensityUnit unit = densityUnitOf(settings_.unit);
  // Numbers of points, which frames may have, are known with a frame.
  if (law && unit != DensityUnit::Points)
    if (const std::string fault = unitFault(unit, *law); !fault.empty())
      throw std::invalid_argument("unit is '" +
                                  std::string(nameOf(density_units, unit)) +
                                  "' and the intensity_law of the stream is " + fault);
  const std::lock_guard<std::mutex> lock(mutex_);
  law_ = law;
  is_of_lidar_ = is_of_lidar;
}

void
OutlierFilter::reset()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  filter_ = VoxelOutlierRemoval(settings_);
  is_begun_ = false;
}

void
OutlierFilter::filter(io::VoxelFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto* const automatic = std::get_if<AutomaticUnit>(&settings_.unit);
  if (!std::exchange(is_begun_, true) && automatic != nullptr && law_) {
    VoxelOutlierRemovalSettings settings = settings_;
    settings.unit = automaticUnitOf(frame, law_, is_of_lidar_, *automatic);
    filter_ = VoxelOutlierRemoval(settings);
  }
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

} // namespace pcl_ext::python
