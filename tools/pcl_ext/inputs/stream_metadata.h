// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/intensity/intensity_law.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>

namespace pcl_ext::tools {

/** \brief What a channel of a recording tells of its stream besides the frames. */
using StreamMetadata = std::map<std::string, std::string>;

/** \brief The sensor's pose, x,y,z,qx,qy,qz,qw, where the clouds were moved by it. */
constexpr char pose_metadata[] = "sensor_pose";

/** \brief The name of the law that the intensities have. */
constexpr char law_metadata[] = "intensity_law";

/** \brief What sensor the clouds are of: lidar_sensor, where the rows of the first one
 * tell. */
constexpr char sensor_metadata[] = "sensor";
constexpr char lidar_sensor[] = "lidar";

/** \brief The box that clouds were cropped to, x0,y0,z0,x1,y1,z1 of the world,
 * metres. */
constexpr char crop_box_metadata[] = "crop_box";

/** \brief What was done to the clouds of a stream, and of what sensor they are. All
 * frames of a stream have the same. */
constexpr std::array<const char*, 4> cloud_metadata = {
    pose_metadata, law_metadata, sensor_metadata, crop_box_metadata};

/** \brief The VIEWPOINTs of the PCD files of its clouds, where they have some: stamp in
 * nanoseconds, colon, x,y,z,qw,qx,qy,qz; a semicolon before each change. */
constexpr char viewpoint_metadata[] = "viewpoint";

/** \brief The law that a stream's intensities have, if the recording tells. */
inline std::optional<IntensityLaw>
lawOf(const StreamMetadata& metadata)
{
  const auto found = metadata.find(law_metadata);
  return found == metadata.end() ? std::nullopt
                                 : valueNamed(intensity_laws, found->second);
}

/** \brief Whether a stream is known to be a lidar's. */
inline bool
isOfLidar(const StreamMetadata& metadata)
{
  const auto found = metadata.find(sensor_metadata);
  return found != metadata.end() && found->second == lidar_sensor;
}

/** \brief Adds what a channel tells in both of its forms, compressed or not, such as
 * the QoS that its publisher offered. */
inline void
addOtherMetadata(const StreamMetadata& from, StreamMetadata& to)
{
  for (const auto& [key, value] : from)
    if (std::find(cloud_metadata.begin(), cloud_metadata.end(), key) ==
            cloud_metadata.end() &&
        key != "topic_type_hash")
      to.emplace(key, value);
}

} // namespace pcl_ext::tools
