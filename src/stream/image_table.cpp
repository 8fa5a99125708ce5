// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/image_table.h"

#include "codec/frame_failures.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>

namespace pcl_ext {
namespace io {

namespace {

constexpr unsigned int spinning_flag = 1;
constexpr unsigned int half_steps_flag = 2;
constexpr unsigned int unorganised_flag = 4;
constexpr unsigned int at_sensor_flag = 8;
constexpr unsigned int known_flags =
    spinning_flag | half_steps_flag | unorganised_flag | at_sensor_flag;

/** \brief The numbers of a row, in the order of the table. */
constexpr std::array<std::int32_t RayRow::*, 7> row_numbers = {&RayRow::cosine,
                                                               &RayRow::sine,
                                                               &RayRow::run,
                                                               &RayRow::rise,
                                                               &RayRow::along,
                                                               &RayRow::across,
                                                               &RayRow::up};

/** \brief A number, or where it has too many bits one that no rays have. */
std::int32_t
numberOrNone(std::int64_t number)
{
  using Limits = std::numeric_limits<std::int32_t>;
  return number >= Limits::min() && number <= Limits::max()
             ? static_cast<std::int32_t>(number)
             : Limits::min();
}

void
writeSpinningRays(const RayModel& rays, ByteWriter& writer)
{
  for (const auto& turn : rays.turns)
    for (const std::int32_t element : turn)
      writer.signedVarint(element);
  RayRow last;
  for (const RayRow& row : rays.rows) {
    for (const auto number : row_numbers)
      writer.signedVarint(std::int64_t{row.*number} - last.*number);
    last = row;
  }
}

void
readSpinningRays(ByteSource& source, PointImage& image)
{
  RayModel& rays = image.rays;
  rays.turns.resize(columnBits(image.width));
  for (auto& turn : rays.turns)
    for (std::int32_t& element : turn)
      element = numberOrNone(source.signedVarint());
  RayRow row;
  for (std::uint32_t i = 0;
       i < image.height && source.failure() == ByteSource::Failure::None;
       ++i) {
    for (const auto number : row_numbers) {
      const std::int64_t difference = source.signedVarint();
      constexpr std::int64_t most = std::int64_t{1} << 32;
      const bool is_near = difference >= -most && difference <= most;
      row.*number =
          is_near ? numberOrNone(row.*number + difference) : numberOrNone(most);
    }
    rays.rows.push_back(row);
  }
}

} // namespace

void
writeImageTable(const PointImage& image, ByteWriter& writer)
{
  const RayModel& rays = image.rays;
  writer.varint(image.width);
  writer.varint(image.height);
  const bool is_spinning = rays.shape == RayShape::Spinning;
  writer.u8(
      static_cast<std::uint8_t>((is_spinning ? spinning_flag : 0u) |
                                (rays.has_half_steps ? half_steps_flag : 0u) |
                                (image.is_organised ? 0u : unorganised_flag) |
                                (image.has_points_at_sensor ? at_sensor_flag : 0u)));
  writeRayPose(rays.pose, writer);
  if (is_spinning)
    writeSpinningRays(rays, writer);
}

void
writeRayPose(const RayPose& pose, ByteWriter& writer)
{
  for (const std::int64_t position : pose.origin)
    writer.signedVarint(position);
  for (const auto& vector : pose.vectors)
    for (const std::int64_t element : vector)
      writer.signedVarint(element);
}

void
readRayPose(ByteSource& source, RayPose& pose)
{
  for (std::int64_t& position : pose.origin)
    position = source.signedVarint();
  for (auto& vector : pose.vectors)
    for (std::int64_t& element : vector)
      element = source.signedVarint();
}

CompressionStatus
readImageTable(ByteSource& source, PointImage& image)
{
  image = PointImage();
  const std::uint64_t width = source.varint();
  const std::uint64_t height = source.varint();
  const std::uint8_t flags = source.u8();
  if (source.failure() != ByteSource::Failure::None)
    return {};
  if (width < 1 || height < 1 || width > most_image_side || height > most_image_side ||
      width * height > most_image_pixels || (flags & ~known_flags) != 0)
    return corruptFrame("invalid image");
  image.width = static_cast<std::uint32_t>(width);
  image.height = static_cast<std::uint32_t>(height);
  RayModel& rays = image.rays;
  rays.shape = (flags & spinning_flag) != 0 ? RayShape::Spinning : RayShape::Planar;
  rays.has_half_steps = (flags & half_steps_flag) != 0;
  image.is_organised = (flags & unorganised_flag) == 0;
  image.has_points_at_sensor = (flags & at_sensor_flag) != 0;
  readRayPose(source, rays.pose);
  if (rays.shape == RayShape::Spinning)
    readSpinningRays(source, image);
  if (source.failure() == ByteSource::Failure::None && !isConsistent(image))
    return corruptFrame("invalid rays of an image");
  return {};
}

} // namespace io
} // namespace pcl_ext
