#include "codec/fast/history.h"

#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

/** \brief Room for so many elements, and for more to come. */
template <class Vector>
void
reserve(Vector& vector, std::size_t size)
{
  if (vector.capacity() < size)
    vector.reserve(size + size / 4);
}

} // namespace

std::uint32_t
voxel_past::firstProbability(unsigned int past)
{
  unsigned int frames = 0;
  while (past >> (frames + 1) != 0)
    ++frames;
  std::int32_t probability = 26000;
  for (unsigned int i = 0; i < frames; ++i) {
    const std::int32_t goal = (past >> (frames - 1 - i) & 1) != 0 ? 0xffff : 0;
    const unsigned int shift = i < 2 ? 1 : i < 5 ? 2 : 3;
    probability += (goal - probability) >> shift;
  }
  return static_cast<std::uint32_t>(probability);
}

void
History::makeRoomFor(const History& other)
{
  reserve(known, other.known.size());
  reserve(spare_numbers, other.spare_numbers.size());
  reserve(keys, other.keys.size());
  reserve(numbers, other.numbers.size());
  reserve(activity, other.activity.size());
  ensureSize(places, other.voxelCount());
}

void
History::learn(History& other, bool with_moments) noexcept
{
  known = other.known;
  spare_numbers = other.spare_numbers;
  keys = other.keys;
  numbers = other.numbers;
  activity = other.activity;
  size = other.size;
  VoxelPlace* place = places.data();
  for (std::size_t past = 0; past < voxel_past::count; ++past) {
    first[past] = static_cast<std::uint32_t>(place - places.data());
    place = std::copy_n(other.places.data() + other.first[past], size[past], place);
  }
  if (with_moments)
    moments.swap(other.moments);
}

void
History::clear() noexcept
{
  known.clear();
  spare_numbers.clear();
  keys.clear();
  numbers.clear();
  activity.clear();
  first.fill(0);
  size.fill(0);
}

void
History::giveBackMemory()
{
  places.resize(voxelCount());
  moments.resize(known.size() * block_cells);
  known.shrink_to_fit();
  moments.shrink_to_fit();
  spare_numbers.shrink_to_fit();
  keys.shrink_to_fit();
  numbers.shrink_to_fit();
  activity.shrink_to_fit();
  places.shrink_to_fit();
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
