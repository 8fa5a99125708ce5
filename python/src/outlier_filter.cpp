#include "outlier_filter.h"

namespace pcl_ext {
namespace python {

void
OutlierFilter::filter(io::VoxelFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  status_ = removal_.filter(frame);
}

std::vector<float>
OutlierFilter::score(const io::VoxelFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<float> log_odds;
  status_ = removal_.score(frame, log_odds);
  return log_odds;
}

void
OutlierFilter::reset()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  removal_.reset();
}

OutlierRemovalStatus
OutlierFilter::status() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return status_;
}

void
Denoising::apply(io::VoxelFrame& frame) const
{
  if (outliers != nullptr)
    outliers->filter(frame);
  if (temporal_filter != nullptr)
    temporal_filter->filter(frame);
  if (min_intensity)
    removeVoxelsBelow(frame, *min_intensity);
}

} // namespace python
} // namespace pcl_ext
