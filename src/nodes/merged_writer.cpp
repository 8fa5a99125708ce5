// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_writer.h"

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "platforms/run_at_once.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr std::int64_t highest_whole = 65535; // number that is an intensity's symbol

/** \brief Writes voxels of whole intensities into a frame, which has room for them. */
class VoxelWriter {
public:
  /** \param[in] begin index of the first voxel to be written */
  VoxelWriter(io::VoxelFrame& frame, std::size_t begin)
  : keys_(frame.keys.data() + begin), intensities_(frame.intensities.data() + begin)
  {}

  /** \brief Writes a voxel, if there is one: without a branch, which could not be
   * predicted. */
  void
  write(std::uint64_t key, std::int64_t number, bool is_there)
  {
    *(is_there ? keys_ : &no_key_) = key;
    *(is_there ? intensities_ : &no_intensity_) = static_cast<std::uint16_t>(number);
    keys_ += is_there ? 1 : 0;
    intensities_ += is_there ? 1 : 0;
  }

private:
  std::uint64_t* keys_;
  std::uint16_t* intensities_;
  std::uint64_t no_key_ = 0;
  std::uint16_t no_intensity_ = 0;
};

/** \brief Sets the number of voxels of a frame. */
void
resize(io::VoxelFrame& frame, std::size_t count)
{
  frame.keys.resize(count);
  frame.intensities.resize(count);
}

/** \brief Where a list of changes begins in frames that have those of all lists. */
struct ListedBefore {
  std::size_t gone = 0;
  std::size_t came = 0;
};

/** \brief Writes a list of changes as voxels that have gone and that came.
 * \return the bits of all intensities */
std::int64_t
writeList(const ChangedSums& list,
          int shift,
          const ListedBefore& before,
          io::VoxelChanges& changes)
{
  VoxelWriter gone(changes.gone, before.gone);
  VoxelWriter came(changes.came, before.came);
  std::int64_t bits = 0;
  for (const ChangedSum& sum : list.sums) {
    const std::int64_t number = sum.after >> shift;
    bits |= number;
    gone.write(sum.key, sum.before >> shift, sum.was_there);
    came.write(sum.key, number, sum.is_there);
  }
  return bits;
}

/** \brief Writes lists of changes, each in a thread.
 * \return the bits of all intensities */
std::int64_t
writeLists(const std::vector<ChangedSums>& lists, int shift, io::VoxelChanges& changes)
{
  std::vector<ListedBefore> before(lists.size() + 1);
  for (std::size_t i = 0; i < lists.size(); ++i)
    before[i + 1] = {before[i].gone + lists[i].were_there,
                     before[i].came + lists[i].are_there};
  resize(changes.gone, before.back().gone);
  resize(changes.came, before.back().came);
  std::vector<std::int64_t> bits(lists.size());
  io::runAtOnce(lists.size(), [&](std::size_t i) {
    bits[i] = writeList(lists[i], shift, before[i], changes);
  });
  return std::accumulate(bits.begin(), bits.end(), std::int64_t{0}, std::bit_or<>());
}

io::VoxelColour
meanOf(const SummedColour& sum)
{
  const auto mean = [&](std::size_t channel) {
    return static_cast<std::uint8_t>(
        (std::uint64_t{2} * sum.channels[channel] + sum.summands) /
        (std::uint64_t{2} * sum.summands));
  };
  return {mean(0), mean(1), mean(2)};
}

io::IntensityQuantiser
mergingQuantiser()
{
  io::EncoderSettings settings;
  settings.aggregation = io::Aggregation::Sum;
  constexpr bool spans_all = true; // streams have left out what is too far above
  return {settings, IntensityUnit::Native, spans_all};
}

void
begin(const MergedSums& sums, io::VoxelFrame& merged)
{
  merged.clearVoxels();
  merged.fields.clear();
  merged.has_point_counts = false;
  merged.depth_model.reset();
  merged.viewpoint = {};
  merged.colour_bits = 0;
  merged.grid = sums.scale.grid;
}

