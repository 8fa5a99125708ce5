#include "voxel_history.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace pcl_ext {
namespace io {

namespace {

// A voxel of an I-frame most likely stays; most of those that turn up later are noise.
constexpr std::uint16_t first_probability_i_frame = 52000;
constexpr std::uint16_t first_probability_p_frame = 26000;
constexpr std::uint8_t most_active = 7;
constexpr std::uint8_t first_activity_p_frame = 2;

/** \brief Share of the way to the newest frame that a probability moves, as a shift:
 * 1/2 for 2 frames, 1/4 up to the fifth, 1/8 up to the tenth, then 1/16. */
constexpr unsigned int
rateShift(unsigned int age)
{
  return age < 2 ? 1 : age < 5 ? 2 : age < 10 ? 3 : 4;
}

} // namespace

void
VoxelHistory::clear(unsigned int symbol_bits, std::uint16_t forgotten_below)
{
  blocks_.clear();
  record_count_ = 0;
  fraction_bits_ = std::min(4u, 16 - symbol_bits);
  forgotten_below_ = forgotten_below;
}

/** \brief How one frame changes the records. Written without branches, as whether a
 * voxel is occupied is what nobody could predict. */
struct VoxelHistory::Learning {
  const DepthObservations* depths;
  unsigned int fraction_bits;
  std::uint16_t first_probability;

  /** \brief A number with the history's fraction bits; numbers have 16 bits with them. */
  int
  fixedPoint(std::uint16_t number) const
  {
    return static_cast<int>(number) << fraction_bits;
  }

  VoxelRecord
  begin(std::uint16_t number, std::size_t voxel) const
  {
    const int value = fixedPoint(number);
    VoxelRecord record{};
    record.probability = first_probability;
    record.mean = static_cast<std::uint16_t>(value);
    record.deviation =
        static_cast<std::uint16_t>(std::max(1 << fraction_bits, value >> 2));
    record.recent = 1;
    if (depths != nullptr) {
      record.depth_offset = depths->offsets[voxel];
      record.roughness = static_cast<std::uint8_t>(depths->rests[voxel] << 4);
    }
    return record;
  }

  /** \brief Another frame.
   * \param[in] is_occupied 1 or 0
   * \param[in] number of the voxel, whatever it is if it is not occupied
   */
  void
  goOn(VoxelRecord& record,
       std::uint32_t is_occupied,
       std::uint16_t number,
       std::size_t voxel) const
  {
    // Towards 0xffff or 0, rounded towards the old value.
    const std::uint32_t flip = (0 - is_occupied) & 0xffff;
    const std::uint32_t distance = record.probability ^ flip;
    record.probability = static_cast<std::uint16_t>(
        (distance - (distance >> rateShift(record.age))) ^ flip);
    record.recent = static_cast<std::uint8_t>(record.recent << 1 | is_occupied);
    record.age = static_cast<std::uint8_t>(record.age + (record.age < 0xff ? 1 : 0));
    // Differences are divided by a shift, towards minus infinity, which every compiler
    // that this library meets does alike; C++20 promises it.
    const int mask = -static_cast<int>(is_occupied);
    const int difference = fixedPoint(number) - static_cast<int>(record.mean);
    const int spread = std::abs(difference) - static_cast<int>(record.deviation);
    record.mean = static_cast<std::uint16_t>(record.mean + (difference >> 2 & mask));
    record.deviation =
        static_cast<std::uint16_t>(record.deviation + (spread >> 2 & mask));
    if (depths != nullptr && is_occupied != 0)
      learnDepth(record, voxel);
  }

  void
  learnDepth(VoxelRecord& record, std::size_t voxel) const
  {
    record.depth_offset = static_cast<std::int16_t>(
        record.depth_offset + ((depths->offsets[voxel] - record.depth_offset) >> 2));
    record.roughness = static_cast<std::uint8_t>(
        record.roughness + (((depths->rests[voxel] << 4) - record.roughness) >> 2));
  }
};

void
VoxelHistory::update(const BlockList& frame,
                     const std::vector<std::uint16_t>& numbers,
                     const DepthObservations* depths,
                     bool is_i_frame)
{
  // At most every record stays and every voxel is new.
  if (next_records_.size() < record_count_ + numbers.size())
    next_records_.resize(record_count_ + numbers.size());
  next_blocks_.clear();
  const Learning learning{depths,
                          fraction_bits_,
                          is_i_frame ? first_probability_i_frame
                                     : first_probability_p_frame};
  const std::uint8_t first_activity = is_i_frame ? 0 : first_activity_p_frame;
  const std::size_t last_voxel = numbers.empty() ? 0 : numbers.size() - 1;
  const std::uint16_t no_number = 0;
  const std::uint16_t* const number_of = numbers.empty() ? &no_number : numbers.data();
  constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();
  const VoxelRecord* record = records_.data();
  VoxelRecord* const begin = next_records_.data();
  VoxelRecord* next = begin;
  std::size_t voxel = 0;
  std::size_t old = 0;
  std::size_t now = 0;
  while (old < blocks_.size() || now < frame.size()) {
    const std::uint64_t old_key = old < blocks_.size() ? blocks_[old].key : no_key;
    const std::uint64_t now_key = now < frame.size() ? frame.keys[now] : no_key;
    HistoryBlock block{std::min(old_key, now_key), 0, 0, 0, first_activity};
    block.first_record = static_cast<std::uint32_t>(next - begin);
    std::uint64_t known = 0;
    if (old_key == block.key) {
      known = blocks_[old].known;
      block.activity = blocks_[old].activity;
      ++old;
    }
    if (now_key == block.key)
      block.last = frame.masks[now++];
    for (std::uint64_t cells = known | block.last; cells != 0; cells &= cells - 1) {
      const unsigned int cell = lowestCell(cells);
      const auto is_occupied = static_cast<std::uint32_t>(block.last >> cell & 1);
      const std::uint16_t number = number_of[std::min(voxel, last_voxel)];
      std::uint64_t is_kept = 1;
      if ((known >> cell & 1) != 0) {
        *next = *record++;
        learning.goOn(*next, is_occupied, number, voxel);
        is_kept = next->probability >= forgotten_below_ ? 1 : 0;
      }
      else
        *next = learning.begin(number, voxel);
      next += is_kept;
      block.known |= is_kept << cell;
      voxel += is_occupied;
    }
    const unsigned int new_voxels =
        is_i_frame ? 0 : std::min(cellCount(block.last & ~known), 7u);
    block.activity = static_cast<std::uint8_t>(std::min<unsigned int>(
        (block.activity * 3u + new_voxels * 2u + 2u) / 4u, most_active));
    if (block.known != 0)
      next_blocks_.push_back(block);
  }
  record_count_ = static_cast<std::size_t>(next - begin);
  blocks_.swap(next_blocks_);
  records_.swap(next_records_);
}

} // namespace io
} // namespace pcl_ext
