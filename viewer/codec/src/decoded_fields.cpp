// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "viewer/codec/src/decoded_fields.h"

#include "voxels/field_summary.h"

#include <array>

namespace pcl_ext {
namespace viewer {

void
DecodedFields::describe(const io::VoxelFrame& frame, DecodedFrame& result)
{
  descriptions_.clear();
  for (const io::FrameField& field : frame.fields)
    descriptions_.push_back(
        {spanOf(field.name), static_cast<std::uint32_t>(field.type), field.count});
  result.fields = static_cast<std::uint32_t>(descriptions_.size());
  result.field_descriptions = addressOf(descriptions_.data());
}

FieldValues
DecodedFields::find(const io::VoxelFrame& frame,
                    std::uint32_t field,
                    std::uint32_t value)
{
  release();
  if (field >= frame.fields.size() || value >= frame.fields[field].count)
    return {};
  const io::FrameField& found = frame.fields[field];
  io::FieldDescription exact = found;
  exact.step = 0.0;
  values_.reset(new double[frame.size()]);
  std::size_t next = value;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    of_voxel_.clear();
    const std::uint32_t points = frame.has_point_counts ? frame.point_counts[i] : 1;
    for (std::uint32_t k = 0; k < points; ++k, next += found.count)
      of_voxel_.push_back(found.numbers[next]);
    std::array<unsigned char, 8> typed{};
    io::summarizeField(found, of_voxel_, typed.data());
    values_[i] = io::fieldValue(exact, io::fieldNumber(exact, typed.data()));
  }
  return {static_cast<std::uint32_t>(frame.size()), addressOf(values_.get())};
}

} // namespace viewer
} // namespace pcl_ext
