// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/supplement.h"

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "codec/rans/entropy_coder.h"
#include "codec/supplement/numbers.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

namespace {

/** \brief Whether numbers of points are coded here. */
bool
hasPoints(const Content& content)
{
  return content.has_point_counts && content.refinement_levels > 0;
}

/** \brief Whether each voxel has points, which are as many as the header says: fields
 * have so many values. */
bool
arePoints(const std::vector<std::uint32_t>& counts, std::uint64_t sum)
{
  return std::find(counts.begin(), counts.end(), 0u) == counts.end() &&
         std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}) == sum;
}

} // namespace

Sizes
SupplementCoder::encode(const Parameters& parameters,
                        const VoxelFrame& frame,
                        std::vector<std::uint8_t>& bytes)
{
  *next_models_ = parameters.is_i_frame ? Models() : *models_;
  const rans::Interleaving interleaving = rans::interleavingOf(parameters.voxel_count);
  Sizes sizes;
  reserveSymbols(parameters);
  if (parameters.content.hasVoxels()) {
    rans::NibbleEncoder coder(ranges_);
    codeVoxels(coder, parameters, frame);
    bytes_.clear();
    coder.finish(interleaving, words_, bytes_);
    const std::size_t begin = bytes.size();
    ByteWriter writer(bytes);
    writer.varint(bytes_.size());
    writer.raw(bytes_.data(), bytes_.size());
    sizes.voxels = bytes.size() - begin;
  }
  const std::size_t begin = bytes.size();
  rans::NibbleEncoder coder(ranges_);
  codeAttributes(coder, parameters, frame);
  coder.finish(interleaving, words_, bytes);
  sizes.attributes = bytes.size() - begin;
  learn();
  return sizes;
}

void
SupplementCoder::reserveSymbols(const Parameters& parameters)
{
  const Content& content = parameters.content;
  // About what the voxels and the attributes take, one after the other.
  const std::size_t of_voxels = content.hasVoxels() ? 5 : 0;
  const std::size_t of_attributes = (hasPoints(content) ? 1 : 0) +
                                    (content.colour_bits > 0 ? 6 : 0) +
                                    (content.has_fields ? 6 : 0);
  const std::size_t symbols =
      std::max(of_voxels, of_attributes) * parameters.voxel_count;
  if (ranges_.size() < symbols)
    ranges_ = std::vector<std::uint32_t>(symbols);
}

bool
SupplementCoder::decode(const Parameters& parameters,
                        const std::uint8_t* begin,
                        const std::uint8_t* end,
                        VoxelFrame& frame,
                        Sizes& sizes)
{
  *next_models_ = parameters.is_i_frame ? Models() : *models_;
  const rans::Interleaving interleaving = rans::interleavingOf(parameters.voxel_count);
  sizes = {0, static_cast<std::size_t>(end - begin)};
  if (parameters.content.hasVoxels()) {
    MemoryBuffer buffer(begin, sizes.attributes);
    ByteSource source(buffer, sizes.attributes);
    const std::uint64_t size = source.varint();
    if (source.failure() != ByteSource::Failure::None ||
        size > sizes.attributes - source.consumed())
      return false;
    begin += source.consumed();
    rans::NibbleDecoder coder(begin, begin + size, interleaving, bytes_);
    if (coder.isOverrun() || !codeVoxels(coder, parameters, frame) || !coder.isAtEnd())
      return false;
    begin += size;
    sizes.voxels = sizes.attributes - static_cast<std::size_t>(end - begin);
    sizes.attributes -= sizes.voxels;
  }
  rans::NibbleDecoder coder(begin, end, interleaving, bytes_);
  return !coder.isOverrun() && codeAttributes(coder, parameters, frame) &&
         coder.isAtEnd();
}

/** \brief Codes the voxels within coarse voxels. */
template <class Coder, class FrameT>
bool
SupplementCoder::codeVoxels(Coder& coder, const Parameters& parameters, FrameT& frame)
{
  NumberCoding<Coder> coding(coder, next_models_->lengths);
  RefinementPass<NumberCoding<Coder>> pass(next_models_->refinement,
                                           parameters.content.refinement_levels,
                                           parameters.effort != Effort::Fast);
  const bool is_whole =
      pass.run(coding, parameters.coarse_voxels, parameters.voxel_count, frame.keys);
  coder = coding.coder();
  return is_whole;
}

