// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds and frames as ROS messages, which are types of ROS 1 or ROS 2: both
 * have the same members.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/nodes/impl/message_layouts.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Name of a stream's format in the member `format` of CompressedPointCloud2. */
PCL_EXT_EXPORT const char*
messageFormat(io::StreamFormat format);

/** \brief A frame id as TF needs it. */
PCL_EXT_EXPORT std::string
withoutLeadingSlash(const std::string& frame_id);

/** \brief Why a CompressedPointCloud2 cannot be decoded, by its format; empty if
 * nothing. */
PCL_EXT_EXPORT std::string
faultOfFormat(const std::string& format);

/** \brief Why a central node drops a CompressedPointCloud2, by its frame id and its
 * format; empty if it does not.
 * \param[in] message the message
 * \param[in] global_frame frame id of the node, without a leading slash
 */
template <typename MessageT>
std::string
faultOfMessage(const MessageT& message, const std::string& global_frame)
{
  if (withoutLeadingSlash(message.header.frame_id) != global_frame)
    return "its frame_id is '" + message.header.frame_id + "', not '" + global_frame +
           "'";
  return faultOfFormat(message.format);
}

/** \brief The points of a frame as the data of a PointCloud2 with the layout that
 * describeVoxels() writes: those of forEachPoint(), in the order of their sensor if the
 * frame has it; missing ones have coordinates that are not a number.
 * \param[in] frame as forEachPoint() demands
 * \param[out] data frame.cloudSize() * point_step bytes
 */
PCL_EXT_EXPORT void
writeVoxelPoints(const io::VoxelFrame& frame, std::uint8_t* data);

/** \brief What describeVoxels() describes. */
struct VoxelPointLayout {
  std::size_t width = 0;
  std::uint32_t height = 1; ///< of an image above 1
  bool has_colours = false;
  bool has_doubles = false; ///< coordinates are FLOAT64
  std::vector<io::FieldDescription> fields;
  /** \brief Where voxels have none, points without a layout of messages have 0. */
  bool has_intensity = true;

  /** \brief Whether points have the intensity of their voxel: not, if they have their
   * own. */
  bool
  hasVoxelIntensity() const
  {
    return has_intensity && !io::hasField(fields, "intensity");
  }

  bool
  hasVoxelColour() const
  {
    return has_colours && !io::hasField(fields, "rgb") && !io::hasField(fields, "rgba");
  }

  /** \brief Bytes of a point. */
  std::size_t
  pointStep() const
  {
    std::size_t bytes = 3 * (has_doubles ? sizeof(double) : sizeof(float));
    bytes += (hasVoxelIntensity() ? 4 : 0) + (hasVoxelColour() ? 4 : 0);
    for (const io::FieldDescription& field : fields)
      bytes += io::sizeOf(field.type) * field.count;
    return bytes;
  }
};

/** \brief The layout of the points of a frame. */
PCL_EXT_EXPORT VoxelPointLayout
layoutOf(const io::VoxelFrame& frame);

/** \brief Describes a cloud of points at voxel centres: x, y, z in metres, FLOAT64
 * where VoxelFrame::needsDoubles() and else FLOAT32; intensity, FLOAT32; where there
 * are colours rgb: red, green and blue from bit 16, 8 and 0 on, the highest byte 0; and
 * the further fields, of which intensity, rgb and rgba take the place of these. The
 * header is unchanged.
 * \tparam MessageT PointCloud2 or CompressedPointCloud2
 */
template <typename MessageT>
void
describeVoxels(const VoxelPointLayout& layout, MessageT& message)
{
  message.height = layout.height;
  message.width = static_cast<std::uint32_t>(layout.width);
  message.fields.clear();
  message.point_step = 0;
  const auto add =
      [&message](const std::string& name, io::FieldType type, std::uint32_t count) {
        auto& field = message.fields.emplace_back();
        field.name = name;
        field.offset = message.point_step;
        field.datatype = static_cast<std::uint8_t>(type);
        field.count = count;
        message.point_step += static_cast<std::uint32_t>(io::sizeOf(type) * count);
      };
  for (const char* name : {"x", "y", "z"})
    add(name, layout.has_doubles ? io::FieldType::Float64 : io::FieldType::Float32, 1);
  if (layout.hasVoxelIntensity())
    add("intensity", io::FieldType::Float32, 1);
  if (layout.hasVoxelColour())
    add("rgb", io::FieldType::Float32, 1);
  for (const io::FieldDescription& field : layout.fields)
    add(field.name, field.type, field.count);
  message.is_bigendian = false;
  message.row_step = message.point_step * message.width;
  message.is_dense = layout.height == 1;
}

/** \brief Describes the last frame of a node in its message: the format, and the cloud
 * that the frame is decoded to. Header and bytes are unchanged.
 * \tparam MessageT CompressedPointCloud2
 */
template <typename MessageT>
void
describeFrame(const SensorNodeStatistics& statistics,
              const SensorNodeSettings& settings,
              MessageT& message)
{
  describeVoxels(VoxelPointLayout{statistics.decoded_width,
                                  statistics.decoded_height,
                                  statistics.preprocessing.has_colours,
                                  statistics.decoded_doubles,
                                  statistics.decoded_fields,
                                  !statistics.decoded_layout ||
                                      settings.law != IntensityLaw::None},
                 message);
  if (statistics.decoded_layout) {
    const Arrangement arrangement = arrangementOf(*statistics.decoded_layout, message);
    if (arrangement.refusal().empty())
      describeArranged(arrangement, message);
  }
  message.format = messageFormat(settings.compression.format);
}

/** \brief Writes the voxels of a frame into a PointCloud2, except for its header.
 * \param[in] frame as forEachPoint() demands
 * \param[out] message in the frame's layout if that is possible, see Arrangement; else
 * see describeVoxels
 */
template <typename PointCloud2T>
void
writeVoxels(const io::VoxelFrame& frame, PointCloud2T& message)
{
  describeVoxels(layoutOf(frame), message);
  // Not row_step, which is of 32 bits.
  message.data.resize(frame.cloudSize() * message.point_step);
  writeVoxelPoints(frame, message.data.data());
  if (frame.layout)
    arrange(*frame.layout, message);
}

/** \brief The layout of a PointCloud2, without points and without stamp. */
template <typename PointCloud2T>
void
copyLayout(const PointCloud2T& message, pcl::PCLPointCloud2& cloud)
{
  cloud.header.frame_id = message.header.frame_id;
  cloud.height = message.height;
  cloud.width = message.width;
  cloud.fields.resize(message.fields.size());
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    cloud.fields[i].name = message.fields[i].name;
    cloud.fields[i].offset = message.fields[i].offset;
    cloud.fields[i].datatype = message.fields[i].datatype;
    cloud.fields[i].count = message.fields[i].count;
  }
  cloud.is_bigendian = message.is_bigendian;
  cloud.point_step = message.point_step;
  cloud.row_step = message.row_step;
  cloud.is_dense = message.is_dense;
}

/** \brief A PointCloud2 as PCL's, without its stamp. Reuses the memory of `cloud`. */
template <typename PointCloud2T>
void
toPcl(const PointCloud2T& message, pcl::PCLPointCloud2& cloud)
{
  copyLayout(message, cloud);
  cloud.data.assign(message.data.begin(), message.data.end());
}

/** \brief The same, where the message is not needed any more: its points are moved. */
template <typename PointCloud2T>
void
moveToPcl(PointCloud2T& message, pcl::PCLPointCloud2& cloud)
{
  copyLayout(message, cloud);
  cloud.data = std::move(message.data);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
