#include "codec/fast/occupancy.h"

#include "codec/fast/entropy_coder.h"
#include "voxels/voxel_block.h"

#include <limits>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();

/** \brief Sorts voxels into blocks, behind which comes one above all. \return their
 * number */
std::size_t
collectBlocks(const std::vector<std::uint64_t>& voxel_keys, Frame& frame)
{
  frame.expectBlocks(voxel_keys.size() + 1);
  std::uint64_t* const keys = frame.keys.data();
  std::uint64_t* const masks = frame.masks.data();
  std::uint64_t last = voxel_keys.front() >> block_key_bits;
  std::uint64_t mask = 0;
  std::size_t count = 0;
  for (const std::uint64_t voxel : voxel_keys) {
    // Without a branch: every sixth voxel or so begins a block, whose key and mask are
    // written again and again as it grows.
    const std::uint64_t key = voxel >> block_key_bits;
    const std::uint64_t is_other = key != last ? 1 : 0;
    count += is_other;
    mask = (mask & (is_other - 1)) | std::uint64_t{1} << (voxel % block_cells);
    keys[count] = key;
    masks[count] = mask;
    last = key;
  }
  ++count;
  keys[count] = no_key;
  return count;
}

} // namespace

void
Occupancy::match(const History& before,
                 const std::vector<std::uint64_t>& keys,
                 Frame& frame)
{
  const std::size_t count = collectBlocks(keys, frame);
  const std::uint64_t* const frame_keys = frame.keys.data();
  const std::uint64_t* const frame_masks = frame.masks.data();
  frame.occupied.resize(before.known.size());
  for (auto* vector : {&frame.new_keys, &frame.new_masks}) {
    // What is gone of a vector's length does not count when it grows.
    if (vector->capacity() < count)
      vector->reserve(count + count / 4);
    vector->resize(count);
  }
  std::uint64_t* const occupied = frame.occupied.data();
  std::size_t now = 0;
  std::size_t new_count = 0;
  const auto appendNew = [&] {
    frame.new_keys[new_count] = frame_keys[now];
    frame.new_masks[new_count++] = frame_masks[now++];
  };
  for (std::size_t i = 0; i < before.keys.size(); ++i) {
    const std::uint64_t key = before.keys[i];
    while (frame_keys[now] < key)
      appendNew();
    const std::uint64_t is_same = frame_keys[now] == key ? 1 : 0;
    occupied[before.numbers[i]] = frame_masks[now] & (0 - is_same);
    now += is_same;
  }
  while (now < count)
    appendNew();
  frame.new_keys.resize(new_count);
  frame.new_masks.resize(new_count);
}

template <class Coder>
bool
Occupancy::code(Coder& coder,
                Models& models,
                const History& before,
                History& after,
                Moments& moments,
                Frame& frame)
{
  found_voxels_ = 0;
  if (Coder::is_decoder)
    frame.occupied.assign(before.known.size(), 0);
  // Long before it changes: what is read in a row comes faster from memory than what is
  // read here and there.
  after.known.assign(before.known.begin(), before.known.end());
  return codeKnownVoxels(coder, models, before, after, frame) &&
         codeNewOctants(coder, models, before, moments, frame) &&
         codeOctantMasks(coder, models, before, frame) &&
         codeNewCells(coder, models, before, moments, frame) &&
         codeNewBlocks(coder, models, frame) &&
         (!Coder::is_decoder || found_voxels_ == frame.voxel_count) &&
         learnBlocks(before, after, moments, frame);
}

template bool
Occupancy::code(NibbleEncoder&, Models&, const History&, History&, Moments&, Frame&);
template bool
Occupancy::code(NibbleDecoder&, Models&, const History&, History&, Moments&, Frame&);

} // namespace fast
} // namespace io
} // namespace pcl_ext
