// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/image.h"

#include "codec/rans/entropy_coder.h"
#include "codec/supplement/image_pass.h"
#include "voxels/radix_sort.h"

namespace pcl_ext {
namespace io {
namespace supplement {

template <class CodingT, class FrameT>
bool
ImageCoder::code(CodingT& coding,
                 bool is_i_frame,
                 std::uint64_t point_count,
                 FrameT& frame)
{
  static const std::vector<std::uint32_t> no_past;
  if (is_i_frame)
    next_models_ = ImageModels();
  else
    next_models_ = models_;
  next_past_.clear();
  if constexpr (!CodingT::is_decoder)
    spreadPoints(frame);
  else {
    points_.depths.clear();
    points_.keys.clear();
  }
  ImagePass<CodingT> pass(frame.image,
                          frame.grid.depth,
                          next_models_,
                          is_i_frame ? no_past : past_,
                          next_past_);
  if (!pass.run(coding, point_count, points_))
    return false;
  if constexpr (CodingT::is_decoder)
    collectPoints(frame);
  return true;
}

template bool
ImageCoder::code(NumberCoding<rans::NibbleEncoder>&,
                 bool,
                 std::uint64_t,
                 const VoxelFrame&);
template bool
ImageCoder::code(NumberCoding<rans::NibbleDecoder>&, bool, std::uint64_t, VoxelFrame&);

/** \brief Sets the points by pixels from those by voxels. */
void
ImageCoder::spreadPoints(const VoxelFrame& frame)
{
  const PointImage& image = frame.image;
  points_.depths.assign(image.pixelCount(), no_depth);
  spread_keys_.resize(image.pixelCount());
  std::size_t point = 0;
  for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
    for (std::uint32_t i = 0; i < frame.point_counts[voxel]; ++i, ++point) {
      points_.depths[image.pixels[point]] = image.depths[point];
      spread_keys_[image.pixels[point]] = frame.keys[voxel];
    }
  points_.keys.clear();
  points_.keys.reserve(point);
  for (std::size_t pixel = 0; pixel < spread_keys_.size(); ++pixel)
    if (points_.depths[pixel] != no_depth)
      points_.keys.push_back(spread_keys_[pixel]);
}

/** \brief Sets the points by voxels from those by pixels. */
void
ImageCoder::collectPoints(VoxelFrame& frame)
{
  entries_.clear();
  for (std::uint32_t pixel = 0; pixel < points_.depths.size(); ++pixel)
    if (points_.depths[pixel] != no_depth)
      entries_.push_back({points_.keys[entries_.size()], pixel});
  radixSort(entries_, spare_, 3 * frame.grid.depth);
  frame.keys.clear();
  frame.point_counts.clear();
  frame.image.pixels.clear();
  frame.image.depths.clear();
  for (const Entry& entry : entries_) {
    if (frame.keys.empty() || frame.keys.back() != entry.key) {
      frame.keys.push_back(entry.key);
      frame.point_counts.push_back(0);
    }
    ++frame.point_counts.back();
    frame.image.pixels.push_back(entry.pixel);
    const std::uint32_t depth = points_.depths[entry.pixel];
    frame.image.depths.push_back(depth == sensor_depth ? 0 : depth);
  }
}

void
ImageCoder::learn() noexcept
{
  models_ = next_models_;
  past_.swap(next_past_);
}

void
ImageCoder::reset() noexcept
{
  models_ = ImageModels();
  past_.clear();
}

void
ImageCoder::releaseMemory()
{
  next_past_ = std::vector<std::uint32_t>();
  spread_keys_ = std::vector<std::uint64_t>();
  points_ = PixelPoints();
  entries_ = std::vector<Entry>();
  spare_ = std::vector<Entry>();
}

} // namespace supplement
} // namespace io
} // namespace pcl_ext