/** \brief Codes all but the voxels. */
template <class Coder, class FrameT>
bool
SupplementCoder::codeAttributes(Coder& coder,
                                const Parameters& parameters,
                                FrameT& frame)
{
  const Content& content = parameters.content;
  NumberCoding<Coder> coding(coder, next_models_->lengths);
  if constexpr (Coder::is_decoder) {
    if (content.hasVoxels())
      frame.intensities.resize(frame.hasIntensities() ? frame.size() : 0);
    if (hasPoints(content))
      frame.point_counts.resize(frame.size());
    frame.colours.resize(content.colour_bits > 0 ? frame.size() : 0);
  }
  changes_history_ = false;
  changes_fields_ = content.has_fields;
  const bool is_whole =
      (!content.hasVoxels() || codeIntensities(coding, frame)) &&
      (!hasPoints(content) || codePointCounts(coding, frame.point_counts)) &&
      (content.colour_bits == 0 || codeColours(coding, parameters, frame)) &&
      (!content.has_fields ||
       (arePoints(frame.point_counts, parameters.point_count) &&
        fields_.code(coding, parameters.is_i_frame, parameters.viewpoint, frame)));
  coder = coding.coder();
  return is_whole;
}

/** \brief Codes intensities, each as a residual of the mean of the last ones. */
template <class CodingT, class FrameT>
bool
SupplementCoder::codeIntensities(CodingT& coding, FrameT& frame)
{
  if (!frame.hasIntensities())
    return true;
  const auto highest = static_cast<std::int32_t>(frame.intensity_scale.maxSymbol());
  ResidualCoding residuals(next_models_->intensities, highest);
  CodingT local = coding;          // in registers
  std::int32_t mean = 8 * highest; // in sixteenths
  for (auto& intensity : frame.intensities) {
    std::int32_t value = intensity;
    local.reserve(ResidualCoding::most_symbols);
    if (!residuals.code(local, (mean + 8) / 16, value))
      return false;
    if constexpr (CodingT::is_decoder)
      intensity = static_cast<std::uint16_t>(value);
    mean += (16 * value - mean) / 2;
  }
  coding = local;
  return true;
}

/** \brief Codes numbers of points, of which most are as large as those before. */
template <class CodingT, class CountsT>
bool
SupplementCoder::codePointCounts(CodingT& coding, CountsT& counts)
{
  auto& models = next_models_->point_counts;
  CodingT local = coding; // in registers
  std::size_t last_class = 0;
  for (auto& count : counts) {
    local.reserve(8);
    const std::uint64_t further = local.code(models[last_class], count - 1);
    if constexpr (CodingT::is_decoder) {
      constexpr std::uint64_t most = 0xffffffff;
      if (further >= most || local.isOverrun())
        return false;
      count = static_cast<std::uint32_t>(further + 1);
    }
    last_class = std::min<std::size_t>(highestBit(count), models.size() - 1);
  }
  coding = local;
  return true;
}

template <class CodingT, class FrameT>
bool
SupplementCoder::codeColours(CodingT& coding,
                             const Parameters& parameters,
                             FrameT& frame)
{
  static const ColourHistory no_history;
  // Where most voxels are alone they rarely come again.
  const bool has_voxels = parameters.content.hasVoxels();
  ColourPass pass(next_models_->colours,
                  parameters.content.colour_bits,
                  parameters.is_i_frame || has_voxels ? no_history : history_);
  if (has_voxels)
    return pass.runSparse(coding, frame.colours);
  blocks_.assign(frame.keys);
  LowerNeighbours neighbours(blocks_, levelsAboveBlocks(frame.grid.depth), directory_);
  neighbours.begin();
  if (!pass.runDense(coding, blocks_, neighbours, frame.keys, frame.colours))
    return false;
  history_.prepare(frame, parameters.is_i_frame);
  changes_history_ = true;
  return true;
}

void
SupplementCoder::learn() noexcept
{
  models_.swap(next_models_);
  if (changes_history_)
    history_.learn();
  changes_history_ = false;
  if (changes_fields_)
    fields_.learn();
  changes_fields_ = false;
}

void
SupplementCoder::reset() noexcept
{
  *models_ = Models();
  history_.clear();
  fields_.reset();
}

void
SupplementCoder::releaseMemory()
{
  history_.releaseMemory();
  fields_.releaseMemory();
  blocks_ = BlockList();
  directory_ = BlockDirectory();
  ranges_ = std::vector<std::uint32_t>();
  words_ = std::vector<std::uint16_t>();
  bytes_ = std::vector<std::uint8_t>();
}

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
