// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/cloud_messages.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr const char* format_of_version1 = "pcl_ext/version1";
constexpr const char* format_of_published = "pcl_ext/published";

/** \brief Writes the further fields of a point. */
void
writeFields(const io::VoxelFrame& frame, std::size_t point, std::uint8_t* data)
{
  for (const io::FrameField& field : frame.fields)
    for (std::size_t i = 0; i < field.count; ++i) {
      io::fieldValue(field, field.numbers[point * field.count + i], data);
      data += io::sizeOf(field.type);
    }
}

/** \brief Writes points that are not a number, with fields of 0. */
void
writeMissingPoints(const VoxelPointLayout& layout, std::uint8_t* data)
{
  const std::size_t point_step = layout.pointStep();
  const std::size_t points = layout.width * layout.height;
  std::fill_n(data, points * point_step, std::uint8_t{0});
  const auto write = [&](auto not_a_number) {
    const std::array<decltype(not_a_number), 3> place{
        not_a_number, not_a_number, not_a_number};
    for (std::size_t i = 0; i < points; ++i)
      std::memcpy(data + i * point_step, place.data(), sizeof(place));
  };
  if (layout.has_doubles)
    write(std::numeric_limits<double>::quiet_NaN());
  else
    write(std::numeric_limits<float>::quiet_NaN());
}

} // namespace

const char*
messageFormat(io::StreamFormat format)
{
  return format == io::StreamFormat::Published ? format_of_published
                                               : format_of_version1;
}

std::string
withoutLeadingSlash(const std::string& frame_id)
{
  return !frame_id.empty() && frame_id.front() == '/' ? frame_id.substr(1) : frame_id;
}

std::string
faultOfFormat(const std::string& format)
{
  return format == format_of_version1 || format == format_of_published
             ? ""
             : "unknown format '" + format + "'";
}

VoxelPointLayout
layoutOf(const io::VoxelFrame& frame)
{
  return {frame.cloudWidth(),
          frame.cloudHeight(),
          frame.colour_bits > 0,
          frame.needsDoubles(),
          {frame.fields.begin(), frame.fields.end()},
          !frame.layout || frame.hasIntensities()};
}

void
writeVoxelPoints(const io::VoxelFrame& frame, std::uint8_t* data)
{
  const VoxelPointLayout layout = layoutOf(frame);
  const bool has_intensity = layout.hasVoxelIntensity();
  const bool has_colour = layout.hasVoxelColour();
  const std::size_t point_step = layout.pointStep();
  if (!frame.isDense())
    writeMissingPoints(layout, data);
  const auto write_point = [&](std::size_t point,
                               auto x,
                               auto y,
                               auto z,
                               float intensity,
                               const io::VoxelColour& colour) {
    std::uint8_t* next = data + frame.cloudIndex(point) * point_step;
    const auto append = [&next](const auto& element) {
      std::memcpy(next, &element, sizeof(element));
      next += sizeof(element);
    };
    append(std::array<decltype(x), 3>{x, y, z});
    if (has_intensity)
      append(intensity);
    if (has_colour)
      append(std::uint32_t{colour.r} << 16 | std::uint32_t{colour.g} << 8 | colour.b);
    writeFields(frame, point, next);
  };
  io::forEachPoint(frame, write_point);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
