#include "fast_occupancy.h"
#include "voxel_block.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

/** \brief Takes the forgotten voxels out, and finds room and numbers for new ones. */
void
FastOccupancy::makeRoom(const FastHistory& before,
                        FastHistory& after,
                        std::vector<std::uint16_t>& moments,
                        const FastFrame& frame)
{
  after.known.assign(before.known.begin(), before.known.end());
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
FastOccupancy::learnBlocks(const FastHistory& before,
                           FastHistory& after,
                           std::vector<std::uint16_t>& moments,
                           FastFrame& frame)
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
        all_moments[added] = FastHistory::no_moment;
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
FastOccupancy::numberNewBlocks(const FastHistory& before, const FastFrame& frame)
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
FastOccupancy::mergeBlocks(const FastHistory& before,
                           FastHistory& after,
                           FastFrame& frame)
{
  const std::size_t count = before.keys.size();
  const std::size_t new_count = frame.new_keys.size();
  frame.expectBlocks(count + new_count);
  after.keys.resize(count + new_count);
  after.numbers.resize(count + new_count);
  after.activity.resize(count + new_count);
  // Pointers of its own: a byte stored might be a vector's, for all the compiler knows.
  std::uint64_t* const frame_keys = frame.keys.data();
  std::uint64_t* const frame_masks = frame.masks.data();
  std::uint32_t* const frame_numbers = frame.numbers.data();
  std::uint64_t* const kept_keys = after.keys.data();
  std::uint32_t* const kept_numbers = after.numbers.data();
  std::uint8_t* const kept_activity = after.activity.data();
  const std::uint64_t* const known = after.known.data();
  const std::uint64_t* const all_occupied = frame.occupied.data();
  const std::uint64_t* const old_keys = before.keys.data();
  const std::uint32_t* const old_numbers = before.numbers.data();
  const std::uint8_t* const old_activity = before.activity.data();
  const std::uint8_t* const is_renewed = is_renewed_.data();
  std::size_t in_frame = 0;
  std::size_t kept = 0;
  ensureSize(freed_numbers_, count + 1);
  std::uint32_t* const freed = freed_numbers_.data();
  std::size_t freed_count = 0;
  const auto append = [&](std::uint64_t key,
                          std::uint32_t number,
                          std::uint64_t occupied,
                          unsigned int activity) {
    // Without branches: what is not counted is written over.
    frame_keys[in_frame] = key;
    frame_masks[in_frame] = occupied;
    frame_numbers[in_frame] = number;
    in_frame += isNotZero(occupied);
    kept_keys[kept] = key;
    kept_numbers[kept] = number;
    kept_activity[kept] = static_cast<std::uint8_t>(activity);
    kept += isNotZero(known[number]);
  };
  const auto appendOld = [&](std::size_t i) {
    const std::uint32_t number = old_numbers[i];
    const unsigned int activity = (old_activity[i] * 2u + is_renewed[i]) % 16;
    freed[freed_count] = number;
    freed_count += 1 - isNotZero(known[number]);
    append(old_keys[i], number, all_occupied[number], activity);
  };
  std::size_t now = 0;
  const auto appendNew = [&] {
    append(frame.new_keys[now],
           new_numbers_[now],
           frame.new_masks[now],
           frame.is_i_frame ? 0 : 3);
    ++now;
  };
  std::size_t i = 0;
  while (now < new_count) {
    const std::uint64_t end = frame.new_keys[now];
    for (; i < count && old_keys[i] < end; ++i)
      appendOld(i);
    if (i < count && old_keys[i] == end)
      return false;
    appendNew();
  }
  for (; i < count; ++i)
    appendOld(i);
  frame.block_count = in_frame;
  after.keys.resize(kept);
  after.numbers.resize(kept);
  after.activity.resize(kept);
  after.spare_numbers.insert(after.spare_numbers.end(), freed, freed + freed_count);
  return true;
}

} // namespace io
} // namespace pcl_ext
