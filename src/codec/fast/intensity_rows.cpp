#include "codec/fast/intensity_rows.h"

#include "codec/fast/symbol_statistics.h"
#include "simd/symbol_lanes.h"
#include "voxels/child_masks.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

namespace {

constexpr std::uint16_t eighth = symbol_statistics::deviation_count;
// Upper bounds of the means of the low classes: 4, 10 and 16 eighths.
constexpr std::array<std::uint16_t, 3> class_ends = {
    4 * eighth, 10 * eighth, 16 * eighth};

/** \brief Appends those of eight voxels that are in a mask; writes eight in any case. */
inline void
appendVoxels(std::uint32_t*& row, std::uint32_t first, unsigned int mask)
{
  storeSums(row, child_masks.children[mask], first);
  row += child_masks.count[mask];
}

} // namespace

void
IntensityRows::sort(const Frame& frame, const StatisticsTable& statistics)
{
  const std::size_t count = frame.voxel_count;
  const VoxelPlace* const places = frame.places.data();
  ensureSize(before, count + 7); // compared eight at a time
  std::uint16_t* const all_before = before.data();
  for (std::size_t i = 0; i < count; ++i)
    all_before[i] = statistics[places[i]];
  const auto begin = [&](Row& row) {
    ensureSize(row.voxels, count + 8);
    row.noted = 0;
    return row.voxels.data();
  };
  const auto end = [](Row& row, const std::uint32_t* last) {
    row.count = static_cast<std::size_t>(last - row.voxels.data());
  };
  std::array<std::uint32_t*, low_class_count> low;
  for (std::size_t i = 0; i < low_class_count; ++i)
    low[i] = begin(quads[i]);
  std::uint32_t* others = begin(known);
  begin(fresh);
  for (std::size_t i = 0; i < count; i += 8) {
    const unsigned int all = count - i < 8 ? (1u << (count - i)) - 1 : 0xff;
    static_assert(History::no_statistics == 0xffff, "compared by compareEight()");
    const EightComparisons masks = compareEight(all_before + i, class_ends);
    const auto first = static_cast<std::uint32_t>(i);
    appendVoxels(low[0], first, masks[0] & all);
    appendVoxels(low[1], first, masks[1] & ~masks[0] & all);
    appendVoxels(low[2], first, masks[2] & ~masks[1] & all);
    appendVoxels(low[without_statistics], first, masks[3] & all);
    appendVoxels(others, first, ~(masks[2] | masks[3]) & all);
  }
  for (std::size_t i = 0; i < low_class_count; ++i) {
    end(quads[i], low[i]);
    // Voxels of an incomplete quad are moved to the row `known`, the last one first.
    for (; i != without_statistics && quads[i].count % 4 != 0; --quads[i].count)
      *others++ = *--low[i];
  }
  end(known, others);
}

void
IntensityRows::splitFresh(bool in_quads)
{
  Row& row = quads[without_statistics];
  const std::size_t kept = in_quads ? row.count / 4 * 4 : 0;
  fresh.count = row.count - kept;
  std::copy_n(row.voxels.begin() + static_cast<std::ptrdiff_t>(kept),
              fresh.count,
              fresh.voxels.begin());
  row.count = kept;
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
