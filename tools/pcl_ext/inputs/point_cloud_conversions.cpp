// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/point_cloud_conversions.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "clouds/point_fields.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace pcl_ext::tools {

namespace {

using clouds::isBigEndianMachine;
using recording::PointCloudMessage;
using recording::PointFieldMessage;

/** \brief Turns the bytes of the numbers of a field around, as far as they are in the
 * point. */
void
swapNumbers(const pcl::PCLPointField& field,
            std::uint32_t point_step,
            std::uint8_t* point)
{
  const bool is_long = field.datatype == detail::int64_datatype ||
                       field.datatype == detail::uint64_datatype;
  const std::uint32_t size = is_long ? 8 : bytesOf(field.datatype);
  if (size < 2)
    return;
  // Some programs write a count of 0 for a single number.
  const std::uint32_t count = std::max<std::uint32_t>(field.count, 1);
  std::size_t begin = field.offset;
  for (std::uint32_t i = 0; i < count && begin + size <= point_step; ++i, begin += size)
    std::reverse(point + begin, point + begin + size);
}

/** \brief Turns the bytes of all numbers around. */
void
swapNumbers(pcl::PCLPointCloud2& cloud)
{
  const std::size_t row_step = rowStep(cloud);
  if (row_step < std::size_t{cloud.width} * cloud.point_step)
    return; // refused later
  for (std::size_t row = 0; row < cloud.height; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::size_t begin = row * row_step + column * cloud.point_step;
      if (begin + cloud.point_step > cloud.data.size())
        return;
      for (const pcl::PCLPointField& field : cloud.fields)
        swapNumbers(field, cloud.point_step, &cloud.data[begin]);
    }
}

/** \brief Writes decoded points one after the other. */
class PointWriter {
public:
  PointWriter(const io::VoxelFrame& frame, pcl::PCLPointCloud2& cloud) : cloud_(cloud)
  {
    cloud.fields.clear();
    cloud.point_step = 0;
    for (const char* name : {"x", "y", "z"})
      addField(name, frame.needsDoubles());
    if (hasIntensity(frame))
      addField("intensity");
    if (hasColour(frame))
      addField("rgb");
    for (const io::FrameField& field : frame.fields) {
      addField(field.name);
      cloud.fields.back().datatype = static_cast<std::uint8_t>(field.type);
      cloud.fields.back().count = field.count;
      const auto size =
          static_cast<std::uint32_t>(io::sizeOf(field.type) * field.count);
      cloud.point_step += size - bytesOf(pcl::PCLPointField::FLOAT32);
    }
    cloud.data.assign(frame.cloudSize() * cloud.point_step, 0);
    cloud.height = frame.cloudHeight();
    cloud.width = static_cast<std::uint32_t>(frame.cloudWidth());
    cloud.row_step = static_cast<std::uint32_t>(cloud.width * cloud.point_step);
    cloud.is_dense = frame.isDense() ? 1 : 0;
    if (!frame.isDense())
      writeMissingPoints(frame);
    cloud.is_bigendian = isBigEndianMachine() ? 1 : 0;
  }

  /** \brief Whether the voxels' intensities are written: not, if points have one. */
  static bool
  hasIntensity(const io::VoxelFrame& frame)
  {
    return frame.hasIntensities() && !io::hasField(frame.fields, "intensity");
  }

  static bool
  hasColour(const io::VoxelFrame& frame)
  {
    return frame.colour_bits > 0 && !io::hasField(frame.fields, "rgb") &&
           !io::hasField(frame.fields, "rgba");
  }

  void
  moveTo(const io::VoxelFrame& frame, std::size_t point)
  {
    written_ = frame.cloudIndex(point) * cloud_.point_step;
  }

  void
  writeFields(const io::VoxelFrame& frame, std::size_t point)
  {
    for (const io::FrameField& field : frame.fields)
      for (std::size_t i = 0; i < field.count; ++i) {
        io::fieldValue(
            field, field.numbers[point * field.count + i], &cloud_.data[written_]);
        written_ += io::sizeOf(field.type);
      }
  }

