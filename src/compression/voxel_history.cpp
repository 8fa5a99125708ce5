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
VoxelHistory::Records::reserve(std::size_t size)
{
  if (size <= probability.size())
    return;
  probability.resize(size);
  recent.resize(size);
  age.resize(size);
  mean.resize(size);
  deviation.resize(size);
  depth_offset.resize(size);
  roughness.resize(size);
}

void
VoxelHistory::clear(unsigned int symbol_bits, std::uint16_t forgotten_below)
{
  blocks_.clear();
  records_.count = 0;
  fraction_bits_ = std::min(4u, 16 - symbol_bits);
  forgotten_below_ = forgotten_below;
}

/** \brief Writes the next state record by record; there is room for all. */
struct VoxelHistory::Writer {
  const Records& from;
  Records& to;
  const DepthObservations* depths;
  unsigned int fraction_bits;
  std::uint32_t forgotten_below;
  std::size_t size = 0;

  /** \brief The record of a known voxel after one more frame.
   * \return false if it is forgotten
   */
  bool
  keep(std::size_t record, bool is_occupied, std::uint16_t number, std::size_t voxel)
  {
    const std::uint32_t before = from.probability[record];
    const std::uint8_t age = from.age[record];
    const unsigned int shift = rateShift(age);
    const std::uint32_t probability = is_occupied
                                          ? before + ((0xffff - before) >> shift)
                                          : before - (before >> shift);
    to.probability[size] = static_cast<std::uint16_t>(probability);
    to.recent[size] = static_cast<std::uint8_t>(from.recent[record] << 1 |
                                                static_cast<int>(is_occupied));
    to.age[size] = static_cast<std::uint8_t>(age + (age < 0xff ? 1 : 0));
    to.mean[size] = from.mean[record];
    to.deviation[size] = from.deviation[record];
    to.depth_offset[size] = from.depth_offset[record];
    to.roughness[size] = from.roughness[record];
    if (is_occupied)
      learnNumber(number);
    if (is_occupied && depths != nullptr)
      learnDepth(voxel);
    const bool is_kept = probability >= forgotten_below;
    size += is_kept ? 1 : 0;
    return is_kept;
  }

  void
  add(std::uint16_t number, std::size_t voxel, std::uint16_t probability)
  {
    to.probability[size] = probability;
    to.recent[size] = 1;
    to.age[size] = 0;
    const int value = fixedPoint(number);
    to.mean[size] = static_cast<std::uint16_t>(value);
    to.deviation[size] =
        static_cast<std::uint16_t>(std::max(1 << fraction_bits, value >> 2));
    to.depth_offset[size] =
        depths != nullptr ? depths->offsets[voxel] : std::int16_t{0};
    to.roughness[size] =
        static_cast<std::uint8_t>(depths != nullptr ? depths->rests[voxel] << 4 : 0);
    ++size;
  }

  /** \brief A number with the history's fraction bits; numbers have 16 bits with them. */
  int
  fixedPoint(std::uint16_t number) const
  {
    return static_cast<int>(number) << fraction_bits;
  }

  void
  learnNumber(std::uint16_t number)
  {
    const int value = fixedPoint(number);
    std::uint16_t& mean = to.mean[size];
    std::uint16_t& deviation = to.deviation[size];
    // Differences are halved towards minus infinity by a shift that every compiler that
    // this library meets does alike; C++20 promises it.
    const int distance = std::abs(value - static_cast<int>(mean));
    deviation = static_cast<std::uint16_t>(
        static_cast<int>(deviation) + ((distance - static_cast<int>(deviation)) >> 2));
    mean = static_cast<std::uint16_t>(static_cast<int>(mean) +
                                      ((value - static_cast<int>(mean)) >> 2));
  }

  void
  learnDepth(std::size_t voxel)
  {
    std::int16_t& offset = to.depth_offset[size];
    offset =
        static_cast<std::int16_t>(offset + ((depths->offsets[voxel] - offset) >> 2));
    std::uint8_t& roughness = to.roughness[size];
    roughness = static_cast<std::uint8_t>(
        roughness + (((depths->rests[voxel] << 4) - roughness) >> 2));
  }
};

void
VoxelHistory::update(const BlockList& frame,
                     const std::vector<std::uint16_t>& numbers,
                     const DepthObservations* depths,
                     bool is_i_frame)
{
  // At most every record stays and every voxel is new.
  next_records_.reserve(records_.count + numbers.size());
  next_blocks_.clear();
  Writer writer{records_, next_records_, depths, fraction_bits_, forgotten_below_};
  const std::uint16_t first_probability =
      is_i_frame ? first_probability_i_frame : first_probability_p_frame;
  const std::uint8_t first_activity = is_i_frame ? 0 : first_activity_p_frame;
  constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();
  std::size_t old = 0;
  std::size_t now = 0;
  while (old < blocks_.size() || now < frame.size()) {
    const std::uint64_t old_key = old < blocks_.size() ? blocks_[old].key : no_key;
    const std::uint64_t now_key = now < frame.size() ? frame.keys[now] : no_key;
    HistoryBlock block{std::min(old_key, now_key), 0, 0, 0, first_activity};
    block.first_record = static_cast<std::uint32_t>(writer.size);
    std::uint64_t known = 0;
    std::size_t record = 0;
    if (old_key == block.key) {
      known = blocks_[old].known;
      record = blocks_[old].first_record;
      block.activity = blocks_[old].activity;
      ++old;
    }
    std::uint64_t occupied = 0;
    std::size_t voxel = 0;
    if (now_key == block.key) {
      occupied = frame.masks[now];
      voxel = frame.first_voxels[now];
      ++now;
    }
    for (std::uint64_t cells = known | occupied; cells != 0; cells &= cells - 1) {
      const std::uint64_t cell = cells & (~cells + 1);
      const bool is_occupied = (occupied & cell) != 0;
      const std::uint16_t number = is_occupied ? numbers[voxel] : std::uint16_t{0};
      if ((known & cell) == 0) {
        writer.add(number, voxel, first_probability);
        block.known |= cell;
      }
      else if (writer.keep(record++, is_occupied, number, voxel))
        block.known |= cell;
      voxel += is_occupied ? 1 : 0;
    }
    const unsigned int new_voxels =
        is_i_frame ? 0 : std::min(cellCount(occupied & ~known), 7u);
    block.activity = static_cast<std::uint8_t>(std::min<unsigned int>(
        (block.activity * 3u + new_voxels * 2u + 2u) / 4u, most_active));
    block.last = occupied;
    if (block.known != 0)
      next_blocks_.push_back(block);
  }
  next_records_.count = writer.size;
  blocks_.swap(next_blocks_);
  std::swap(records_, next_records_);
}

} // namespace io
} // namespace pcl_ext
