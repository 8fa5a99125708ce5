#pragma once

#include <pcl_ext/filters/preprocessed_batches.h>
#include <pcl_ext/point_intensity.h>

#include <algorithm>

namespace pcl_ext {

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatus
PreprocessedBatches<IntensityModelT, OutputPointT>::open(
    const pcl::PCLPointCloud2& cloud)
{
  cloud_ = nullptr;
  if (PreprocessingStatus status = preprocessor_.start(cloud, layout_); !status.ok())
    return status;
  cloud_ = &cloud;
  restart();
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
void
PreprocessedBatches<IntensityModelT, OutputPointT>::restart()
{
  row_ = 0;
  column_ = 0;
  if (cloud_ == nullptr)
    return;
  preprocessor_.startPoints(size(), preprocessor_.statistics_.has_colours);
}

template <typename IntensityModelT, typename OutputPointT>
bool
PreprocessedBatches<IntensityModelT, OutputPointT>::next(io::PointView& points)
{
  const std::size_t behind_sensor = preprocessor_.statistics_.points_behind_sensor;
  std::size_t count = 0;
  // Batches of few points, where most are cropped, would take more time.
  while (count < chunk && size() > 0 && row_ < cloud_->height) {
    const std::size_t most = std::min(chunk, cloud_->width - column_);
    count +=
        preprocessor_.readChunk(*cloud_, layout_, row_, column_, most, &points_[count]);
    column_ += most;
    if (column_ == cloud_->width) {
      column_ = 0;
      ++row_;
    }
  }
  points = viewOf(count);
  points.count_behind_sensor =
      preprocessor_.statistics_.points_behind_sensor - behind_sensor;
  return count > 0;
}

template <typename IntensityModelT, typename OutputPointT>
io::PointView
PreprocessedBatches<IntensityModelT, OutputPointT>::viewOf(std::size_t count) const
{
  io::PointView view = hasIntensities()
                           ? pointViewWithIntensities(points_.data(), count)
                           : pointViewOf(points_.data(), count);
  if (!hasColours())
    view.colours = nullptr;
  return view;
}

} // namespace pcl_ext
