// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "measuring/workload.h"

#include <pcl/compression/compression_profiles.h>

#include <array>
#include <iosfwd>
#include <memory>

namespace pcl_ext {
namespace measuring {

/** \brief Name of PCL's class in voxel-grid mode, in tables. */
constexpr const char* pcl_voxel_grid_name = "PCL, voxel grid";

/** \brief Settings of PCL's class. */
struct PclCompressionSettings {
  double octree_resolution = 0.01; ///< metres
  double point_resolution = 0.001; ///< metres
  bool keeps_voxels_only = true;
  unsigned int i_frame_rate =
      30; ///< frames from one I-frame to the next; PCL's own is one less
};

/** \brief pcl::io::OctreePointCloudCompression, behind a header of its own, as PCL's
 * headers with its implementation may be included in one source file only.
 * \tparam PointT pcl::PointXYZ or pcl::PointXYZRGB
 */
template <typename PointT>
class PclCompression {
public:
  using Cloud = pcl::PointCloud<PointT>;

  /** \brief With settings of one's own, without colours. */
  explicit PclCompression(const PclCompressionSettings& settings);

  explicit PclCompression(pcl::io::compression_Profiles_e profile);

  ~PclCompression();

  void
  encode(const typename Cloud::ConstPtr& cloud, std::ostream& bytes);

  /** \warning Never returns if the stream has no frame. */
  void
  decode(std::istream& bytes, typename Cloud::Ptr& cloud);

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

extern template class PclCompression<pcl::PointXYZ>;
extern template class PclCompression<pcl::PointXYZRGB>;

} // namespace measuring
} // namespace pcl_ext
