// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/frame_failures.h"

#include <pcl_ext/compression/voxel_grid.h>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint64_t tenth = 100000; // of a megabyte

std::string
megabytes(std::uint64_t tenths)
{
  const std::string rest = tenths % 10 == 0 ? "" : "." + std::to_string(tenths % 10);
  return std::to_string(tenths / 10) + rest + " MB";
}

std::string
shownLimit(std::size_t bytes)
{
  return bytes < tenth ? std::to_string(bytes) + " bytes" : megabytes(bytes / tenth);
}

} // namespace

CompressionStatus
corruptFrame(const std::string& what)
{
  return {CompressionCode::Corrupt, "corrupt frame: " + what};
}

CompressionStatus
oldFrame(std::uint32_t number)
{
  return {
      CompressionCode::OldFrame,
      "frame " + std::to_string(number) +
          " is late or repeated, or belongs to another stream; it was dropped: each "
          "stream, also one that is decoded again, needs a decoder of its own"};
}

CompressionStatus
missingReference(std::uint32_t number, const std::optional<std::uint32_t>& last_number)
{
  return {CompressionCode::MissingReference,
          "P-frame " + std::to_string(number) + " depends on the previous frame; " +
              (last_number
                   ? "the last decoded frame is " + std::to_string(*last_number) +
                         ": frames are missing, or it belongs to another stream"
                   : "no frame was decoded") +
              "; decoding continues at the next I-frame"};
}

CompressionStatus
droppedReference(std::uint32_t number, std::size_t limit)
{
  return {CompressionCode::MissingReference,
          "P-frame " + std::to_string(number) +
              " depends on the previous frame, which was dropped to keep the memory "
              "limit of " +
              shownLimit(limit) + "; decoding continues at the next I-frame"};
}

CompressionStatus
tooMuchMemory(std::uint64_t bytes, std::size_t limit)
{
  return {CompressionCode::LimitExceeded,
          "the frame takes " +
              megabytes((bytes + tenth - 1) / tenth) + // above the limit
              " of memory or more, and the memory limit is " + shownLimit(limit)};
}

CompressionStatus
failedRead(const ByteSource& source, const std::string& part)
{
  if (source.failure() == ByteSource::Failure::LimitExceeded)
    return {CompressionCode::LimitExceeded, "frame exceeds the limit on bytes"};
  return {CompressionCode::Truncated, "the stream ends in " + part};
}

CompressionStatus
checkVoxelCount(std::uint64_t count, std::size_t max_voxels, const char* what)
{
  if (count <= max_voxels)
    return {};
  return {CompressionCode::LimitExceeded,
          "frame header: " + std::to_string(count) + ' ' + what +
              " exceed the limit of " + std::to_string(max_voxels)};
}

CompressionStatus
checkResolution(double resolution)
{
  if (resolution >= smallest_resolution && resolution <= largest_resolution)
    return {};
  return corruptFrame("resolution outside 1e-6 to 1e6 m");
}

} // namespace pcl_ext::PCL_EXT_ABI::io
