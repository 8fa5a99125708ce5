#pragma once

#include <pcl_ext/compression/bounding_box.h>
#include <pcl_ext/named_value.h>

#include <array>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief What the corners of a region refer to. */
enum class RegionFrame {
  World, ///< the coordinate frame that clouds are voxelized in
  Sensor ///< the sensor, at its pose
};

inline constexpr std::array<NamedValue<RegionFrame>, 2> region_frames = {
    {{RegionFrame::World, "world"}, {RegionFrame::Sensor, "sensor"}}};

/** \brief What becomes of points outside of all regions. */
enum class OutsideRegions {
  Coarsest, ///< they are in voxels of the coarsest region
  LeftOut   ///< they are counted and left out
};

inline constexpr std::array<NamedValue<OutsideRegions>, 2> outsides_of_regions = {
    {{OutsideRegions::Coarsest, "coarsest"}, {OutsideRegions::LeftOut, "left-out"}}};

/** \brief A box with an edge of its own. */
struct Region {
  /** \brief min < max on each axis, and at least the resolution apart. Its faces are
   * those of the nearest voxels, of a box in the sensor's frame nearly so. */
  BoundingBox box;

  /** \brief The edge is the resolution times 2^doublings, 0 to 5. */
  unsigned int doublings = 0;

  RegionFrame frame = RegionFrame::World;
};

/** \brief Where voxels have a larger edge than the resolution.
 *
 * A coarse voxel is a cube of 2^doublings voxels along each axis, at a multiple of it
 * on the lattice. It is in the region that its centre is in; what is in none of the
 * larger ones is in smaller ones. Its intensity and colour are those of all of its
 * points; shares of a voxel face are those of its own face. Version1 only, and not with
 * keep_point_counts or fields.
 */
struct RegionSettings {
  /** \brief At most 64. The first one that contains the centre of a voxel counts. */
  std::vector<Region> boxes;

  /** \brief Distance from the sensor, metres, from which on voxels outside of all boxes
   * have twice the edge, and twice of that from each doubling of the distance on; 0:
   * off. From the resolution to 2^22 times it. */
  double coarser_beyond = 0.0;

  /** \brief Most doublings by the distance, 1 to 5. */
  unsigned int most_doublings = 3;

  /** \brief Where there are boxes, and the distance is off. */
  OutsideRegions outside = OutsideRegions::Coarsest;

  /** \brief Whether there is any region. */
  bool
  areAny() const
  {
    return !boxes.empty() || coarser_beyond != 0.0;
  }
};

} // namespace io
} // namespace pcl_ext
