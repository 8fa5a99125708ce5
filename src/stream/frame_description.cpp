// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>

#include "bytes/byte_source.h"
#include "bytes/exceptions.h"
#include "codec/frame_failures.h"
#include "codec/published/frame_header.h"
#include "stream/frame_search.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Describes a frame of stream version 1.
 * \param[in,out] source after the magic bytes
 */
void
describeVersion1(ByteSource& source,
                 const DecoderLimits& limits,
                 FrameDescription& description)
{
  Version1Header header;
  std::uint32_t checksum = 0;
  std::vector<std::uint8_t> checked_bytes;
  description.status =
      readVersion1Header(source, limits, header, checksum, checked_bytes);
  description.format = StreamFormat::Version1;
  description.frame_number = header.frame_number;
  description.is_i_frame = header.is_i_frame;
  description.is_of_changes = header.is_of_changes;
  description.effort = header.effort;
  description.has_points = header.content.has_scan;
  description.voxels = static_cast<std::size_t>(header.voxel_count);
  description.points = header.content.has_point_counts
                           ? static_cast<std::size_t>(header.point_count)
                           : description.voxels;
  if (header.is_i_frame) {
    description.grid = header.grid;
    description.intensity_scale = header.intensity_scale;
    description.colour_bits = header.content.colour_bits;
    description.has_point_counts = header.content.has_point_counts;
    description.fields = header.fields;
    description.scan = {header.scan.width, header.scan.height};
    description.has_rays =
        header.content.has_scan && header.scan.rays.shape != scan::RayShape::Free;
    description.is_row_by_row = header.content.has_scan &&
                                header.scan.order == scan::PointOrder::RowByRow &&
                                header.scan.rays.shape == scan::RayShape::Spinning;
    if (header.scan.isSequence())
      description.scan = {static_cast<std::uint32_t>(header.point_count), 1};
    description.is_organised =
        header.content.has_scan && header.scan.order == scan::PointOrder::Organised;
    if (header.stamp)
      description.stamp = static_cast<std::uint64_t>(*header.stamp);
  }
  else {
    description.stamp_difference = header.stamp;
  }
  if (header.has_frame_id || header.is_i_frame)
    description.frame_id = header.frame_id;
}

/** \brief Describes a frame of the published layout.
 * \param[in,out] source after the magic bytes
 */
void
describePublished(ByteSource& source,
                  const DecoderLimits& limits,
                  FrameDescription& description)
{
  published::FrameHeader header;
  description.status = published::readFrameHeader(source, limits, header);
  if (description.status.ok() && source.failure() != ByteSource::Failure::None)
    description.status = failedRead(source, "a frame header");
  description.format = StreamFormat::Published;
  description.frame_number = header.frame_number;
  description.is_i_frame = header.is_i_frame;
  description.voxels = static_cast<std::size_t>(header.voxel_count);
  description.points = description.voxels;
  if (header.is_i_frame)
    description.grid = header.grid;
}

FrameDescription
describeBytes(const std::uint8_t* bytes, std::size_t count, const DecoderLimits& limits)
{
  FrameDescription description;
  const FoundFormat format = possibleFormat(bytes, count);
  const bool is_published = format == FoundFormat::Published;
  const std::size_t magic_size =
      is_published ? published::magic_size : version1_magic_size;
  if (format == FoundFormat::None || count < magic_size) {
    description.status = frameSize(bytes, count, limits).status;
    return description;
  }
  MemoryBuffer buffer(bytes + magic_size, count - magic_size);
  ByteSource source(
      buffer, limits.max_frame_bytes - std::min(limits.max_frame_bytes, magic_size));
  if (is_published)
    describePublished(source, limits, description);
  else
    describeVersion1(source, limits, description);
  return description;
}

} // namespace

FrameDescription
describeFrame(const std::uint8_t* bytes, std::size_t count, const DecoderLimits& limits)
{
  return callOrElse([&] { return describeBytes(bytes, count, limits); },
                    [] {
                      FrameDescription failed;
                      failed.status = outOfMemoryStatus<CompressionStatus>();
                      return failed;
                    });
}

} // namespace pcl_ext::PCL_EXT_ABI::io
