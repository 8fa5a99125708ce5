#pragma once

#include "measuring/workload.h"

#include <array>
#include <iosfwd>
#include <memory>

namespace pcl_ext {
namespace measuring {

/** \brief How PCL's class is set. */
struct PclCompressionSettings {
  double octree_resolution = 0.01; ///< metres
  double point_resolution = 0.001; ///< metres
  bool keeps_voxels_only = true;
  unsigned int i_frame_rate = 30; ///< every so many frames; PCL's own counts one less
};

/** \brief pcl::io::OctreePointCloudCompression<pcl::PointXYZ>, seen through a header of
 * its own: PCL's may be included with its implementation in one source file only. */
class PclCompression {
public:
  explicit PclCompression(const PclCompressionSettings& settings);
  ~PclCompression();

  void
  encode(const PositionCloud::ConstPtr& cloud, std::ostream& bytes);

  /** \warning Never returns if the stream has no frame. */
  void
  decode(std::istream& bytes, PositionCloud::Ptr& cloud);

  /** \brief Lower corner of the octree's box, metres. */
  std::array<double, 3>
  lowerCorner() const;

  /** \brief Voxel edge, metres. */
  double
  resolution() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace measuring
} // namespace pcl_ext
