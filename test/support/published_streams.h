// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds for streams of the published layout, and the comparison of frames with
 * what PCL's own octree makes of them.
 *
 * \warning One translation unit per program may include this, as published_reference.h.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include "support/published_reference.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io::test {

using Cloud = pcl::PointCloud<pcl::PointXYZI>;

inline std::string
textOf(const Bytes& bytes)
{
  return {bytes.begin(), bytes.end()};
}

inline Bytes
bytesOf(const std::string& text)
{
  return {text.begin(), text.end()};
}

/** \brief Points in a box, a few of them on its faces; intensities are whole numbers,
 * so that no order of adding them up rounds. */
inline Cloud
randomCloud(std::mt19937_64& random, const BoundingBox& box, std::size_t count)
{
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    pcl::PointXYZI point;
    for (std::size_t axis = 0; axis < 3; ++axis)
      point.data[axis] = uniform(random, box.min[axis], box.max[axis]);
    if (i % 50 == 0) { // the first float within the box
      point.x = static_cast<float>(box.min[0]);
      if (double{point.x} < box.min[0])
        point.x = std::nextafter(point.x, static_cast<float>(box.max[0]));
    }
    point.intensity = static_cast<float>(below(random, 1 + below(random, 100)));
    cloud.push_back(point);
  }
  return cloud;
}

/** \brief Makes the next cloud of a stream: a fifth of its points go elsewhere. */
inline void
shake(std::mt19937_64& random, const BoundingBox& box, Cloud& cloud)
{
  const Cloud fresh = randomCloud(random, box, cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (below(random, 5) == 0)
      cloud[i] = fresh[i];
}

/** \brief Voxels and intensities, their order and the floats of the positions. */
inline void
expectSameCloud(const VoxelFrame& frame, const Cloud& expected)
{
  ASSERT_EQ(frame.size(), expected.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const std::array<float, 3> centre = centreOf(frame, i);
    ASSERT_EQ(centre,
              (std::array<float, 3>{expected[i].x, expected[i].y, expected[i].z}));
    ASSERT_EQ(frame.intensity_scale.value(frame.intensities[i]), expected[i].intensity);
  }
}

inline Eigen::Vector3d
corner(const std::array<double, 3>& coordinates)
{
  return {coordinates[0], coordinates[1], coordinates[2]};
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
