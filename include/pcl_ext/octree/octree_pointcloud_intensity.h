// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/impl/library_instances.h>
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/octree/intensity_leaf.h>

#include <pcl/octree/octree2buf_base.h>
#include <pcl/octree/octree_base.h>
#include <pcl/octree/octree_pointcloud.h>
#include <pcl/point_types.h>

#include <boost/preprocessor/seq/for_each.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

struct PointXYZRGBI;

namespace octree {

/** \addtogroup octree
 * @{ */

namespace detail {

/** \brief True if a leaf has addPointColour(io::VoxelColour). */
template <typename LeafT, typename = void>
struct TakesColours : std::false_type {};

template <typename LeafT>
struct TakesColours<
    LeafT,
    std::void_t<decltype(std::declval<LeafT&>().addPointColour(io::VoxelColour()))>>
: std::true_type {};

/** \brief Point types for which the library has the functions of PCL's octrees. */
template <typename PointT>
inline constexpr bool is_point_of_library = false;

template <>
inline constexpr bool is_point_of_library<PointXYZRGBI> = true;

#define PCL_EXT_POINT_OF_LIBRARY(r, data, PointT)                                      \
  template <>                                                                          \
  inline constexpr bool is_point_of_library<PointT> = true;
BOOST_PP_SEQ_FOR_EACH(PCL_EXT_POINT_OF_LIBRARY, _, PCL_XYZ_POINT_TYPES)
#undef PCL_EXT_POINT_OF_LIBRARY

/** \brief Defined where a program includes the functions of PCL's octrees. */
template <typename PointT>
struct OctreeFunctions;

template <typename PointT, typename = void>
struct HasOctreeFunctions : std::false_type {};

template <typename PointT>
struct HasOctreeFunctions<PointT,
                          std::void_t<decltype(sizeof(OctreeFunctions<PointT>))>>
: std::true_type {};

/** \brief Whether the library has the functions of an octree. */
template <typename PointT, typename LeafT, typename BranchT>
struct IsOctreeOfLibrary
: std::bool_constant<is_point_of_library<PointT> &&
                     std::is_same<LeafT, IntensityLeaf>::value &&
                     std::is_same<BranchT, pcl::octree::OctreeContainerEmpty>::value> {
};

} // namespace detail

/** \brief Octree whose leaves hold the summed intensity, the mean colour and the number
 * of the points in their voxel; the counterpart of
 * pcl::octree::OctreePointCloudDensity.
 *
 * Fill it as any PCL octree: setInputCloud, addPointsFromInputCloud; or with decoded
 * voxels: addVoxels. Points whose type has no field `intensity` count with intensity 1.
 * Without a bounding box the voxels begin at multiples of their edge, as those of the
 * compression do but for clouds whose coordinates are such multiples
 * (EncoderSettings::use_coordinate_step), so that
 * OctreePointCloudIntensityCompression::encodeOctree moves none. Of a point on a face PCL
 * rounds which of the two voxels has it.
 *
 * The library has the functions of PCL's base classes for PCL_XYZ_POINT_TYPES with
 * IntensityLeaf. A program with a point type, leaf or branch of its own includes
 * pcl_ext/octree/impl/octree_pointcloud_intensity.hpp, or defines PCL_NO_PRECOMPILE
 * before it includes PCL, as for PCL's octrees.
 * \tparam PointT point type
 * \tparam LeafT leaf container with `addPointIntensity(float)` and `getIntensity()`;
 * for colours also `addPointColour(io::VoxelColour)` and `getColour()`, see
 * IntensityLeaf
 * \tparam BranchT branch container
 * \tparam OctreeT pcl::octree::OctreeBase or pcl::octree::Octree2BufBase
 */
template <typename PointT,
          typename LeafT = IntensityLeaf,
          typename BranchT = pcl::octree::OctreeContainerEmpty,
          typename OctreeT = pcl::octree::OctreeBase<LeafT, BranchT>>
class OctreePointCloudIntensity
: public pcl::octree::OctreePointCloud<PointT, LeafT, BranchT, OctreeT> {
public:
  using Base = pcl::octree::OctreePointCloud<PointT, LeafT, BranchT, OctreeT>;
  using LeafNode = typename OctreeT::LeafNode;
  using BranchNode = typename OctreeT::BranchNode;

  /** \brief An empty octree.
   * \param[in] resolution voxel edge at the lowest level, metres, above 0
   */
  explicit OctreePointCloudIntensity(double resolution) : Base(resolution) {}

  ~OctreePointCloudIntensity() override = default;

  /** \brief The leaf of the voxel that contains a point.
   * \param[in] point any point, also outside the octree
   * \return the leaf, or nullptr if that voxel is empty
   */
  const LeafT*
  getLeafAtPoint(const PointT& point) const
  {
    // PCL does not check that a point is inside the box; the key of one outside may be
    // that of another voxel. To PCL a point of NaN is inside.
    const bool is_finite =
        std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
    return is_finite && this->isPointWithinBoundingBox(point)
               ? this->findLeafAtPoint(point)
               : nullptr;
  }

  /** \brief Voxel intensity I_v at a point: the sum of the intensities of the points in
   * its voxel, in their unit; 0 if the voxel is empty. */
  float
  getVoxelIntensityAtPoint(const PointT& point) const
  {
    const LeafT* leaf = getLeafAtPoint(point);
    return leaf != nullptr ? leaf->getIntensity() : 0.0f;
  }

  /** \brief Mean colour, in channels of 0 to 255, of the points in the voxel at a
   * point; nothing if the voxel is empty or its points have no colour. */
  std::optional<io::VoxelColour>
  getVoxelColourAtPoint(const PointT& point) const
  {
    const LeafT* leaf = getLeafAtPoint(point);
    return leaf != nullptr ? leaf->getColour() : std::nullopt;
  }

  /** \brief Number of points in the voxel at a point; 0 if the voxel is empty. */
  pcl::uindex_t
  getVoxelDensityAtPoint(const PointT& point) const
  {
    const LeafT* leaf = getLeafAtPoint(point);
    return leaf != nullptr ? leaf->getPointCounter() : 0;
  }

  /** \brief Adds the voxels of a frame, as decoders return them: a point at the centre
   * of each, with its intensity, or 1 without intensities, and its colour.
   * \param[in] frame as isConsistent() demands
   */
  void
  addVoxels(const io::VoxelFrame& frame)
  {
    std::size_t voxel = 0;
    io::forEachVoxelCentre(frame, [&](float x, float y, float z, float) {
      PointT centre;
      centre.x = x;
      centre.y = y;
      centre.z = z;
      addVoxel(frame, voxel++, leafAt(centre));
    });
  }

  /** \brief The centres of the voxels that were empty before the last switchBuffers(),
   * as pcl::octree::OctreePointCloudChangeDetector::getPointIndicesFromNewVoxels has
   * their points. For OctreeT = pcl::octree::Octree2BufBase, and with a bounding box, as
   * PCL's octree forgets the other buffer when it grows.
   * \param[out] centres with the voxels' intensities, where PointT has such a field
   * \return their number
   */
  pcl::uindex_t
  getNewVoxelCenters(typename Base::AlignedPointTVector& centres)
  {
    centres.clear();
    std::vector<LeafT*> new_leaves;
    this->serializeNewLeafs(new_leaves);
    std::sort(new_leaves.begin(), new_leaves.end());
    const auto end = leaf_depth_end();
    for (auto leaf = this->leaf_depth_begin(); leaf != end; ++leaf) {
      LeafT& container = leaf.getLeafContainer();
      if (!std::binary_search(new_leaves.begin(), new_leaves.end(), &container))
        continue;
      PointT centre;
      this->genLeafNodeCenterFromOctreeKey(leaf.getCurrentOctreeKey(), centre);
      setNativeIntensity(centre, container.getIntensity());
      centres.push_back(centre);
    }
    return static_cast<pcl::uindex_t>(centres.size());
  }

  /** \name Ends of PCL's iterators
   * PCL 1.13's Octree2BufBase returns end iterators without an octree, which never
   * compare equal; these do for both bases. */
  /** @{ */
  using OctreeT::breadth_end;
  using OctreeT::depth_end;
  using OctreeT::leaf_depth_end;

  typename OctreeT::LeafNodeDepthFirstIterator
  leaf_depth_end()
  {
    return typename OctreeT::LeafNodeDepthFirstIterator(this, 0, nullptr);
  }

  typename OctreeT::DepthFirstIterator
  depth_end()
  {
    return typename OctreeT::DepthFirstIterator(this, 0, nullptr);
  }

  typename OctreeT::BreadthFirstIterator
  breadth_end()
  {
    return typename OctreeT::BreadthFirstIterator(this, 0, nullptr);
  }
  /** @} */

  using OctreeT::deserializeTree;

  /** \brief Rebuilds the octree from serialized occupancy bytes, with empty leaves.
   *
   * In PCL's double-buffered octree a leaf that existed two frames ago would keep its
   * content.
   * \param[in] binary_tree what serializeTree wrote
   * \param[in] do_xor_decoding as PCL's: the bytes are differences to the other buffer
   */
  void
  deserializeTree(std::vector<char>& binary_tree,
                  [[maybe_unused]] bool do_xor_decoding = false)
  {
    resets_leaves_ = true;
    if constexpr (std::is_same<OctreeT, pcl::octree::OctreeBase<LeafT, BranchT>>::value)
      OctreeT::deserializeTree(binary_tree);
    else
      OctreeT::deserializeTree(binary_tree, do_xor_decoding);
    resets_leaves_ = false;
  }

protected:
  /** \brief Adds a voxel of a frame to its leaf, as addVoxels() does. */
  static void
  addVoxel(const io::VoxelFrame& frame, std::size_t voxel, LeafT& leaf)
  {
    leaf.addPointIntensity(frame.hasIntensities()
                               ? frame.intensity_scale.value(frame.intensities[voxel])
                               : 1.0f);
    if constexpr (detail::TakesColours<LeafT>::value)
      if (frame.colour_bits > 0)
        leaf.addPointColour(frame.fullColour(voxel));
  }

  /** \brief Adds a point of the input cloud with its intensity and its colour. */
  void
  addPointIdx(pcl::uindex_t point_index) override
  {
    assert(point_index < this->input_->size());
    const PointT& point = (*this->input_)[point_index];
    LeafT& leaf = leafAt(point);
    leaf.addPointIntensity(nativeIntensity(point, 1.0f));
    if constexpr (has_colour_field<PointT> && detail::TakesColours<LeafT>::value) {
      const std::uint32_t packed = packedColour(point);
      leaf.addPointColour({static_cast<std::uint8_t>(packed >> 16),
                           static_cast<std::uint8_t>(packed >> 8),
                           static_cast<std::uint8_t>(packed)});
    }
  }

  void
  deserializeTreeCallback(LeafT& leaf, const pcl::octree::OctreeKey& /*key*/) override
  {
    if (resets_leaves_)
      leaf.reset();
  }

private:
  // HasOctreeFunctions is asked only where it counts, as the functions may be included
  // after octrees of the library.
  static_assert(
      std::disjunction<detail::IsOctreeOfLibrary<PointT, LeafT, BranchT>,
                       detail::HasOctreeFunctions<PointT>>::value,
      "the library has octrees of PCL's point types with IntensityLeaf: for a point "
      "type, leaf or branch of your own include "
      "pcl_ext/octree/impl/octree_pointcloud_intensity.hpp, or define "
      "PCL_NO_PRECOMPILE "
      "before PCL's headers");

  /** \brief The leaf of the voxel of a point, for which the octree grows if it has to. */
  LeafT&
  leafAt(const PointT& point)
  {
    if (!this->bounding_box_defined_) {
      // Of two voxels on each axis, as PCL makes it; its would begin at the first point.
      const double edge = this->resolution_;
      const double x = std::floor(point.x / edge) * edge;
      const double y = std::floor(point.y / edge) * edge;
      const double z = std::floor(point.z / edge) * edge;
      this->defineBoundingBox(x, y, z, x + 2 * edge, y + 2 * edge, z + 2 * edge);
    }
    this->adoptBoundingBoxToPoint(point);
    pcl::octree::OctreeKey key;
    this->genOctreeKeyforPoint(point, key);
    LeafNode* leaf = nullptr;
    BranchNode* parent = nullptr;
    this->createLeafRecursive(key, this->depth_mask_, this->root_node_, leaf, parent);
    return **leaf;
  }

  bool resets_leaves_ = false;
};

/** @} */

} // namespace octree
} // namespace pcl_ext::PCL_EXT_ABI

#include <pcl/octree/impl/octree_iterator.hpp>

#if !PCL_EXT_USES_INSTANCES
#include <pcl_ext/octree/impl/octree_pointcloud_intensity.hpp>
#endif
