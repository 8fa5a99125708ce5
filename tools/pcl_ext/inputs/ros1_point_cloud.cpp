// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/ros1_point_cloud.h"

#include <stdexcept>
#include <string>

namespace pcl_ext {
namespace tools {

namespace {

/** \brief Reads numbers and arrays of ROS 1, little-endian and without padding. */
class Ros1Bytes {
public:
  Ros1Bytes(const std::uint8_t* bytes, std::size_t size)
  : next_(bytes), end_(bytes + size)
  {}

  std::uint8_t
  byte()
  {
    return *take(1);
  }

  std::uint32_t
  number()
  {
    const std::uint8_t* const bytes = take(4);
    std::uint32_t number = 0;
    for (int i = 3; i >= 0; --i)
      number = number << 8 | bytes[i];
    return number;
  }

  std::string
  text()
  {
    const std::uint32_t size = number();
    const std::uint8_t* const bytes = take(size);
    return {bytes, bytes + size};
  }

  const std::uint8_t*
  take(std::size_t count)
  {
    if (count > static_cast<std::size_t>(end_ - next_))
      throw std::runtime_error("the message ends within its fields");
    const std::uint8_t* const bytes = next_;
    next_ += count;
    return bytes;
  }

private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

} // namespace

void
readRos1PointCloud(const std::uint8_t* bytes,
                   std::size_t size,
                   recording::PointCloudMessage& message)
{
  Ros1Bytes source(bytes, size);
  source.number(); // sequence number
  const std::uint32_t seconds = source.number();
  const std::uint32_t nanoseconds = source.number();
  message.stamp = std::chrono::seconds(seconds) + recording::Time(nanoseconds);
  message.frame_id = source.text();
  message.height = source.number();
  message.width = source.number();
  message.fields.clear();
  for (std::uint32_t fields = source.number(); fields > 0; --fields) {
    recording::PointFieldMessage field;
    field.name = source.text();
    field.offset = source.number();
    field.datatype = source.byte();
    field.count = source.number();
    message.fields.push_back(field);
  }
  message.is_bigendian = source.byte() != 0;
  message.point_step = source.number();
  message.row_step = source.number();
  const std::uint32_t count = source.number();
  const std::uint8_t* const points = source.take(count);
  message.bytes.assign(points, points + count);
  message.is_dense = source.byte() != 0;
}

} // namespace tools
} // namespace pcl_ext
