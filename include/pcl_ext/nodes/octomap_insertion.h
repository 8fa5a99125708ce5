// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/impl/free_nodes.h>

#include <octomap/OcTree.h>

#include <algorithm>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \addtogroup nodes
 * @{ */

/** \brief Inserts a frame's voxels into an OctoMap, weighted by their intensity.
 *
 * A voxel of `full_intensity` or more counts as one hit of the map's sensor model, a
 * smaller intensity as that share of a hit: share * getProbHitLog() is added to the
 * log-odds of the node that contains the voxel's centre. Intensities of 0 or less
 * change nothing; voxels of a frame without intensities are hits. With an origin, nodes
 * on the rays to the voxels that contain no voxel count as missed, so that objects that
 * have left are removed from the map.
 *
 * Voxels outside of the map, which has 32768 nodes an axis to either side of its
 * origin, are left out; so are the rays if the origin is outside.
 *
 * Needs OctoMap, which the library itself does not: link with octomap.
 * \param[in] frame the voxels, world coordinates
 * \param[in] full_intensity intensity that counts as one hit, in the unit of the frame;
 * above 0
 * \param[in] sensor_origin where the sensor is in the world, metres; none: no rays
 * \param[in,out] map of any resolution; with that of the frame, the two grids coincide
 * \param[in] lazy_eval as in OctoMap: inner nodes may stay as they are, which is faster
 * if several frames are inserted before map.updateInnerOccupancy()
 */
inline void
insertVoxels(const io::VoxelFrame& frame,
             float full_intensity,
             const std::optional<octomap::point3d>& sensor_origin,
             octomap::OcTree& map,
             bool lazy_eval = false)
{
  // Until the end, as each update of inner nodes would walk the tree again.
  constexpr bool lazily = true;
  const float margin = io::faceMargin(map.getResolution());

  const auto forEachVoxel = [&](const auto& visit) {
    io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
      visit(octomap::point3d(x + margin, y + margin, z + margin), intensity);
    });
  };

  octomap::OcTreeKey origin_key;
  if (sensor_origin && map.coordToKeyChecked(*sensor_origin, origin_key)) {
    detail::FreeNodes free_nodes;
    const auto forEachKey = [&](const auto& visit) {
      forEachVoxel([&](const octomap::point3d& centre, float) {
        if (octomap::OcTreeKey key; map.coordToKeyChecked(centre, key))
          visit(centre, key);
      });
    };
    forEachKey([&](const octomap::point3d& centre, const octomap::OcTreeKey&) {
      free_nodes.addRay(map, *sensor_origin, centre);
    });
    forEachKey([&](const octomap::point3d&, const octomap::OcTreeKey& key) {
      free_nodes.remove(key);
    });
    free_nodes.countAsMissed(map);
  }
  forEachVoxel([&](const octomap::point3d& centre, float intensity) {
    const float trust = frame.hasIntensities()
                            ? std::clamp(intensity / full_intensity, 0.0f, 1.0f)
                            : 1.0f;
    // A node that only exists counts as occupied.
    if (trust > 0.0f)
      map.updateNode(centre, trust * map.getProbHitLog(), lazily);
  });
  if (!lazy_eval)
    map.updateInnerOccupancy();
}

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::nodes
