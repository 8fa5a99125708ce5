#pragma once

#include <pcl_ext/compression/companded_levels.h>
#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/morton_key.h>
#include <pcl_ext/export.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Resolutions that a grid can have, metres: its coordinates are floats. */
constexpr double smallest_resolution = 1e-6;
constexpr double largest_resolution = 1e6;

/** \brief The cubic part of space in which a frame's voxels lie.
 *
 * Voxels have a lattice index (i, j, k); the voxel covers [i d_v, (i+1) d_v) x ... from
 * the anchor. The grid holds the 2^depth voxels an axis from `first_index` on. For this
 * library's own streams the anchor is the world origin, so that voxels coincide with
 * the map's; the published layout anchors its lattice where PCL's octree box falls.
 */
struct VoxelGrid {
  double resolution = 0.0;                   ///< voxel edge d_v, metres
  std::array<double, 3> anchor{};            ///< world position of lattice 0, metres
  std::array<std::int32_t, 3> first_index{}; ///< lattice index of the lowest voxel
  unsigned int depth = 1;                    ///< levels, 1..max_grid_depth

  /** \brief Voxels along each axis: 2^depth. */
  std::int64_t
  size() const
  {
    return std::int64_t{1} << depth;
  }

  /** \brief World coordinate, in metres, of the centre of a voxel along one axis.
   * \param[in] axis 0, 1, 2 for x, y, z
   * \param[in] position voxels from the grid's lower corner
   */
  double
  centre(std::size_t axis, std::uint32_t position) const
  {
    return (static_cast<double>(first_index[axis]) + static_cast<double>(position) +
            0.5) *
               resolution +
           anchor[axis];
  }

  /** \brief World coordinate, in metres, of the lower corner of the grid on one axis.
   */
  double
  lowerCorner(std::size_t axis) const
  {
    return static_cast<double>(first_index[axis]) * resolution + anchor[axis];
  }

  bool
  operator==(const VoxelGrid& other) const
  {
    return resolution == other.resolution && anchor == other.anchor &&
           first_index == other.first_index && depth == other.depth;
  }

  bool
  operator!=(const VoxelGrid& other) const
  {
    return !(*this == other);
  }
};

/** \brief How a voxel intensity becomes a symbol of 1 to 16 bits and back: intensity =
 * offset + number * step.
 *
 * On a linear scale the symbol is the number. On a companded one it is the level that the
 * number lies in, and stands for the middle number of the level; see compandedEdge.
 */
struct IntensityScale {
  float offset = 0.0f;   ///< intensity of number 0
  float step = 1.0f;     ///< intensity from one number to the next, above 0
  unsigned int bits = 8; ///< symbols are below 2^bits; 1..16

  /** \brief The highest number of a companded scale, 2^bits..65535; 0: a linear scale. */
  std::uint32_t companded_range = 0;

  /** \brief The highest symbol. */
  std::uint32_t
  maxSymbol() const
  {
    return (std::uint32_t{1} << bits) - 1;
  }

  /** \brief The highest number. */
  std::uint32_t
  maxNumber() const
  {
    return companded_range != 0 ? companded_range : maxSymbol();
  }

  /** \brief Intensity that a symbol stands for; SymbolIntensities is faster for many
   * symbols of a companded scale. */
  float
  value(std::uint16_t symbol) const
  {
    const std::uint32_t number =
        companded_range != 0 ? compandedMiddle(bits, companded_range, symbol) : symbol;
    // Held within float, which the top of a scale may leave by rounding.
    constexpr double largest = std::numeric_limits<float>::max();
    const double intensity = static_cast<double>(offset) +
                             static_cast<double>(number) * static_cast<double>(step);
    return static_cast<float>(std::clamp(intensity, -largest, largest));
  }

  bool
  operator==(const IntensityScale& other) const
  {
    return offset == other.offset && step == other.step && bits == other.bits &&
           companded_range == other.companded_range;
  }

  bool
  operator!=(const IntensityScale& other) const
  {
    return !(*this == other);
  }
};

/** \brief One frame of a stream as everything in this library sees it: the occupied
 * voxels of a grid and an intensity for each. */
struct VoxelFrame {
  VoxelGrid grid;
  IntensityScale intensity_scale;
  std::optional<DepthModel> depth_model;  ///< where intensities depend on depth
  std::vector<std::uint64_t> keys;        ///< Morton keys, strictly ascending
  std::vector<std::uint16_t> intensities; ///< a symbol of intensity_scale for each key

  /** \brief Number of occupied voxels. */
  std::size_t
  size() const
  {
    return keys.size();
  }
};

/** \brief True if the frame keeps the promises of its members: as many intensities as
 * keys, keys strictly ascending and within the grid, symbols within the scale, finite
 * numbers. Encoders refuse a frame that does not. */
PCL_EXT_EXPORT bool
isConsistent(const VoxelFrame& frame);

} // namespace io
} // namespace pcl_ext
