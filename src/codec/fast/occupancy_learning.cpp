#include "codec/fast/occupancy.h"
#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

/** \brief The blocks of a frame and those of the history behind it, as they grow. */
class BlockLists {
public:
  /** \param[in] most number of blocks that there may be */
  BlockLists(std::size_t most, History& after, Frame& frame)
  {
    frame.expectBlocks(most);
    after.keys.resize(most);
    after.numbers.resize(most);
    after.activity.resize(most);
    frame_keys_ = frame.keys.data();
    frame_masks_ = frame.masks.data();
    frame_numbers_ = frame.numbers.data();
    kept_keys_ = after.keys.data();
    kept_numbers_ = after.numbers.data();
    kept_activity_ = after.activity.data();
  }

  /** \brief Appends a block; without branches: what is not counted is written over.
   * \param[in] is_kept 1 or 0
   */
  void
  append(std::uint64_t key,
         std::uint32_t number,
         std::uint64_t occupied,
         unsigned int activity,
         std::size_t is_kept)
  {
    frame_keys_[in_frame_] = key;
    frame_masks_[in_frame_] = occupied;
    frame_numbers_[in_frame_] = number;
    in_frame_ += isNotZero(occupied);
    kept_keys_[kept_] = key;
    kept_numbers_[kept_] = number;
    kept_activity_[kept_] = static_cast<std::uint8_t>(activity);
    kept_ += is_kept;
  }

  void
  finish(History& after, Frame& frame) const
  {
    frame.block_count = in_frame_;
    after.keys.resize(kept_);
    after.numbers.resize(kept_);
    after.activity.resize(kept_);
  }

private:
  std::uint64_t* frame_keys_;
  std::uint64_t* frame_masks_;
  std::uint32_t* frame_numbers_;
  std::uint64_t* kept_keys_;
  std::uint32_t* kept_numbers_;
  std::uint8_t* kept_activity_;
  std::size_t in_frame_ = 0;
  std::size_t kept_ = 0;
};

} // namespace

/** \brief Takes the forgotten voxels out, and finds room and numbers for new ones. */
void
Occupancy::makeRoom(const History& before,
                    History& after,
                    Moments& moments,
                    const Frame& frame)
{
  std::uint32_t end = 0;
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    end = std::max(end, after.first[past] + after.size[past]);
    if (!voxel_past::isForgotten(past))
      continue;
    const VoxelPlace* const places = after.places.data() + after.first[past];
    for (std::uint32_t i = 0; i < after.size[past]; ++i)
      after.known[places[i] / block_cells] &=
          ~(std::uint64_t{1} << (places[i] % block_cells));
    after.size[past] = 0;
  }
  const std::size_t spare =
      std::min(before.spare_numbers.size(), frame.new_keys.size());
  after.spare_numbers.assign(before.spare_numbers.begin(),
                             before.spare_numbers.end() -
                                 static_cast<std::ptrdiff_t>(spare));
  after.known.resize(before.known.size() + frame.new_keys.size() - spare, 0);
  ensureSize(moments, after.known.size() * block_cells);
  // New voxels come behind all others: nothing else gets into their bucket.
  ensureSize(after.places, end + frame.voxel_count + 2);
  after.first[frame.is_i_frame ? voxel_past::born_in_i_frame
                               : voxel_past::born_in_p_frame] = end;
}

bool
Occupancy::learnBlocks(const History& before,
                       History& after,
                       Moments& moments,
                       Frame& frame)
{
  makeRoom(before, after, moments, frame);
  const unsigned int born =
      frame.is_i_frame ? voxel_past::born_in_i_frame : voxel_past::born_in_p_frame;
  VoxelPlace* place = after.places.data() + after.first[born];
  std::uint64_t* const known = after.known.data();
  std::uint16_t* const all_moments = moments.data();
  const auto add = [&](std::uint32_t number, std::uint64_t cells) {
    known[number] |= cells;
    const std::uint32_t first = number * block_cells;
    const unsigned int count = cellCount(cells);
    // Two at a time, the highest one twice if it has none beside it: how many there
    // are is hard to predict.
    for (unsigned int done = 0; done < count; done += 2)
      for (unsigned int k = 0; k < 2; ++k) {
        const VoxelPlace added = first + lowestCell(cells);
        place[done + k] = added;
        all_moments[added] = History::no_moment;
        const std::uint64_t others = cells & (cells - 1);
        cells = others != 0 ? others : cells;
      }
    place += count;
  };
  for (std::size_t i = 0; i < renewed_count_; ++i) {
    const std::uint32_t number = before.numbers[renewed_blocks_[i]];
    add(number, frame.occupied[number] & ~before.known[number]);
  }
  numberNewBlocks(before, frame);
  for (std::size_t i = 0; i < new_numbers_.size(); ++i)
    add(new_numbers_[i], frame.new_masks[i]);
  after.size[born] =
      static_cast<std::uint32_t>(place - after.places.data()) - after.first[born];
  return mergeBlocks(before, after, frame);
}

/** \brief New blocks take the numbers that became free last, then further ones. */
void
Occupancy::numberNewBlocks(const History& before, const Frame& frame)
{
  const std::size_t spare = before.spare_numbers.size();
  auto next = static_cast<std::uint32_t>(before.known.size());
  new_numbers_.resize(frame.new_keys.size());
  for (std::size_t i = 0; i < new_numbers_.size(); ++i)
    new_numbers_[i] = i < spare ? before.spare_numbers[spare - 1 - i] : next++;
}

/** \brief Makes the ascending blocks of the frame, and those of the history behind it.
 * \return false if a new block is not new
 */
bool
Occupancy::mergeBlocks(const History& before, History& after, Frame& frame)
{
  const std::size_t count = before.keys.size();
  const std::size_t new_count = frame.new_keys.size();
  BlockLists lists(count + new_count, after, frame);
  ensureSize(freed_numbers_, count + 1);
  std::uint32_t* const freed = freed_numbers_.data();
  std::size_t freed_count = 0;
  // Pointers of its own: a byte stored might be a vector's, for all the compiler knows.
  const std::uint64_t* const known = after.known.data();
  const std::uint64_t* const all_occupied = frame.occupied.data();
  const std::uint64_t* const old_keys = before.keys.data();
  const std::uint32_t* const old_numbers = before.numbers.data();
  const std::uint8_t* const old_activity = before.activity.data();
  const std::uint8_t* const symbols = octant_symbols_.data();
  const auto appendOld = [&](std::size_t i) {
    const std::uint32_t number = old_numbers[i];
    const unsigned int activity =
        (old_activity[i] * 2u + (symbols[i] != 0 ? 1 : 0)) % 16;
    const std::size_t is_kept = isNotZero(known[number]);
    freed[freed_count] = number;
    freed_count += 1 - is_kept;
    lists.append(old_keys[i], number, all_occupied[number], activity, is_kept);
  };
  const unsigned int new_activity = frame.is_i_frame ? 0 : 3;
  std::size_t i = 0;
  for (std::size_t now = 0; now < new_count; ++now) {
    const std::uint64_t key = frame.new_keys[now];
    for (; i < count && old_keys[i] < key; ++i)
      appendOld(i);
    if (i < count && old_keys[i] == key)
      return false;
    lists.append(key, new_numbers_[now], frame.new_masks[now], new_activity, 1);
  }
  for (; i < count; ++i)
    appendOld(i);
  lists.finish(after, frame);
  after.spare_numbers.insert(after.spare_numbers.end(), freed, freed + freed_count);
  return true;
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
