#include "codec/fast/known_voxels.h"

#include "bytes/reserve_ahead.h"
#include "codec/fast/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstring>
#include <limits>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();

/** \brief Groups voxels into blocks, followed by a key above all others as a sentinel.
 * \return number of blocks */
std::size_t
collectBlocks(const std::vector<std::uint64_t>& voxel_keys, Frame& frame)
{
  frame.ensureBlocks(voxel_keys.size() + 1);
  std::uint64_t* const keys = frame.keys.data();
  std::uint64_t* const masks = frame.masks.data();
  std::uint64_t last = voxel_keys.front() >> block_key_bits;
  std::uint64_t mask = 0;
  std::size_t count = 0;
  for (const std::uint64_t voxel : voxel_keys) {
    // Without a branch: key and mask of a block are written again for each of its voxels.
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

/** \brief Distance of prefetching, voxels. */
constexpr std::ptrdiff_t prefetched_voxels = 512;

/** \brief End of a bucket, where voxels are appended. */
VoxelPlace*
endOf(History& history, unsigned int past)
{
  return history.places.data() + history.first[past] + history.size[past];
}

/** \brief The probability of a past after a frame; the previous one counts as `weight`
 * voxels. */
std::uint16_t
nextProbability(std::uint16_t probability, std::uint32_t occupied, std::uint32_t count)
{
  constexpr std::uint64_t weight = 32;
  return static_cast<std::uint16_t>(
      (weight * probability + std::uint64_t{0xffff} * occupied) / (weight + count));
}

/** \brief Number of ones in the lowest two, four, six and eight bits of a byte, in eight bits
 * each. */
constexpr std::array<std::uint32_t, 256>
makePairCounts()
{
  std::array<std::uint32_t, 256> counts{};
  for (unsigned int byte = 0; byte < counts.size(); ++byte)
    for (unsigned int pairs = 1; pairs <= 4; ++pairs)
      counts[byte] |= bitCount(byte & ((1u << 2 * pairs) - 1)) << 8 * (pairs - 1);
  return counts;
}

constexpr auto pair_counts = makePairCounts();

/** \brief Splits a bucket in two, eight voxels at a time. */
struct BucketSplit {
  const VoxelPlace* from;  ///< the next voxels
  const VoxelPlace* last;  ///< the last voxel of all buckets
  VoxelPlace* if_empty;    ///< where to store the next empty voxel; two are written
  VoxelPlace* if_occupied; ///< the same for the next occupied voxel

  /** \param[in] byte occupancy of the eight voxels, the first one lowest */
  void
  operator()(unsigned int byte)
  {
    // Buckets are contiguous in memory.
    prefetch(last - from > prefetched_voxels ? from + prefetched_voxels : last);
    const std::uint32_t occupied = pair_counts[byte];
    const std::uint32_t empty = 0x08060402 - occupied;
    putTwo(0, byte << 5, 0, 0);
    putTwo(2, byte << 3, empty & 255, occupied & 255);
    putTwo(4, byte << 1, empty >> 8 & 255, occupied >> 8 & 255);
    putTwo(6, byte >> 1, empty >> 16 & 255, occupied >> 16 & 255);
    from += 8;
    if_empty += empty >> 24;
    if_occupied += occupied >> 24;
  }

private:
  /** \brief Appends two voxels to their buckets. Both are stored in both buckets, shifted so
   * that voxels of the bucket come first; others are overwritten later.
   * \param[in] first index of the first of the two among the eight
   * \param[in] bits bit 5: whether the first one is occupied
   * \param[in] empty number of empty voxels before them
   * \param[in] occupied number of occupied voxels before them
   */
  void
  putTwo(unsigned int first,
         unsigned int bits,
         std::uint32_t empty,
         std::uint32_t occupied) const
  {
    const unsigned int if_first = bits & 32;
    const unsigned int if_not = ~bits & 32;
    std::uint64_t both;
    std::memcpy(&both, from + first, sizeof(both));
    const std::uint64_t to_empty = is_big_endian ? both << if_first : both >> if_first;
    const std::uint64_t to_occupied = is_big_endian ? both << if_not : both >> if_not;
    std::memcpy(if_empty + empty, &to_empty, sizeof(both));
    std::memcpy(if_occupied + occupied, &to_occupied, sizeof(both));
  }
};

} // namespace

void
matchHistory(const History& history,
             const std::vector<std::uint64_t>& keys,
             Frame& frame)
{
  const std::size_t count = collectBlocks(keys, frame);
  const std::uint64_t* const frame_keys = frame.keys.data();
  const std::uint64_t* const frame_masks = frame.masks.data();
  frame.occupied.resize(history.known.size());
  for (auto* vector : {&frame.new_keys, &frame.new_masks}) {
    reserveAhead(*vector, count);
    vector->resize(count);
  }
  std::uint64_t* const occupied = frame.occupied.data();
  std::size_t now = 0;
  std::size_t new_count = 0;
  const auto appendNew = [&] {
    frame.new_keys[new_count] = frame_keys[now];
    frame.new_masks[new_count++] = frame_masks[now++];
  };
  // Not by walkSideBySide(), which branches on whether a known block is in the frame.
  for (std::size_t i = 0; i < history.keys.size(); ++i) {
    const std::uint64_t key = history.keys[i];
    while (frame_keys[now] < key)
      appendNew();
    const std::uint64_t is_same = frame_keys[now] == key ? 1 : 0;
    occupied[history.numbers[i]] = frame_masks[now] & (0 - is_same);
    now += is_same;
  }
  while (now < count)
    appendNew();
  frame.new_keys.resize(new_count);
  frame.new_masks.resize(new_count);
}

std::size_t
knownVoxelCount(const History& history, const Frame& frame)
{
  std::size_t count = 0;
  for (const std::uint32_t number : history.numbers)
    count += bitCount(frame.occupied[number] & history.known[number]);
  return count;
}

template <class Coder>
bool
KnownVoxels::code(
    Coder& coder, Models& models, const History& before, History& after, Frame& frame)
{
  // Each bucket is filled from up to two others.
  std::array<std::uint32_t, voxel_past::count> room{};
  std::size_t known = 0;
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    room[voxel_past::next(past, 0)] += before.size[past];
    room[voxel_past::next(past, 1)] += before.size[past];
    known += before.size[past];
  }
  std::uint32_t first = 0;
  for (std::size_t past = 0; past < voxel_past::count; ++past) {
    after.first[past] = first;
    first += room[past];
  }
  after.size.fill(0);
  // Two more, as BucketSplit writes two at a time.
  ensureSize(after.places, first + 2);
  coder.reserve(known / 8 + 7 * voxel_past::count);
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    if (before.size[past] != 0 &&
        !splitBucket(coder, models, past, before, after, frame))
      return false;
  return true;
}

