// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/colour_mean.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <pcl/octree/octree_container.h>
#include <pcl/types.h>

#include <optional>

namespace pcl_ext::PCL_EXT_ABI::octree {

/** \addtogroup octree
 * @{ */

/** \brief Octree leaf that accumulates the points in its voxel: their number, the sum
 * of their intensities and the mean of their colours.
 *
 * Fulfils PCL's leaf contract (reset, equality, copy), so that it serves in
 * pcl::octree::OctreeBase and pcl::octree::Octree2BufBase.
 */
class PCL_EXT_EXPORT IntensityLeaf : public pcl::octree::OctreeContainerBase {
public:
  IntensityLeaf() = default;
  ~IntensityLeaf() override = default;
  IntensityLeaf(const IntensityLeaf&) = default;
  IntensityLeaf&
  operator=(const IntensityLeaf&) = default;

  /** \brief A copy on the heap, owned by the caller. */
  virtual IntensityLeaf*
  deepCopy() const
  {
    return new IntensityLeaf(*this);
  }

  /** \brief True if the other leaf is an IntensityLeaf with the same sums and counts.
   */
  bool
  operator==(const pcl::octree::OctreeContainerBase& other) const override
  {
    const auto* leaf = dynamic_cast<const IntensityLeaf*>(&other);
    return leaf != nullptr && leaf->count_ == count_ && leaf->sum_ == sum_ &&
           leaf->colour_ == colour_;
  }

  /** \brief Counts a point without an intensity (PCL's interface to add a point).
   *
   * The sum does not change. OctreePointCloudIntensity adds points with
   * addPointIntensity instead.
   */
  void
  addPointIndex(pcl::index_t) override
  {
    ++count_;
  }

  /** \brief Counts a point and adds its intensity.
   * \param[in] intensity point intensity I_p, in the unit of its intensity model
   */
  void
  addPointIntensity(float intensity)
  {
    ++count_;
    sum_ += static_cast<double>(intensity);
  }

  /** \brief Adds the colour of a point that is counted by one of the above.
   * \param[in] colour channels of 0 to 255
   */
  void
  addPointColour(const io::VoxelColour& colour)
  {
    colour_.add(colour);
  }

  /** \brief Number of points in the voxel. */
  pcl::uindex_t
  getPointCounter() const
  {
    return count_;
  }

  /** \brief Voxel intensity I_v: the sum of the points' intensities (section 2.5.4 of
   * the paper), in their unit. */
  float
  getIntensity() const
  {
    return static_cast<float>(sum_);
  }

  /** \brief Mean of the points' intensities, in their unit; 0 if the voxel is empty. */
  float
  getMeanIntensity() const
  {
    return count_ == 0 ? 0.0f : static_cast<float>(sum_ / static_cast<double>(count_));
  }

  /** \brief Mean of the points' colours, in channels of 0 to 255, rounded; nothing if
   * none was added. */
  std::optional<io::VoxelColour>
  getColour() const
  {
    return colour_.mean();
  }

  /** \brief Number of points in the voxel (PCL's name for it). */
  pcl::uindex_t
  getSize() const override
  {
    return count_;
  }

  /** \brief Empties the leaf. */
  void
  reset() override
  {
    *this = IntensityLeaf();
  }

private:
  pcl::uindex_t count_ = 0;
  // Double: the order of the points then changes at most the last bit of the float that
  // is returned.
  double sum_ = 0.0;
  io::detail::ColourMean colour_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::octree
