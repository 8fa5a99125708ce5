#include "fast_occupancy.h"
#include "nibble_rans.h"
#include "voxel_block.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

namespace {

/** \brief The end of a bucket, where more is put in. */
VoxelPlace*
end(FastHistory& history, unsigned int past)
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

} // namespace

template <class Coder>
bool
FastOccupancy::codeKnownVoxels(Coder& coder,
                               FastModels& models,
                               const FastHistory& before,
                               FastHistory& after,
                               FastFrame& frame)
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
  // One more: a voxel is written to both buckets and stays in one.
  ensureSize(after.places, first + 1);
  coder.expect(known / 8 + 7 * voxel_past::count);
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    if (before.size[past] != 0 &&
        !splitBucket(coder, models, past, before, after, frame))
      return false;
  return true;
}

template <class Coder>
bool
FastOccupancy::splitBucket(Coder& coder_now,
                           FastModels& models,
                           unsigned int past,
                           const FastHistory& before,
                           FastHistory& after,
                           FastFrame& frame)
{
  Coder coder = coder_now; // in registers
  std::uint64_t* const occupied = frame.occupied.data();
  const auto isOccupied = [&](VoxelPlace place) {
    return static_cast<unsigned int>(occupied[place / block_cells] >>
                                     (place % block_cells)) &
           1;
  };
  const unsigned int past_if_empty = voxel_past::next(past, 0);
  const unsigned int past_if_occupied = voxel_past::next(past, 1);
  VoxelPlace* if_empty = end(after, past_if_empty);
  VoxelPlace* const first_occupied = end(after, past_if_occupied);
  VoxelPlace* if_occupied = first_occupied;
  const auto put = [&](VoxelPlace place, unsigned int bit) {
    *if_empty = place;
    *if_occupied = place;
    if_empty += 1 - bit;
    if_occupied += bit;
  };
  const VoxelPlace* from = before.places.data() + before.first[past];
  const std::size_t count = before.size[past];
  const ByteTable& table = occupancyTable(models.known_share[past]);
  for (std::size_t i = 0; i < count / 8; ++i, from += 8) {
    unsigned int byte = 0;
    if (!Coder::is_decoder)
      for (unsigned int k = 0; k < 8; ++k)
        byte |= isOccupied(from[k]) << k;
    byte = coder.code(table, byte);
    for (unsigned int k = 0; k < 8; ++k)
      put(from[k], byte >> k & 1);
    if (coder.isOverrun())
      return false;
  }
  BitModel rest(models.known_share[past]);
  for (std::size_t i = 0; i < count % 8; ++i, ++from) {
    unsigned int bit = Coder::is_decoder ? 0 : isOccupied(*from);
    bit = coder.code(rest, bit);
    put(*from, bit);
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
  coder_now = coder;
  return !coder.isOverrun();
}

template bool
FastOccupancy::codeKnownVoxels(
    NibbleEncoder&, FastModels&, const FastHistory&, FastHistory&, FastFrame&);
template bool
FastOccupancy::codeKnownVoxels(
    NibbleDecoder&, FastModels&, const FastHistory&, FastHistory&, FastFrame&);

} // namespace io
} // namespace pcl_ext