template <class Coder>
bool
KnownVoxels::splitBucket(Coder& coder,
                         Models& models,
                         unsigned int past,
                         const History& before,
                         History& after,
                         Frame& frame)
{
  std::uint64_t* const occupied = frame.occupied.data();
  const auto isOccupied = [&](VoxelPlace place) {
    return static_cast<unsigned int>(occupied[place / block_cells] >>
                                     (place % block_cells)) &
           1;
  };
  const VoxelPlace* from = before.places.data() + before.first[past];
  const std::size_t count = before.size[past];
  ensureSize(occupancies_, count / 8);
  std::uint8_t* const bytes = occupancies_.data();
  if (!Coder::is_decoder)
    for (std::size_t i = 0; i < count / 8; ++i) {
      unsigned int byte = 0;
      for (unsigned int k = 0; k < 8; ++k)
        byte |= isOccupied(from[8 * i + k]) << k;
      bytes[i] = static_cast<std::uint8_t>(byte);
    }
  const unsigned int past_if_empty = voxel_past::next(past, 0);
  const unsigned int past_if_occupied = voxel_past::next(past, 1);
  VoxelPlace* const first_occupied = endOf(after, past_if_occupied);
  BucketSplit split = {from,
                       before.places.data() + before.places.size() - 1,
                       endOf(after, past_if_empty),
                       first_occupied};
  if (!coder.codeRow(
          occupancyTable(models.known_probability[past]), bytes, count / 8, split))
    return false;
  from = split.from;
  VoxelPlace* if_empty = split.if_empty;
  VoxelPlace* if_occupied = split.if_occupied;
  BitModel last_model(models.known_probability[past]);
  for (std::size_t i = 0; i < count % 8; ++i, ++from) {
    const unsigned int bit =
        coder.code(last_model, Coder::is_decoder ? 0 : isOccupied(*from));
    *if_empty = *from;
    *if_occupied = *from;
    if_empty += 1 - bit;
    if_occupied += bit;
  }
  if (Coder::is_decoder)
    for (const VoxelPlace* place = first_occupied; place != if_occupied; ++place)
      occupied[*place / block_cells] |= std::uint64_t{1} << (*place % block_cells);
  const auto occupied_count = static_cast<std::uint32_t>(if_occupied - first_occupied);
  frame.found_voxels += occupied_count;
  after.size[past_if_empty] += before.size[past] - occupied_count;
  after.size[past_if_occupied] += occupied_count;
  models.known_probability[past] = nextProbability(
      models.known_probability[past], occupied_count, before.size[past]);
  return !coder.isOverrun();
}

template bool
KnownVoxels::code(NibbleEncoder&, Models&, const History&, History&, Frame&);
template bool
KnownVoxels::code(NibbleDecoder&, Models&, const History&, History&, Frame&);

} // namespace fast
} // namespace io
} // namespace pcl_ext
