#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext {

/** \brief Removes the noise of a cloud that was decoded: VoxelOutlierRemoval::filter() for
 * users of io::OctreePointCloudIntensityCompression.
 *
 * It is the frame that is judged, as a cloud of voxel centres tells neither the grid nor
 * the law that its intensities follow. Call it once for each frame that was decoded, in
 * their order:
 * \code
 * if (decoder.decodePointCloud(stream, cloud).ok())
 *   pcl_ext::removeOutliers(*cloud, decoder.getVoxelFrame(), removal);
 * \endcode
 * \param[in,out] cloud as decodePointCloud() filled it, point i being voxel i of the frame;
 * may have been moved since, and further fields be set. The points that stay keep their
 * order; if any goes, the cloud is one row, else it is untouched
 * \param[in] frame that the cloud was decoded from, as getVoxelFrame() returns it after
 * decodePointCloud()
 * \param[in,out] removal the filter of this stream alone
 * \return number of points removed; nothing if there are not as many points as voxels:
 * then the cloud is untouched, and the filter has not seen the frame
 */
template <typename PointT>
std::optional<std::size_t>
removeOutliers(pcl::PointCloud<PointT>& cloud,
               const io::VoxelFrame& frame,
               VoxelOutlierRemoval& removal)
{
  if (cloud.size() != frame.size())
    return std::nullopt;
  io::VoxelFrame kept = frame;
  const std::size_t removed = removal.filter(kept);
  if (removed == 0)
    return removed;
  std::size_t next = 0; // of the voxels that stay, which are in the frame's order
  for (std::size_t i = 0; i < frame.size() && next < kept.size(); ++i)
    if (frame.keys[i] == kept.keys[next])
      cloud.points[next++] = cloud.points[i];
  cloud.resize(next);
  cloud.width = static_cast<std::uint32_t>(next);
  cloud.height = 1;
  return removed;
}

} // namespace pcl_ext
