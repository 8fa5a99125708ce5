#include "fast_coder.h"

#include "block_octants.h"
#include "nibble_rans.h"
#include "voxel_block.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

// A state costs four bytes; below this they weigh more than the time.
constexpr std::size_t voxels_for_four_states = 1024;

Interleaving
interleaving(std::size_t voxel_count)
{
  return voxel_count < voxels_for_four_states ? Interleaving::One : Interleaving::Four;
}

} // namespace

void
FastCoder::encode(bool is_i_frame,
                  const std::vector<std::uint64_t>& keys,
                  const std::vector<std::uint16_t>& symbols,
                  unsigned int bits,
                  unsigned int depth,
                  std::vector<std::uint8_t>& payload)
{
  beginFrame(is_i_frame, depth, keys.size());
  FastModels& models = models_[current_models_];
  if (is_i_frame)
    models = first_models_;
  FastOccupancy::match(before(), keys, frame_);
  NibbleEncoder coder(steps_);
  occupancy_.code(coder, models, before(), next_history_, moments(), frame_);
  symbols_.encode(coder, models, frame_, moments(), bits, symbols);
  coder.finish(interleaving(keys.size()), words_, payload);
  keepHistory();
}

bool
FastCoder::decode(const std::uint8_t* begin,
                  const std::uint8_t* end,
                  bool is_i_frame,
                  std::size_t voxel_count,
                  unsigned int bits,
                  unsigned int depth,
                  std::vector<std::uint64_t>& keys,
                  std::vector<std::uint16_t>& symbols)
{
  beginFrame(is_i_frame, depth, voxel_count);
  const unsigned int next_models = 1 - current_models_;
  FastModels& models = models_[next_models];
  models = is_i_frame ? first_models_ : models_[current_models_];
  NibbleDecoder coder(begin, end, interleaving(voxel_count), bytes_);
  if (coder.isOverrun() ||
      !occupancy_.code(coder, models, before(), next_history_, moments(), frame_))
    return false;
  expandBlocks(keys);
  if (!symbols_.decode(coder, models, frame_, moments(), bits, symbols) ||
      !coder.isAtEnd()) {
    discard();
    return false;
  }
  return true;
}

void
FastCoder::commit()
{
  keepHistory();
  current_models_ = 1 - current_models_;
}

void
FastCoder::discard()
{
  symbols_.forget(moments());
}

void
FastCoder::reset()
{
  models_[current_models_] = first_models_;
  history_ = no_history_;
}

std::size_t
FastCoder::recordCount() const
{
  std::size_t count = 0;
  for (const std::uint32_t size : history_.size)
    count += size;
  return count;
}

std::size_t
FastCoder::knownVoxels(const std::vector<std::uint64_t>& keys)
{
  if (keys.empty())
    return 0;
  FastOccupancy::match(history_, keys, frame_);
  std::size_t count = 0;
  for (const std::uint32_t number : history_.numbers)
    count += cellCount(frame_.occupied[number] & history_.known[number]);
  return count;
}

void
FastCoder::beginFrame(bool is_i_frame, unsigned int depth, std::size_t voxel_count)
{
  frame_.is_i_frame = is_i_frame;
  frame_.depth = depth;
  frame_.voxel_count = voxel_count;
}

void
FastCoder::keepHistory()
{
  if (!frame_.is_i_frame)
    next_history_.moments.swap(history_.moments);
  std::swap(history_, next_history_);
}

void
FastCoder::expandBlocks(std::vector<std::uint64_t>& keys)
{
  // Eight are written where there are fewer.
  frame_.block_of.resize(frame_.voxel_count + 8);
  frame_.cell_of.resize(frame_.voxel_count + 8);
  std::uint32_t* block_of = frame_.block_of.data();
  std::uint8_t* cell_of = frame_.cell_of.data();
  for (std::size_t i = 0; i < frame_.keys.size(); ++i) {
    const std::uint8_t* const first = cell_of;
    for (unsigned int octant = 0; octant < 8; ++octant) {
      const auto mask = static_cast<std::uint8_t>(frame_.masks[i] >> (8 * octant));
      // All eight in one word: what is added to a byte stays in it.
      std::uint64_t cells;
      std::memcpy(&cells, child_masks.children[mask].data(), 8);
      cells += 0x0808080808080808 * octant;
      std::memcpy(cell_of, &cells, 8);
      cell_of += child_masks.count[mask];
    }
    const std::uint32_t* const end = block_of + (cell_of - first);
    for (std::uint32_t* eight = block_of; eight < end; eight += 8)
      std::fill(eight, eight + 8, static_cast<std::uint32_t>(i));
    block_of += cell_of - first;
  }
  keys.resize(frame_.voxel_count);
  for (std::size_t i = 0; i < keys.size(); ++i)
    keys[i] = frame_.keys[frame_.block_of[i]] << block_key_bits | frame_.cell_of[i];
}

} // namespace io
} // namespace pcl_ext
