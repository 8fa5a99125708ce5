#include "codec/supplement/fields.h"

#include "codec/fast/entropy_coder.h"
#include "codec/supplement/field_pass.h"
#include "voxels/ascending_keys.h"
#include "voxels/lower_neighbours.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace supplement {

/** \brief Finds the neighbours, the direction, the past and the points of each voxel. */
void
FieldCoder::findPlaces(const std::array<std::int32_t, 3>& viewpoint,
                       const VoxelFrame& frame)
{
  FieldPlaces& places = places_;
  places.blocks.assign(frame.keys);
  LowerNeighbours neighbours(
      places.blocks, levelsAboveBlocks(frame.grid.depth), places.directory);
  neighbours.begin();
  places.lower.resize(frame.size());
  places.directions.resize(frame.size());
  places.before.resize(frame.size());
  places.first_points.resize(frame.size() + 1);
  AscendingLookup<std::uint64_t> past(last_keys_);
  std::uint32_t voxel = 0;
  std::uint32_t point = 0;
  for (std::size_t block = 0; block < places.blocks.size(); ++block) {
    neighbours.moveTo(block);
    for (std::uint64_t cells = places.blocks.masks[block]; cells != 0;
         cells &= cells - 1, ++voxel) {
      std::size_t side = 0;
      neighbours.visitEachSide(
          lowestBit(cells), [&](std::size_t other, std::uint32_t is_there) {
            places.lower[voxel][side++] =
                is_there != 0 ? static_cast<std::uint32_t>(other) : voxel;
          });
      const VoxelPosition position = voxelPosition(frame.keys[voxel]);
      places.directions[voxel] = directionOf(std::int64_t{position.x} - viewpoint[0],
                                             std::int64_t{position.y} - viewpoint[1],
                                             std::int64_t{position.z} - viewpoint[2]);
      const std::size_t record = past.find(frame.keys[voxel]);
      places.before[voxel] =
          record == not_in_list ? 0 : static_cast<std::uint32_t>(record + 1);
      places.first_points[voxel] = point;
      point += frame.has_point_counts ? frame.point_counts[voxel] : 1;
    }
  }
  places.first_points[voxel] = point;
}

template <class CodingT, class FrameT>
bool
FieldCoder::code(CodingT& coding,
                 bool is_i_frame,
                 const std::array<std::int32_t, 3>& viewpoint,
                 FrameT& frame)
{
  findPlaces(viewpoint, frame);
  if (is_i_frame) {
    next_states_.clear();
    std::fill(places_.before.begin(), places_.before.end(), 0u);
  }
  else
    next_states_ = states_;
  // There are none yet in an I-frame, and after one without voxels.
  next_states_.resize(frame.fields.size());
  next_keys_.assign(frame.keys.begin(), frame.keys.end());
  for (std::size_t i = 0; i < frame.fields.size(); ++i) {
    auto& field = frame.fields[i];
    if constexpr (CodingT::is_decoder)
      field.numbers.resize(std::size_t{places_.first_points.back()} * field.count);
    FieldPass<CodingT> pass(field, next_states_[i], places_);
    if (!pass.run(coding, indices_, field.numbers))
      return false;
  }
  return true;
}

template bool
FieldCoder::code(NumberCoding<fast::NibbleEncoder>&,
                 bool,
                 const std::array<std::int32_t, 3>&,
                 const VoxelFrame&);
template bool
FieldCoder::code(NumberCoding<fast::NibbleDecoder>&,
                 bool,
                 const std::array<std::int32_t, 3>&,
                 VoxelFrame&);

void
FieldCoder::learn() noexcept
{
  states_.swap(next_states_);
  last_keys_.swap(next_keys_);
}

void
FieldCoder::reset() noexcept
{
  states_.clear();
  last_keys_.clear();
}

void
FieldCoder::releaseMemory()
{
  next_states_ = std::vector<FieldState>();
  next_keys_ = std::vector<std::uint64_t>();
  places_ = FieldPlaces();
  indices_ = std::vector<std::uint64_t>();
}

} // namespace supplement
} // namespace io
} // namespace pcl_ext
