// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Coloured clouds: of recordings, and of the robot cell with textured surfaces.
 */
#pragma once

#include "measuring/workload.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace measuring {

using ColouredCloud = pcl::PointCloud<pcl::PointXYZRGB>;

/** \brief Paints a cloud, the same way on all machines.
 *
 * Surfaces have patches of half a metre with a texture of 10 and 2 cm, by position in
 * the world; each channel has noise of a deviation of 4 of 255.
 * \param[in] positions in the world frame, metres
 * \param[in] seed of the noise; another one for each frame
 */
ColouredCloud::Ptr
paint(const PositionCloud& positions, std::uint32_t seed);

/** \brief Reads the coloured clouds of a recording, without points that are not finite.
 * \return none if the recording has no colours
 */
std::vector<ColouredCloud::Ptr>
readColouredFrames(const InputStream& stream);

} // namespace measuring
} // namespace pcl_ext
