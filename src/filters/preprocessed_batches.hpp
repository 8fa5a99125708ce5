// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/impl/point_intensity.h>

#include "filters/preprocessed_batches.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI {

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatus
PreprocessedBatches<IntensityModelT, OutputPointT>::open(
    const pcl::PCLPointCloud2& cloud)
{
  cloud_ = nullptr;
  begin_ = end_ = 0;
  if (PreprocessingStatus status = preprocessor_.start(cloud, layout_); !status.ok())
    return status;
  cloud_ = &cloud;
  fields_.clear();
  if (reads_fields_)
    fields_ = findFields(cloud);
  end_ = std::size_t{cloud.width} * cloud.height;
  restart();
  return {};
}

template <typename IntensityModelT, typename OutputPointT>
std::vector<io::FieldDescription>
PreprocessedBatches<IntensityModelT, OutputPointT>::fields() const
{
  std::vector<io::FieldDescription> descriptions;
  for (const FoundField& field : fields_)
    descriptions.push_back(field.description);
  return descriptions;
}

template <typename IntensityModelT, typename OutputPointT>
void
PreprocessedBatches<IntensityModelT, OutputPointT>::restart()
{
  next_ = begin_;
  part_count_ = 0;
  if (cloud_ == nullptr)
    return;
  preprocessor_.startPoints(size(), preprocessor_.statistics_.has_colours);
}

template <typename IntensityModelT, typename OutputPointT>
bool
PreprocessedBatches<IntensityModelT, OutputPointT>::next(io::PointView& points)
{
  std::size_t count = 0;
  point_bytes_.clear();
  const bool has_image = imageSize().width > 0;
  pixels_.clear();
  preprocessor_.sources_ = fields_.empty() && !has_image ? nullptr : &sources_;
  // Batches of few points, where most are cropped, would take more time.
  while (count < chunk && next_ < end_) {
    const std::size_t row = next_ / cloud_->width;
    const std::size_t column = next_ % cloud_->width;
    const std::size_t most = std::min({chunk, cloud_->width - column, end_ - next_});
    sources_.clear();
    count += preprocessor_.readChunk(
        *cloud_, layout_, row, column, most, &points_[count], &doubles_[count]);
    const std::uint8_t* const row_bytes = cloud_->data.data() + row * rowStep(*cloud_);
    for (const std::uint32_t source : sources_) {
      if (has_image)
        pixels_.push_back(
            static_cast<std::uint32_t>(row * cloud_->width + column + source));
      if (fields_.empty())
        continue;
      const std::uint8_t* const point =
          row_bytes + (column + source) * cloud_->point_step;
      point_bytes_.insert(point_bytes_.end(), point, point + cloud_->point_step);
    }
    next_ += most;
  }
  points = viewOf(count);
  return count > 0;
}

template <typename IntensityModelT, typename OutputPointT>
std::vector<io::PointBatches*>
PreprocessedBatches<IntensityModelT, OutputPointT>::split(std::size_t parts)
{
  std::vector<io::PointBatches*> batches;
  while (parts_.size() < parts)
    parts_.push_back(std::make_unique<PreprocessedBatches>(preprocessor_));
  for (std::size_t i = 0; i < parts; ++i) {
    PreprocessedBatches& part = *parts_[i];
    part.preprocessor_ = preprocessor_;
    part.cloud_ = cloud_;
    part.layout_ = layout_;
    part.begin_ = begin_ + i * size() / parts;
    part.end_ = begin_ + (i + 1) * size() / parts;
    part.restart();
    batches.push_back(&part);
  }
  part_count_ = parts;
  return batches;
}

template <typename IntensityModelT, typename OutputPointT>
PreprocessingStatistics
PreprocessedBatches<IntensityModelT, OutputPointT>::statistics() const
{
  if (part_count_ == 0)
    return preprocessor_.statistics();
  PreprocessingStatistics sum;
  for (std::size_t i = 0; i < part_count_; ++i) {
    const PreprocessingStatistics part = parts_[i]->statistics();
    sum.points += part.points;
    sum.points_not_finite += part.points_not_finite;
    sum.points_cropped += part.points_cropped;
    sum.points_behind_sensor += part.points_behind_sensor;
    sum.has_colours |= part.has_colours;
  }
  return sum;
}

template <typename IntensityModelT, typename OutputPointT>
io::PointView
PreprocessedBatches<IntensityModelT, OutputPointT>::viewOf(std::size_t count) const
{
  io::PointView view = hasIntensities()
                           ? pointViewWithIntensities(points_.data(), count)
                           : pointViewOf(points_.data(), count);
  if (preprocessor_.movesDoubles(layout_)) {
    view.coordinates = nullptr;
    view.double_coordinates = doubles_[0].data();
    view.coordinate_stride = sizeof(doubles_[0]);
  }
  if (!hasColours())
    view.colours = nullptr;
  if (imageSize().width > 0) {
    view.image = imageSize();
    view.pixels = pixels_.data();
  }
  for (const FoundField& field : fields_)
    view.fields.push_back({field.description,
                           point_bytes_.data() + field.offset,
                           std::size_t{cloud_->point_step}});
  return view;
}

} // namespace pcl_ext::PCL_EXT_ABI