  template <typename NumberT>
  void
  write(NumberT number)
  {
    std::memcpy(&cloud_.data[written_], &number, sizeof(number));
    written_ += sizeof(number);
  }

private:
  /** \brief Writes points that are not a number. */
  void
  writeMissingPoints(const io::VoxelFrame& frame)
  {
    for (std::size_t i = 0; i < frame.cloudSize(); ++i) {
      written_ = i * cloud_.point_step;
      for (int axis = 0; axis < 3; ++axis)
        if (frame.needsDoubles())
          write(std::numeric_limits<double>::quiet_NaN());
        else
          write(std::numeric_limits<float>::quiet_NaN());
    }
  }

  void
  addField(const std::string& name, bool is_double = false)
  {
    pcl::PCLPointField field;
    field.name = name;
    field.offset = cloud_.point_step;
    field.datatype =
        is_double ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32;
    field.count = 1;
    cloud_.fields.push_back(field);
    cloud_.point_step += bytesOf(field.datatype);
  }

  pcl::PCLPointCloud2& cloud_;
  std::size_t written_ = 0;
};

} // namespace

void
toCloud(PointCloudMessage& message, pcl::PCLPointCloud2& cloud)
{
  cloud.header.frame_id = message.frame_id;
  cloud.header.stamp = static_cast<std::uint64_t>(
      std::max<std::int64_t>(message.stamp.count(), 0) / 1000);
  cloud.height = message.height;
  cloud.width = message.width;
  cloud.fields.clear();
  for (const PointFieldMessage& field : message.fields) {
    pcl::PCLPointField converted;
    converted.name = field.name;
    converted.offset = field.offset;
    converted.datatype = field.datatype;
    converted.count = field.count;
    cloud.fields.push_back(converted);
  }
  cloud.point_step = message.point_step;
  cloud.row_step = message.row_step;
  cloud.is_dense = message.is_dense ? 1 : 0;
  cloud.data.swap(message.bytes);
  cloud.is_bigendian = isBigEndianMachine() ? 1 : 0;
  if (message.is_bigendian != isBigEndianMachine() && cloud.point_step > 0)
    swapNumbers(cloud);
}

PointCloudMessage
describeCloud(const pcl::PCLPointCloud2& cloud, recording::Time stamp)
{
  PointCloudMessage message;
  message.stamp = stamp;
  message.frame_id = cloud.header.frame_id;
  message.height = cloud.height;
  message.width = cloud.width;
  for (const pcl::PCLPointField& field : cloud.fields)
    message.fields.push_back({field.name, field.offset, field.datatype, field.count});
  message.is_bigendian = cloud.is_bigendian != 0;
  message.point_step = cloud.point_step;
  message.row_step = cloud.row_step;
  message.is_dense = cloud.is_dense != 0;
  return message;
}

void
toCloud(const io::VoxelFrame& frame, pcl::PCLPointCloud2& cloud)
{
  PointWriter writer(frame, cloud);
  const bool has_intensity = PointWriter::hasIntensity(frame);
  const bool has_colour = PointWriter::hasColour(frame);
  const auto write_point = [&](std::size_t point,
                               auto x,
                               auto y,
                               auto z,
                               float intensity,
                               const io::VoxelColour& colour) {
    writer.moveTo(frame, point);
    writer.write(x);
    writer.write(y);
    writer.write(z);
    if (has_intensity)
      writer.write(intensity);
    if (has_colour)
      writer.write(std::uint32_t{0xff000000u} | std::uint32_t{colour.r} << 16 |
                   std::uint32_t{colour.g} << 8 | std::uint32_t{colour.b});
    writer.writeFields(frame, point);
  };
  io::forEachPoint(frame, write_point);
}

std::string
topicOf(const std::string& stream)
{
  const std::string end = compressed_suffix;
  if (stream.size() > end.size() &&
      stream.compare(stream.size() - end.size(), end.size(), end) == 0)
    return stream.substr(0, stream.size() - end.size());
  return stream;
}

} // namespace pcl_ext::tools
