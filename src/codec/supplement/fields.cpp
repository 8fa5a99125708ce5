// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/fields.h"

#include "codec/rans/entropy_coder.h"
#include "codec/supplement/field_pass.h"
#include "voxels/ascending_keys.h"
#include "voxels/lower_neighbours.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Finds the neighbours, the direction, the past and the points of each voxel. */
void
FieldCoder::findPlaces(const std::array<std::int32_t, 3>& viewpoint,
                       const VoxelFrame& frame)
{
  FieldPlaces& places = places_;
  places.blocks.assign(frame.keys);
  LowerNeighbours neighbours(
      places.blocks, levelsAboveBlocks(frame.grid.depth), places.directory);
  neighbours.begin();
  preparePlaces(frame.size());
  next_keys_.assign(frame.keys.begin(), frame.keys.end());
  AscendingLookup<std::uint64_t> past(last_keys_);
  std::uint32_t voxel = 0;
  std::uint32_t point = 0;
  for (std::size_t block = 0; block < places.blocks.size(); ++block) {
    neighbours.moveTo(block);
    for (std::uint64_t cells = places.blocks.masks[block]; cells != 0;
         cells &= cells - 1, ++voxel) {
      std::size_t side = 0;
      neighbours.visitEachSide(
          lowestBit(cells), [&](std::size_t other, std::uint32_t is_there) {
            places.lower[voxel][side++] =
                is_there != 0 ? static_cast<std::uint32_t>(other) : voxel;
          });
      const VoxelPosition position = voxelPosition(frame.keys[voxel]);
      places.directions[voxel] = directionOf(std::int64_t{position.x} - viewpoint[0],
                                             std::int64_t{position.y} - viewpoint[1],
                                             std::int64_t{position.z} - viewpoint[2]);
      const std::size_t record = past.find(frame.keys[voxel]);
      places.before[voxel] =
          record == not_in_list ? 0 : static_cast<std::uint32_t>(record + 1);
      places.first_points[voxel] = point;
      point += frame.has_point_counts ? frame.point_counts[voxel] : 1;
    }
  }
  places.first_points[voxel] = point;
}

void
FieldCoder::preparePlaces(std::size_t count)
{
  places_.lower.resize(count);
  places_.directions.resize(count);
  places_.before.resize(count);
  places_.first_points.resize(count + 1);
}

/** \brief Finds the neighbours, the column, the row and the past of each pixel with a
 * point. */
void
FieldCoder::findPixels(const PixelOrder& order)
{
  constexpr std::uint32_t none = ~std::uint32_t{0};
  const auto count = static_cast<std::uint32_t>(order.pixels.size());
  preparePlaces(count);
  by_pixel_.assign(std::size_t{order.width} * order.height, none);
  next_keys_.assign(order.pixels.begin(), order.pixels.end());
  AscendingLookup<std::uint64_t> past(last_keys_);
  for (std::uint32_t point = 0; point < count; ++point) {
    const std::size_t pixel = order.pixels[point];
    by_pixel_[pixel] = point;
    const auto column = static_cast<std::uint32_t>(pixel % order.width);
    const auto row = static_cast<std::uint32_t>(pixel / order.width);
    const auto beside = [&](bool is_inside, std::size_t distance) {
      const std::uint32_t other = is_inside ? by_pixel_[pixel - distance] : none;
      return other != none ? other : point;
    };
    places_.lower[point] = {beside(column > 0, 1), beside(row > 0, order.width), point};
    places_.directions[point] = {column % Direction::azimuth_bins,
                                 row % Direction::elevation_bins};
    const std::size_t record = past.find(pixel);
    places_.before[point] =
        record == not_in_list ? 0 : static_cast<std::uint32_t>(record + 1);
    places_.first_points[point] = point;
  }
  places_.first_points[count] = count;
}

template <class CodingT, class FieldsT>
bool
FieldCoder::codeFields(CodingT& coding, bool is_i_frame, FieldsT& fields)
{
  if (is_i_frame) {
    next_states_.clear();
    std::fill(places_.before.begin(), places_.before.end(), 0u);
  }
  else
    next_states_ = states_;
  // There are none yet in an I-frame, and after one without voxels.
  next_states_.resize(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    auto& field = fields[i];
    if constexpr (CodingT::is_decoder)
      field.numbers.resize(std::size_t{places_.first_points.back()} * field.count);
    FieldPass<CodingT> pass(field, next_states_[i], places_);
    if (!pass.run(coding, indices_, field.numbers))
      return false;
  }
  return true;
}

template bool
FieldCoder::codeFields(NumberCoding<rans::NibbleEncoder>&,
                       bool,
                       const std::vector<FrameField>&);
template bool
FieldCoder::codeFields(NumberCoding<rans::NibbleDecoder>&,
                       bool,
                       std::vector<FrameField>&);

void
FieldCoder::learn() noexcept
{
  states_.swap(next_states_);
  last_keys_.swap(next_keys_);
}

void
FieldCoder::reset() noexcept
{
  states_.clear();
  last_keys_.clear();
}

void
FieldCoder::releaseMemory()
{
  next_states_ = std::vector<FieldState>();
  next_keys_ = std::vector<std::uint64_t>();
  places_ = FieldPlaces();
  indices_ = std::vector<std::uint64_t>();
  by_pixel_ = std::vector<std::uint32_t>();
}

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
