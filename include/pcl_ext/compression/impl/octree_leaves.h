// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/octree/octree_pointcloud_intensity.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

/** \brief A leaf of an octree as a point. */
struct LeafPoint {
  std::array<double, 3> centre; ///< metres
  float intensity;              ///< as its getIntensity() has it
  std::uint32_t colour;         ///< red, green and blue from bit 16, 8 and 0 on
};

/** \brief Whether the leaves of an octree have getColour(). */
template <typename TreeT>
constexpr bool
hasColours()
{
  return octree::detail::TakesColours<std::decay_t<
      decltype(std::declval<TreeT&>().leaf_depth_begin().getLeafContainer())>>::value;
}

/** \brief The leaves of an octree, in its order; those without a colour are white. */
template <typename TreeT>
std::vector<LeafPoint>
pointsOfLeaves(TreeT& tree)
{
  const double edge = tree.getResolution();
  std::array<double, 3> min{};
  std::array<double, 3> max{};
  tree.getBoundingBox(min[0], min[1], min[2], max[0], max[1], max[2]);
  std::vector<LeafPoint> points;
  points.reserve(tree.getLeafCount());
  const auto end = tree.leaf_depth_end();
  for (auto leaf = tree.leaf_depth_begin(); leaf != end; ++leaf) {
    const pcl::octree::OctreeKey& key = leaf.getCurrentOctreeKey();
    const std::array<pcl::uindex_t, 3> voxel{key.x, key.y, key.z};
    LeafPoint& point = points.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      point.centre[axis] = (std::round(min[axis] / edge) + voxel[axis] + 0.5) * edge;
    point.intensity = leaf.getLeafContainer().getIntensity();
    point.colour = 0xffffff;
    if constexpr (hasColours<TreeT>())
      if (const std::optional<VoxelColour> colour = leaf.getLeafContainer().getColour())
        point.colour = static_cast<std::uint32_t>(colour->r) << 16 |
                       static_cast<std::uint32_t>(colour->g) << 8 | colour->b;
  }
  return points;
}

/** \brief A view of leaves.
 * \param[in] points must stay while the view is used
 */
inline PointView
viewOf(const std::vector<LeafPoint>& points, bool has_colours, bool has_intensities)
{
  PointView view;
  view.count = points.size();
  if (points.empty())
    return view;
  view.double_coordinates = points.front().centre.data();
  view.coordinate_stride = sizeof(LeafPoint);
  if (has_intensities) {
    view.intensities = &points.front().intensity;
    view.intensity_stride = sizeof(LeafPoint);
  }
  if (has_colours) {
    view.colours = &points.front().colour;
    view.colour_stride = sizeof(LeafPoint);
  }
  return view;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::detail
