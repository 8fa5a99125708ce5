// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/PCLHeader.h>

#include <Eigen/Geometry>
#include <Eigen/StdVector>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl {

template <typename PointT>
class PointCloud {
public:
  using Points = std::vector<PointT, Eigen::aligned_allocator<PointT>>;

  PointCloud() = default;

  PointCloud(std::uint32_t columns, std::uint32_t rows)
  : points(std::size_t{columns} * rows), width(columns), height(rows)
  {}

  std::size_t
  size() const
  {
    return points.size();
  }

  bool
  empty() const
  {
    return points.empty();
  }

  PointT&
  operator[](std::size_t i)
  {
    return points[i];
  }

  const PointT&
  operator[](std::size_t i) const
  {
    return points[i];
  }

  const PointT&
  front() const
  {
    return points.front();
  }

  auto
  begin()
  {
    return points.begin();
  }

  auto
  begin() const
  {
    return points.begin();
  }

  auto
  end()
  {
    return points.end();
  }

  auto
  end() const
  {
    return points.end();
  }

  void
  reserve(std::size_t count)
  {
    points.reserve(count);
  }

  /** \brief The cloud becomes one row, unless it has as many points. */
  void
  resize(std::size_t count)
  {
    points.resize(count);
    if (std::size_t{width} * height != count) {
      width = static_cast<std::uint32_t>(count);
      height = 1;
    }
  }

  void
  push_back(const PointT& point)
  {
    points.push_back(point);
    width = static_cast<std::uint32_t>(points.size());
    height = 1;
  }

  void
  clear()
  {
    points.clear();
    width = 0;
    height = 0;
  }

  void
  swap(PointCloud& other)
  {
    std::swap(*this, other);
  }

  PCLHeader header;
  Points points;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool is_dense = true;
  Eigen::Vector4f sensor_origin_ = Eigen::Vector4f::Zero();
  Eigen::Quaternionf sensor_orientation_ = Eigen::Quaternionf::Identity();

  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

} // namespace pcl