/** \brief Writes the mean colours of voxels, if there are any. */
void
writeColours(const SummedVoxels& sums, io::VoxelFrame& merged)
{
  if (!sums.hasColours())
    return;
  // Black where no stream has a colour.
  bool has_any = false;
  sums.forEach([&](std::uint64_t, std::int64_t, const SummedColour& sum) {
    const bool has_colour = sum.summands != 0;
    has_any |= has_colour;
    merged.colours.push_back(has_colour ? meanOf(sum) : io::VoxelColour());
  });
  if (has_any)
    merged.colour_bits = 8;
  else
    merged.colours.clear();
}

/** \brief Bits of a sum below those of whole numbers, if all intensities are such. */
std::optional<int>
wholeShift(const MergedSums& sums)
{
  if (sums.step.divisor() != 1 || sums.scale.units < 1.0)
    return std::nullopt;
  constexpr int most_shift = 63;
  return std::min(std::ilogb(sums.scale.units), most_shift); // a power of two
}

/** \brief Gives a scale as many bits as numbers have. */
void
widen(io::IntensityScale& scale, std::int64_t highest)
{
  while (highest > static_cast<std::int64_t>(scale.maxSymbol()))
    ++scale.bits;
}

/** \brief Sets intensities that are whole numbers of 0 to 65535, as the quantiser would.
 * \param[in] shift result of wholeShift()
 * \return false if not all are */
bool
setWholeIntensities(const SummedVoxels& sums, int shift, io::VoxelFrame& merged)
{
  std::int64_t bits = 0; // of all numbers
  merged.intensities.reserve(sums.size());
  sums.forEach([&](std::uint64_t, std::int64_t intensity, const SummedColour&) {
    const std::int64_t number = intensity >> shift;
    bits |= number;
    merged.intensities.push_back(static_cast<std::uint16_t>(number));
  });
  if (bits < 0 || bits > highest_whole)
    return false;
  merged.intensity_scale = io::IntensityScale();
  widen(merged.intensity_scale, bits);
  return true;
}

} // namespace

MergedWriter::MergedWriter() : quantiser_(mergingQuantiser()) {}

void
MergedWriter::write(const MergedSums& sums, io::VoxelFrame& merged)
{
  begin(sums, merged);
  merged.keys.reserve(sums.voxels.size());
  sums.voxels.forEach([&](std::uint64_t key, std::int64_t, const SummedColour&) {
    merged.keys.push_back(key);
  });
  writeColours(sums.voxels, merged);
  const std::optional<int> shift = wholeShift(sums);
  whole_scale_.reset();
  if (shift && setWholeIntensities(sums.voxels, *shift, merged))
    whole_scale_ = merged.intensity_scale;
  else
    writeScaled(sums, merged);
}

/** \brief Writes intensities on a scale that is found for them. */
void
MergedWriter::writeScaled(const MergedSums& sums, io::VoxelFrame& merged)
{
  const double step = 1.0 / sums.scale.units;
  intensities_.clear();
  sums.voxels.forEach([&](std::uint64_t, std::int64_t intensity, const SummedColour&) {
    intensities_.push_back(static_cast<double>(intensity) * step);
  });
  std::size_t vanished = 0;
  constexpr bool may_refit = true; // each frame has a scale of its own
  quantiser_.quantise(intensities_, sums.step, may_refit, merged, vanished);
}

bool
MergedWriter::listChanges(const MergedSums& sums, io::VoxelChanges& changes)
{
  const std::optional<io::IntensityScale> before = std::exchange(whole_scale_, {});
  const std::optional<int> shift = wholeShift(sums);
  if (!before || !shift || sums.voxels.hasColours())
    return false;
  begin(sums, changes.gone);
  begin(sums, changes.came);
  const std::int64_t bits = writeLists(sums.voxels.changes(), *shift, changes);
  if (bits < 0 || bits > highest_whole)
    return false;
  io::IntensityScale scale = *before;
  widen(scale, bits);
  changes.gone.intensity_scale = scale;
  changes.came.intensity_scale = scale;
  changes.is_from_nothing = false;
  whole_scale_ = scale;
  return true;
}

void
MergedWriter::releaseMemory() noexcept
{
  whole_scale_.reset();
  intensities_ = std::vector<double>();
  quantiser_.releaseMemory();
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
