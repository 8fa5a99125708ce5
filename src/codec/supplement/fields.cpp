// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/fields.h"

#include "codec/rans/entropy_coder.h"
#include "codec/supplement/field_pass.h"
#include "voxels/ascending_keys.h"
#include "voxels/lower_neighbours.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace supplement {

namespace {

/** \brief Copies values between the order of the voxels and that of the pixels.
 * \param[in] points in the order of the pixels
 * \param[in] count of values of a point
 * \param[in] to_pixels else to the order of the voxels
 */
void
movePixels(const std::vector<std::uint32_t>& points,
           std::size_t count,
           const std::vector<std::uint64_t>& from,
           std::vector<std::uint64_t>& to,
           bool to_pixels)
{
  for (std::size_t place = 0; place < points.size(); ++place) {
    const std::size_t source = to_pixels ? points[place] : place;
    const std::size_t target = to_pixels ? place : points[place];
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(source * count),
                count,
                to.begin() + static_cast<std::ptrdiff_t>(target * count));
  }
}

} // namespace

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
FieldCoder::findPixels(const PointImage& image)
{
  constexpr std::uint32_t none = ~std::uint32_t{0};
  const auto count = static_cast<std::uint32_t>(image.pixels.size());
  preparePlaces(count);
  points_.resize(count);
  next_keys_.resize(count);
  std::vector<std::uint32_t> by_pixel(image.pixelCount(), none);
  for (std::uint32_t point = 0; point < count; ++point)
    by_pixel[image.pixels[point]] = point;
  AscendingLookup<std::uint64_t> past(last_keys_);
  std::uint32_t place = 0;
  for (std::size_t pixel = 0; pixel < by_pixel.size(); ++pixel) {
    if (by_pixel[pixel] == none)
      continue;
    points_[place] = by_pixel[pixel];
    by_pixel[pixel] = place; // from here on
    const auto column = static_cast<std::uint32_t>(pixel % image.width);
    const auto row = static_cast<std::uint32_t>(pixel / image.width);
    const auto beside = [&](bool is_inside, std::size_t distance) {
      const std::uint32_t other = is_inside ? by_pixel[pixel - distance] : none;
      return other != none ? other : place;
    };
    places_.lower[place] = {beside(column > 0, 1), beside(row > 0, image.width), place};
    places_.directions[place] = {column % Direction::azimuth_bins,
                                 row % Direction::elevation_bins};
    const std::size_t record = past.find(pixel);
    places_.before[place] =
        record == not_in_list ? 0 : static_cast<std::uint32_t>(record + 1);
    places_.first_points[place] = place;
    next_keys_[place] = pixel;
    ++place;
  }
  places_.first_points[place] = place;
}

template <class CodingT, class FrameT>
bool
FieldCoder::code(CodingT& coding,
                 bool is_i_frame,
                 bool has_image,
                 const std::array<std::int32_t, 3>& viewpoint,
                 FrameT& frame)
{
  if (has_image)
    findPixels(frame.image);
  else
    findPlaces(viewpoint, frame);
  if (is_i_frame) {
    next_states_.clear();
    std::fill(places_.before.begin(), places_.before.end(), 0u);
  }
  else
    next_states_ = states_;
  // There are none yet in an I-frame, and after one without voxels.
  next_states_.resize(frame.fields.size());
  for (std::size_t i = 0; i < frame.fields.size(); ++i) {
    auto& field = frame.fields[i];
    if constexpr (CodingT::is_decoder)
      field.numbers.resize(std::size_t{places_.first_points.back()} * field.count);
    FieldPass<CodingT> pass(field, next_states_[i], places_);
    if (!has_image) {
      if (!pass.run(coding, indices_, field.numbers))
        return false;
      continue;
    }
    numbers_.resize(field.numbers.size());
    if constexpr (!CodingT::is_decoder)
      movePixels(points_, field.count, field.numbers, numbers_, true);
    if (!pass.run(coding, indices_, numbers_))
      return false;
    if constexpr (CodingT::is_decoder)
      movePixels(points_, field.count, numbers_, field.numbers, false);
  }
  return true;
}

template bool
FieldCoder::code(NumberCoding<rans::NibbleEncoder>&,
                 bool,
                 bool,
                 const std::array<std::int32_t, 3>&,
                 const VoxelFrame&);
template bool
FieldCoder::code(NumberCoding<rans::NibbleDecoder>&,
                 bool,
                 bool,
                 const std::array<std::int32_t, 3>&,
                 VoxelFrame&);

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
  points_ = std::vector<std::uint32_t>();
  numbers_ = std::vector<std::uint64_t>();
}

} // namespace supplement
} // namespace io
} // namespace pcl_ext
