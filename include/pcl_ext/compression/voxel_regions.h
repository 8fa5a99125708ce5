#pragma once

#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

constexpr std::size_t most_regions = 64;
/** \brief A coarse voxel of a region has 2^5 voxels along each axis at most. */
constexpr unsigned int most_region_levels = 5;
/** \brief Farthest position of a region's corner and of the sensor on the lattice, and
 * the largest distance, voxels. */
constexpr std::int32_t farthest_region = 1 << 22;
/** \brief Unit of the elements of a sensor's rotation. */
constexpr std::int32_t whole_rotation = 1 << 14;

/** \brief A box in which voxels have an edge of their own; integers only, so that all
 * machines find the same voxels in it. */
struct RegionBox {
  /** \brief Corners, voxels from the lattice's origin, or from the sensor along its
   * axes; the upper ends are excluded. */
  std::array<std::int32_t, 3> min{};
  std::array<std::int32_t, 3> max{};
  unsigned int levels = 0; ///< 2^levels voxels along each axis are one, 0..5
  bool is_in_sensor_frame = false;

  bool
  operator==(const RegionBox& other) const
  {
    return min == other.min && max == other.max && levels == other.levels &&
           is_in_sensor_frame == other.is_in_sensor_frame;
  }
};

/** \brief Pose of the sensor, for regions that depend on it. */
struct RegionPose {
  std::array<std::int32_t, 3> position{}; ///< lattice index of the sensor's voxel
  /** \brief Axes of the sensor in the world: element [row][column] of the rotation
   * sensor -> world, units of 2^-14; all 0 unless a box is in the sensor's frame. */
  std::array<std::array<std::int32_t, 3>, 3> rotation{};

  bool
  operator==(const RegionPose& other) const
  {
    return position == other.position && rotation == other.rotation;
  }

  bool
  operator!=(const RegionPose& other) const
  {
    return !(*this == other);
  }
};

/** \brief Where voxels of a frame are coarse, that is cubes of 2^levels voxels along each
 * axis at multiples of that on the lattice. */
struct VoxelRegions {
  std::vector<RegionBox> boxes;     ///< the first that contains a voxel's centre counts
  unsigned int levels_outside = 0;  ///< of all boxes, 0..5; by distance the most
  bool leaves_out_outside = false;  ///< there are no voxels outside of all boxes
  std::uint32_t coarser_beyond = 0; ///< distance from the sensor, voxels; 0: off
  RegionPose pose;                  ///< default unless dependsOnPose()

  /** \brief Most levels of a coarse voxel. The grid begins at a multiple of 2^levels,
   * and has at least as many levels. */
  PCL_EXT_CODEC_EXPORT unsigned int
  mostLevels() const;

  PCL_EXT_CODEC_EXPORT bool
  hasSensorBoxes() const;

  bool
  dependsOnPose() const
  {
    return coarser_beyond > 0 || hasSensorBoxes();
  }

  /** \brief Whether two are the same but for the pose. */
  bool
  isSameButForPose(const VoxelRegions& other) const
  {
    return boxes == other.boxes && levels_outside == other.levels_outside &&
           leaves_out_outside == other.leaves_out_outside &&
           coarser_beyond == other.coarser_beyond;
  }

  bool
  operator==(const VoxelRegions& other) const
  {
    return isSameButForPose(other) && pose == other.pose;
  }
};

/** \brief True if all numbers are within their ranges and there is any region. */
PCL_EXT_CODEC_EXPORT bool
isConsistent(const VoxelRegions& regions);

} // namespace io
} // namespace pcl_ext
