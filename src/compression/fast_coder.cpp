#include "fast_coder.h"

#include "nibble_rans.h"
#include "voxel_block.h"

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
  expandBlocks<false>(nullptr);
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
  expandBlocks<true>(&keys);
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
  symbols_.forget(frame_, moments());
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

/** \brief Lists the voxels of the frame's blocks: their places, and for a decoder their
 * keys. */
template <bool with_keys>
void
FastCoder::expandBlocks(std::vector<std::uint64_t>* keys)
{
  ensureSize(frame_.places, frame_.voxel_count + 8);
  VoxelPlace* place = frame_.places.data();
  std::uint64_t* key = nullptr;
  if constexpr (with_keys) {
    keys->resize(frame_.voxel_count + 8);
    key = keys->data();
  }
  constexpr std::uint64_t no_cell = std::uint64_t{1} << 63;
  const std::size_t count = frame_.block_count;
  const std::uint64_t* const block_keys = frame_.keys.data();
  const std::uint64_t* const masks = frame_.masks.data();
  const std::uint32_t* const numbers = frame_.numbers.data();
  for (std::size_t i = 0; i < count; ++i) {
    const VoxelPlace first = numbers[i] * block_cells;
    const std::uint64_t block_key = block_keys[i] << block_key_bits;
    std::uint64_t mask = masks[i];
    const unsigned int cells = cellCount(mask);
    // Eight at a time, some of them for nothing: how many there are is hard to predict.
    for (unsigned int done = 0; done < cells; done += 8)
      for (unsigned int k = 0; k < 8; ++k, mask &= mask - 1) {
        const unsigned int cell = lowestCell(mask | no_cell);
        place[done + k] = first + cell;
        if constexpr (with_keys)
          key[done + k] = block_key + cell;
      }
    place += cells;
    if constexpr (with_keys)
      key += cells;
  }
  if constexpr (with_keys)
    keys->resize(frame_.voxel_count);
}

} // namespace io
} // namespace pcl_ext
