#include "codec/fast/entropy_coder.h"
#include "codec/fast/occupancy.h"
#include "simd/bit_operations.h"
#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstring>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

/** \brief How far ahead of the voxels that are looked at others are asked for. */
constexpr std::ptrdiff_t prefetched_voxels = 512;

/** \brief The end of a bucket, where more is put in. */
VoxelPlace*
end(History& history, unsigned int past)
{
  return history.places.data() + history.first[past] + history.size[past];
}

/** \brief What a bucket teaches: the share before counts as much as so many voxels. */
std::uint16_t
learntShare(std::uint16_t share, std::uint32_t occupied, std::uint32_t count)
{
  constexpr std::uint64_t weight = 32;
  return static_cast<std::uint16_t>(
      (weight * share + std::uint64_t{0xffff} * occupied) / (weight + count));
}

/** \brief How many of the first two, four, six and eight bits of a byte are set, in
 * eight bits each. */
constexpr std::array<std::uint32_t, 256>
makePairCounts()
{
  std::array<std::uint32_t, 256> counts{};
  for (unsigned int byte = 0; byte < counts.size(); ++byte)
    for (unsigned int pairs = 1; pairs <= 4; ++pairs)
      counts[byte] |= cellCount(byte & ((1u << 2 * pairs) - 1)) << 8 * (pairs - 1);
  return counts;
}

constexpr auto pair_counts = makePairCounts();

/** \brief Splits a bucket in two, eight voxels at a time. */
struct BucketSplit {
  const VoxelPlace* from;  ///< the voxels that come next
  const VoxelPlace* last;  ///< of all buckets
  VoxelPlace* if_empty;    ///< where the next empty voxel goes; there is room for two
  VoxelPlace* if_occupied; ///< where the next occupied one goes; likewise

  /** \param[in] byte whether they are occupied, the first one lowest */
  void
  operator()(unsigned int byte)
  {
    // Buckets follow each other, so that what comes behind one is the next one.
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
  /** \brief Puts two voxels where they belong.
   * \param[in] first which of the eight
   * \param[in] bits bit 5: whether the first of them is occupied
   * \param[in] empty number of empty ones before them
   * \param[in] occupied number of occupied ones before them
   */
  void
  putTwo(unsigned int first,
         unsigned int bits,
         std::uint32_t empty,
         std::uint32_t occupied) const
  {
    // Both buckets get both, of which only the second one if the first one is not
    // theirs: one store each, and no branch.
    const unsigned int if_first = bits & 32;
    const unsigned int if_not = ~bits & 32;
    std::uint64_t both;
    std::memcpy(&both, from + first, sizeof(both));
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    const std::uint64_t to_empty = both << if_first;
    const std::uint64_t to_occupied = both << if_not;
#else
    const std::uint64_t to_empty = both >> if_first;
    const std::uint64_t to_occupied = both >> if_not;
#endif
    std::memcpy(if_empty + empty, &to_empty, sizeof(both));
    std::memcpy(if_occupied + occupied, &to_occupied, sizeof(both));
  }
};

} // namespace

template <class Coder>
bool
Occupancy::codeKnownVoxels(
    Coder& coder, Models& models, const History& before, History& after, Frame& frame)
{
  // A bucket has room for all of those that it may be filled from.
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
  // Two more: two voxels are written to both buckets, of which each stays in one.
  ensureSize(after.places, first + 2);
  coder.expect(known / 8 + 7 * voxel_past::count);
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    if (before.size[past] != 0 &&
        !splitBucket(coder, models, past, before, after, frame))
      return false;
  return true;
}

template <class Coder>
bool
Occupancy::splitBucket(Coder& coder,
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
  VoxelPlace* const first_occupied = end(after, past_if_occupied);
  BucketSplit split = {from,
                       before.places.data() + before.places.size() - 1,
                       end(after, past_if_empty),
                       first_occupied};
  if (!coder.codeRow(occupancyTable(models.known_share[past]), bytes, count / 8, split))
    return false;
  from = split.from;
  VoxelPlace* if_empty = split.if_empty;
  VoxelPlace* if_occupied = split.if_occupied;
  BitModel rest(models.known_share[past]);
  for (std::size_t i = 0; i < count % 8; ++i, ++from) {
    const unsigned int bit =
        coder.code(rest, Coder::is_decoder ? 0 : isOccupied(*from));
    *if_empty = *from;
    *if_occupied = *from;
    if_empty += 1 - bit;
    if_occupied += bit;
  }
  if (Coder::is_decoder)
    for (const VoxelPlace* place = first_occupied; place != if_occupied; ++place)
      occupied[*place / block_cells] |= std::uint64_t{1} << (*place % block_cells);
  const auto occupied_count = static_cast<std::uint32_t>(if_occupied - first_occupied);
  found_voxels_ += occupied_count;
  after.size[past_if_empty] += before.size[past] - occupied_count;
  after.size[past_if_occupied] += occupied_count;
  models.known_share[past] =
      learntShare(models.known_share[past], occupied_count, before.size[past]);
  return !coder.isOverrun();
}

template bool
Occupancy::codeKnownVoxels(NibbleEncoder&, Models&, const History&, History&, Frame&);
template bool
Occupancy::codeKnownVoxels(NibbleDecoder&, Models&, const History&, History&, Frame&);

} // namespace fast
} // namespace io
} // namespace pcl_ext
