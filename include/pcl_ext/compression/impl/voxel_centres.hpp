// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace detail {

/** \brief Some voxels of a frame as points. */
struct VoxelCentres {
  static constexpr std::size_t capacity = 64;

  std::array<float, capacity> x; ///< of the voxels' centres, metres
  std::array<float, capacity> y;
  std::array<float, capacity> z;
  std::array<float, capacity> intensity; ///< in the unit of the frame's scale
};

/** \brief Positions of a grid of three levels, by Morton key: x from bit 0, y from bit
 * 9, z from bit 18 on. */
constexpr std::array<std::uint32_t, 512>
makePositionsOfKeys()
{
  std::array<std::uint32_t, 512> positions{};
  for (std::uint32_t key = 0; key < 512; ++key) {
    const std::uint32_t bits = axis_bits[key];
    positions[key] = (bits & 7) | (bits & 070) << 6 | (bits & 0700) << 12;
  }
  return positions;
}

inline constexpr auto positions_of_keys = makePositionsOfKeys();

/** \brief Coordinates of the voxels' centres along each axis, metres, by their position
 * in a grid of up to nine levels. */
struct VoxelCentreTables {
  static constexpr std::size_t size = 512;

  std::array<float, size> x;
  std::array<float, size> y;
  std::array<float, size> z;
};

/** \brief Computes the voxels of a frame as points, many at a time. */
class PCL_EXT_CODEC_EXPORT VoxelCentreReader {
public:
  /** \param[in] frame as isConsistent() demands; must not change while it is read */
  explicit VoxelCentreReader(const VoxelFrame& frame);
  VoxelCentreReader(const VoxelCentreReader&) = delete;
  VoxelCentreReader&
  operator=(const VoxelCentreReader&) = delete;

  /** \brief Computes up to VoxelCentres::capacity voxels.
   * \param[in] begin the first voxel, at most frame.size()
   * \param[out] centres the voxels from there
   * \return their number
   */
  std::size_t
  read(std::size_t begin, VoxelCentres& centres) const;

  /** \brief True if tables save time: the grid is small and the frame is not. */
  bool
  hasTables() const
  {
    return has_tables_;
  }

  /** \brief Looks all voxels up in the tables, which there must be. */
  template <typename VisitT>
  void
  visitByTables(VisitT&& visit) const
  {
    constexpr unsigned int field = VoxelCentreTables::size - 1;
    const std::uint64_t* const keys = frame_.keys.data();
    const std::uint16_t* const symbols = frame_.intensities.data();
    const float* const intensities = table_;
    const std::size_t count = frame_.size();
    for (std::size_t i = 0; i < count; ++i) {
      const auto key = static_cast<std::uint32_t>(keys[i]);
      const std::uint32_t position = positions_of_keys[key & field] |
                                     positions_of_keys[key >> 9 & field] << 3 |
                                     positions_of_keys[key >> 18 & field] << 6;
      visit(tables_.x[position & field],
            tables_.y[position >> 9 & field],
            tables_.z[position >> 18],
            intensities[symbols[i]]);
    }
  }

private:
  void
  setIntensityTable();

  void
  setCentreTables();

  const VoxelFrame& frame_;
  bool has_tables_ = false;
  const float* table_ = nullptr;       // intensities by symbol, if it saves time
  std::array<float, 256> small_table_; // up to 8 bits, without an allocation
  std::vector<float> large_table_;
  VoxelCentreTables tables_; // set if has_tables_
};

} // namespace detail

template <typename VisitT>
void
forEachVoxelCentre(const VoxelFrame& frame, VisitT&& visit)
{
  const detail::VoxelCentreReader reader(frame);
  if (reader.hasTables()) {
    reader.visitByTables(visit);
    return;
  }
  detail::VoxelCentres centres;
  for (std::size_t begin = 0; begin < frame.size();) {
    const std::size_t count = reader.read(begin, centres);
    for (std::size_t i = 0; i < count; ++i)
      visit(centres.x[i], centres.y[i], centres.z[i], centres.intensity[i]);
    begin += count;
  }
}

template <typename VisitT>
void
forEachPreciseCentre(const VoxelFrame& frame, VisitT&& visit)
{
  if (!frame.grid.needsDoubles()) {
    forEachVoxelCentre(frame, visit);
    return;
  }
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame.keys[i]);
    visit(frame.grid.centre(0, position.x),
          frame.grid.centre(1, position.y),
          frame.grid.centre(2, position.z),
          frame.hasIntensities() ? frame.intensity_scale.value(frame.intensities[i])
                                 : 0.0f);
  }
}

namespace detail {

/** \brief Colours in channels of 0 to 255, faster than VoxelFrame::fullColour(). */
class FullColours {
public:
  /** \param[in] frame that has the colours
   * \param[in] colours of the frame's voxels or points; must not change meanwhile
   */
  FullColours(const VoxelFrame& frame, const std::vector<VoxelColour>& colours)
  : colours_(frame.colour_bits > 0 ? colours.data() : nullptr)
  {
    if (colours_ == nullptr)
      return;
    for (unsigned int channel = 0; channel >> frame.colour_bits == 0; ++channel) {
      const auto given = static_cast<std::uint8_t>(channel);
      channels_[channel] = frame.fullColour(VoxelColour{given, given, given}).r;
    }
  }

  /** \brief White without colours. */
  VoxelColour
  operator[](std::size_t index) const
  {
    if (colours_ == nullptr)
      return {255, 255, 255};
    const VoxelColour& colour = colours_[index];
    return {channels_[colour.r], channels_[colour.g], channels_[colour.b]};
  }

private:
  const VoxelColour* colours_; // null without colours
  std::array<std::uint8_t, 256> channels_{};
};

/** \brief forEachPoint() of a frame that has its points, as numbers of a type. */
template <typename NumberT, typename VisitT>
void
visitOwnPoints(const VoxelFrame& frame, VisitT& visit)
{
  const FramePoints& points = frame.points;
  const FullColours colours(frame, points.colours);
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const std::array<double, 3>& position = points.positions[i];
    visit(i,
          static_cast<NumberT>(position[0]),
          static_cast<NumberT>(position[1]),
          static_cast<NumberT>(position[2]),
          frame.hasIntensities() ? frame.intensity_scale.value(points.intensities[i])
                                 : 0.0f,
          colours[i]);
  }
}

/** \brief forEachPoint() of a frame that has voxels only. */
template <typename VisitT>
void
visitVoxelPoints(const VoxelFrame& frame, VisitT& visit)
{
  const FullColours colours(frame, frame.colours);
  std::size_t voxel = 0;
  if (!frame.has_point_counts) {
    forEachPreciseCentre(frame, [&](auto x, auto y, auto z, float intensity) {
      visit(voxel, x, y, z, intensity, colours[voxel]);
      ++voxel;
    });
    return;
  }
  std::size_t point = 0;
  forEachPreciseCentre(frame, [&](auto x, auto y, auto z, float intensity) {
    const VoxelColour colour = colours[voxel];
    for (const std::size_t end = point + frame.point_counts[voxel]; point < end;
         ++point)
      visit(point, x, y, z, intensity, colour);
    ++voxel;
  });
}

} // namespace detail

template <typename VisitT>
void
forEachPoint(const VoxelFrame& frame, VisitT&& visit)
{
  if (!frame.points.areThere())
    detail::visitVoxelPoints(frame, visit);
  else if (frame.needsDoubles())
    detail::visitOwnPoints<double>(frame, visit);
  else
    detail::visitOwnPoints<float>(frame, visit);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
