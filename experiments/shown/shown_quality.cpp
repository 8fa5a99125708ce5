// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "shown_quality.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace shown {

namespace {

constexpr int noise_frames = 10;
constexpr std::size_t least_person_voxels = 20;

/** \brief Calls a function for all voxels of a box. */
template <typename VisitT>
void
forEach(const CellVoxels::Index& first, int edge, const VisitT& visit)
{
  for (int x = first[0]; x < first[0] + edge; ++x)
    for (int y = first[1]; y < first[1] + edge; ++y)
      for (int z = first[2]; z < first[2] + edge; ++z)
        visit(CellVoxels::Index{x, y, z});
}

} // namespace

CellVoxels::CellVoxels(double edge) : edge_(edge)
{
  count_ = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    first_[at] = static_cast<int>(std::floor(cell::RobotCell::cropMin()[axis] / edge));
    size_[at] = static_cast<int>(std::floor(cell::RobotCell::cropMax()[axis] / edge)) +
                1 - first_[at];
    count_ *= static_cast<std::size_t>(size_[at]);
  }
}

std::size_t
CellVoxels::numberOf(const Index& index) const
{
  std::size_t number = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int from_first = index[axis] - first_[axis];
    if (from_first < 0 || from_first >= size_[axis])
      return count_;
    number = number * static_cast<std::size_t>(size_[axis]) +
             static_cast<std::size_t>(from_first);
  }
  return number;
}

void
QualityJudge::addVoxels(const std::vector<SurfacePoint>& points, bool of_person)
{
  for (const SurfacePoint& point : points) {
    if (point.is_person != of_person)
      continue;
    CellVoxels::Index index;
    for (int axis = 0; axis < 3; ++axis)
      index[static_cast<std::size_t>(axis)] =
          static_cast<int>(std::floor(point.position[axis] / voxels_.edge()));
    const std::size_t number = voxels_.numberOf(index);
    if (number + 1 == voxels_.count() || last_frames_[number] == frame_)
      continue;
    last_frames_[number] = frame_;
    surfaces_.push_back(index);
  }
}

void
QualityJudge::add(const std::vector<SurfacePoint>& points)
{
  ++frame_;
  surfaces_.clear();
  addVoxels(points, false);
  others_ = surfaces_.size();
  addVoxels(points, true);
}

bool
QualityJudge::isNoise(const CellVoxels::Index& first, int edge) const
{
  bool is_near = false;
  const CellVoxels::Index around{first[0] - 1, first[1] - 1, first[2] - 1};
  forEach(around, edge + 2, [&](const CellVoxels::Index& index) {
    is_near |= last_frames_[voxels_.numberOf(index)] > frame_ - noise_frames;
  });
  return !is_near;
}

ShownQuality
QualityJudge::judge(const io::VoxelFrame& shown)
{
  ShownQuality quality;
  const int edge =
      static_cast<int>(std::lround(shown.grid.resolution / voxels_.edge()));
  std::size_t noise = 0;
  for (const std::uint64_t key : shown.keys) {
    const io::VoxelPosition position = io::voxelPosition(key);
    const std::array<std::uint32_t, 3> at{position.x, position.y, position.z};
    CellVoxels::Index first;
    for (std::size_t axis = 0; axis < 3; ++axis)
      first[axis] = static_cast<int>(shown.grid.first_index[axis] +
                                     static_cast<std::int64_t>(at[axis])) *
                    edge;
    noise += isNoise(first, edge) ? 1 : 0;
    // What is within one edge of its centre.
    const int begin = edge == 1 ? -1 : edge / 2 - 1;
    forEach({first[0] + begin, first[1] + begin, first[2] + begin},
            edge == 1 ? 3 : 2,
            [&](const CellVoxels::Index& index) {
              const std::size_t number = voxels_.numberOf(index);
              if (is_shown_[number] == 0)
                marked_.push_back(number);
              is_shown_[number] = 1;
            });
  }
  is_shown_.back() = 0;
  std::size_t found = 0;
  std::size_t found_of_person = 0;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const std::size_t is_found = is_shown_[voxels_.numberOf(surfaces_[i])];
    found += is_found;
    found_of_person += i >= others_ ? is_found : 0;
  }
  for (const std::size_t number : marked_)
    is_shown_[number] = 0;
  marked_.clear();
  const auto percent = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 0.0
                      : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
  };
  quality.surface_percent = percent(found, surfaces_.size());
  quality.noise_percent = percent(noise, shown.keys.size());
  if (const std::size_t person = surfaces_.size() - others_;
      person >= least_person_voxels)
    quality.person_percent = percent(found_of_person, person);
  return quality;
}

} // namespace shown
} // namespace pcl_ext
