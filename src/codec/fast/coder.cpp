#include "codec/fast/coder.h"

#include "codec/fast/entropy_coder.h"
#include "voxels/voxel_block.h"

#include <utility>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

const History no_history;

/** \brief All models as they are at an I-frame. */
const Models&
firstModels()
{
  static const Models models;
  return models;
}

/** \brief Lists the voxels of the frame's blocks: their places, and for a decoder their
 * keys. */
template <bool with_keys>
void
expandBlocks(Frame& frame, std::vector<std::uint64_t>* keys)
{
  ensureSize(frame.places, frame.voxel_count + 8);
  VoxelPlace* place = frame.places.data();
  std::uint64_t* key = nullptr;
  if constexpr (with_keys) {
    keys->resize(frame.voxel_count + 8);
    key = keys->data();
  }
  constexpr std::uint64_t no_cell = std::uint64_t{1} << 63;
  const std::size_t count = frame.block_count;
  const std::uint64_t* const block_keys = frame.keys.data();
  const std::uint64_t* const masks = frame.masks.data();
  const std::uint32_t* const numbers = frame.numbers.data();
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
    keys->resize(frame.voxel_count);
}

} // namespace

void
FrameCoder::encode(Workspace& work,
                   bool is_i_frame,
                   const std::vector<std::uint64_t>& keys,
                   const std::vector<std::uint16_t>& symbols,
                   unsigned int bits,
                   unsigned int depth,
                   std::vector<std::uint8_t>& payload)
{
  beginFrame(work, is_i_frame, depth, keys.size());
  if (is_i_frame)
    *models_ = firstModels();
  Occupancy::match(before(), keys, work.frame);
  NibbleEncoder coder(work.steps);
  work.occupancy.code(
      coder, *models_, before(), work.next_history, moments(), work.frame);
  expandBlocks<false>(work.frame, nullptr);
  work.symbols.encode(coder, *models_, work.frame, moments(), bits, symbols);
  coder.finish(interleavingOf(keys.size()), work.words, payload);
  history_.makeRoomFor(work.next_history);
  learnHistory();
}

bool
FrameCoder::decode(Workspace& work,
                   const std::uint8_t* begin,
                   const std::uint8_t* end,
                   bool is_i_frame,
                   std::size_t voxel_count,
                   unsigned int bits,
                   unsigned int depth,
                   std::vector<std::uint64_t>& keys,
                   std::vector<std::uint16_t>& symbols)
{
  beginFrame(work, is_i_frame, depth, voxel_count);
  Frame& frame = work.frame;
  *work.models = is_i_frame ? firstModels() : *models_;
  NibbleDecoder coder(begin, end, interleavingOf(voxel_count), work.bytes);
  if (coder.isOverrun() ||
      !work.occupancy.code(
          coder, *work.models, before(), work.next_history, moments(), frame))
    return false;
  expandBlocks<true>(frame, &keys);
  if (work.symbols.decode(coder, *work.models, frame, moments(), bits, symbols) &&
      coder.isAtEnd()) {
    history_.makeRoomFor(work.next_history);
    return true;
  }
  discard();
  return false;
}

void
FrameCoder::learn() noexcept
{
  models_.swap(workspace_->models);
  learnHistory();
}

void
FrameCoder::discard() noexcept
{
  workspace_->symbols.forget(workspace_->frame, moments());
}

void
FrameCoder::reset() noexcept
{
  *models_ = firstModels();
  history_.clear();
}

std::size_t
FrameCoder::recordCount() const
{
  return history_.voxelCount();
}

std::size_t
FrameCoder::knownVoxels(Workspace& work, const std::vector<std::uint64_t>& keys) const
{
  if (keys.empty())
    return 0;
  Frame& frame = work.frame;
  Occupancy::match(history_, keys, frame);
  std::size_t count = 0;
  for (const std::uint32_t number : history_.numbers)
    count += cellCount(frame.occupied[number] & history_.known[number]);
  return count;
}

void
FrameCoder::beginFrame(Workspace& work,
                       bool is_i_frame,
                       unsigned int depth,
                       std::size_t voxel_count)
{
  workspace_ = &work;
  work.frame.is_i_frame = is_i_frame;
  work.frame.depth = depth;
  work.frame.voxel_count = voxel_count;
}

const History&
FrameCoder::before() const
{
  return workspace_->frame.is_i_frame ? no_history : history_;
}

Moments&
FrameCoder::moments() noexcept
{
  return workspace_->frame.is_i_frame ? workspace_->next_history.moments
                                      : history_.moments;
}

void
FrameCoder::learnHistory() noexcept
{
  // In a P-frame the moments were learnt where they are.
  history_.learn(workspace_->next_history, workspace_->frame.is_i_frame);
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
