// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "coders/whole_number_coder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace pcl_ext {
namespace measuring {

WholeNumberCoder::WholeNumberCoder(std::string name, double edge)
: StreamCoder(std::move(name), Content::Points)
{
  lattice_.resolution = edge;
}

double
WholeNumberCoder::index(float coordinate) const
{
  return std::floor(static_cast<double>(coordinate) / lattice_.resolution);
}

void
WholeNumberCoder::encode(const InputFrame& frame)
{
  least_.fill(std::numeric_limits<double>::infinity());
  for (const pcl::PointXYZ& point : *frame.positions)
    for (std::size_t axis = 0; axis < 3; ++axis)
      least_[axis] = std::min(least_[axis], index(point.data[axis]));
  numbers_.resize(frame.positions->size());
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      numbers_[i][axis] = static_cast<std::uint32_t>(
          index((*frame.positions)[i].data[axis]) - least_[axis]);
  encodePositions(numbers_);
}

void
WholeNumberCoder::decode()
{
  decodePositions(numbers_);
  positions_->resize(numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      (*positions_)[i].data[axis] = static_cast<float>(
          lattice_.resolution * (least_[axis] + numbers_[i][axis] + 0.5));
}

void
WholeNumberCoder::check(const InputFrame& frame)
{
  checkPoints(*frame.positions, *positions_, lattice_);
}

} // namespace measuring
} // namespace pcl_ext
