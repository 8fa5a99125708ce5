// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/outlier_removal_remarks.h"

#include "bytes/exact_text.h"

#include <string>

namespace pcl_ext::PCL_EXT_ABI {

OutlierRemovalStatus
unsupportedResolution(double resolution)
{
  return {OutlierRemovalCode::UnsupportedResolution,
          "no voxel was judged: the voxel edge is " + exactText(resolution) +
              " m; it must be " + exactText(VoxelOutlierRemoval::min_resolution) +
              " to " + exactText(VoxelOutlierRemoval::max_resolution)};
}

OutlierRemovalStatus
noDensities(DensityUnit unit)
{
  return {OutlierRemovalCode::NoDensities,
          "no voxel was judged: the frame has no intensities, and unit is " +
              std::string(unit == DensityUnit::Faces ? "faces" : "points") +
              "; choose voxels or, for a lidar, rays, which need none"};
}

OutlierRemovalStatus
judgement(const io::VoxelFrame& frame, DensityUnit set, DensityUnit used)
{
  if (set != DensityUnit::Automatic || used != DensityUnit::Voxels)
    return {};
  if (!frame.hasIntensities() && frame.has_point_counts)
    return {OutlierRemovalCode::Ok,
            "voxels were judged without the number of their points; choose the unit "
            "points for those of a depth camera, rays for those of a lidar, else "
            "voxels"};
  if (!frame.hasIntensities())
    return {
        OutlierRemovalCode::Ok,
        "voxels were judged without the number of their points, as the frame has no "
        "intensities; encode with the law count or quadratic, or choose the unit "
        "rays for a lidar, else voxels"};
  return {
      OutlierRemovalCode::Ok,
      "voxels were judged without their intensities, as the frame does not say what "
      "they are; choose the unit points for counts of a depth camera, rays for a "
      "lidar, else voxels"};
}

OutlierRemovalStatus
withWarning(const OutlierRemovalStatus& status, const io::CompressionStatus& other)
{
  const std::string separator =
      status.message().empty() || other.message().empty() ? "" : "; ";
  OutlierRemovalStatus both(
      status.code(),
      SettingText{status.text().marked + separator + other.text().marked});
  both.removed = status.removed;
  return both;
}

} // namespace pcl_ext::PCL_EXT_ABI
