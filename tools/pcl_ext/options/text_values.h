// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Values of options that are more than a number or a name.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/rigid_pose.h>

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Reads numbers with commas or spaces between them.
 * \param[in] option for messages
 * \throws UsageError if one is no finite number
 */
std::vector<double>
parseNumbers(const std::string& option, const std::string& text);

/** \brief The same with the number of numbers.
 * \throws UsageError also if there are fewer or more
 */
std::vector<double>
parseNumbers(const std::string& option, const std::string& text, std::size_t count);

/** \brief Reads a box: x0,y0,z0,x1,y1,z1.
 * \throws UsageError
 */
io::BoundingBox
parseBox(const std::string& option, const std::string& text);

/** \brief Reads x,y,z.
 * \throws UsageError
 */
std::array<double, 3>
parsePosition(const std::string& option, const std::string& text);

/** \brief Reads the name of a sensor, or horizontal degrees,vertical
 * degrees,columns,rows.
 * \throws UsageError
 */
RuntimeSensor
parseSensor(const std::string& text);

/** \brief Reads a pose: x,y,z,roll,pitch,yaw in metres and degrees (about the fixed
 * axes x, y and z, in this order, as in ROS); x,y,z,qx,qy,qz,qw; or the 12 or 16
 * numbers of a matrix of 3 or 4 rows.
 * \throws UsageError if the numbers are no rigid transform
 */
WorldPose
parsePose(const std::string& text);

/** \brief Reads a rate: a number above 0 and a unit, bit/s, kbit/s, Mbit/s or Gbit/s in
 * any case, with a blank between them or none: 2Mbit/s.
 * \return bits a second
 * \throws UsageError
 */
double
parseRate(const std::string& text);

/** \brief Reads a time: a number above 0 and a unit, ms, s, min, h or d: 10min.
 * \param[in] option for messages
 * \param[in] may_be_zero whether 0 is a number, too
 * \return seconds
 * \throws UsageError
 */
double
parseDuration(const std::string& option,
              const std::string& text,
              bool may_be_zero = false);

/** \brief Reads a time as parseDuration() does, or a number alone, of seconds: 0.5.
 * \throws UsageError
 */
double
parseSeconds(const std::string& option, const std::string& text);

/** \brief Reads a size: a number above 0 and a unit, kB, MB, GB or TB, powers of 1000.
 * \return bytes
 * \throws UsageError
 */
double
parseBytes(const std::string& option, const std::string& text);

/** \brief Numbers of frames: begin to end - 1. */
struct FrameRange {
  std::size_t begin = 0;
  std::size_t end = std::numeric_limits<std::size_t>::max();
};

/** \brief A number of things: "1 frame", "1,234 frames". */
std::string
counted(std::size_t count, const std::string& noun);

/** \brief What the points of a scan are, by its I-frame: "in order, 640 x 480", which is
 * the size of the cloud, "in order, on 1800 x 16 rays", or "row by row" on rays; of one
 * without rays "in order, 640 x 480, without rays" or "in order, without rays". */
std::string
inOrder(const io::FrameDescription& frame);

/** \brief Reads A:B, either of which may be left out; N alone is that frame.
 * \throws UsageError, also if the range is empty
 */
FrameRange
parseFrames(const std::string& text);

} // namespace pcl_ext::tools
