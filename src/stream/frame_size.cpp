// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>

#include "bytes/byte_source.h"
#include "bytes/exceptions.h"
#include "codec/frame_failures.h"
#include "codec/published/frame.h"
#include "stream/frame_search.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Bytes to drop before the next place where a frame may begin, at least 1. */
std::size_t
bytesToDrop(const std::uint8_t* bytes, std::size_t count)
{
  std::size_t drop = 1;
  while (drop < count &&
         possibleFormat(bytes + drop, count - drop) == FoundFormat::None)
    ++drop;
  return drop;
}

/** \brief Reads as much of a frame as tells its size.
 * \param[in,out] source after the magic bytes
 * \param[out] size of the frame without the magic bytes
 */
CompressionStatus
readVersion1(ByteSource& source, const DecoderLimits& limits, std::size_t& size)
{
  Version1Header header;
  std::uint32_t checksum = 0;
  std::vector<std::uint8_t> checked_bytes;
  const CompressionStatus status =
      readVersion1Header(source, limits, header, checksum, checked_bytes);
  size = source.consumed() + static_cast<std::size_t>(header.payload_size);
  return status;
}

CompressionStatus
readPublished(ByteSource& source, const DecoderLimits& limits, std::size_t& size)
{
  published::History no_history;
  FrameOrder order(false);
  VoxelFrame frame;
  CodedFrameStatistics statistics;
  const CompressionStatus status =
      published::decodeFrame(source, limits, no_history, order, frame, statistics);
  size = source.consumed();
  // A P-frame without its reference is read completely.
  return status.code() == CompressionCode::MissingReference ? CompressionStatus()
                                                            : status;
}

FrameSize
readSize(const std::uint8_t* bytes, std::size_t count, const DecoderLimits& limits)
{
  // A P-frame without voxels has 16 bytes.
  constexpr std::size_t smallest_frame = 16;
  const FoundFormat format = possibleFormat(bytes, count);
  if (format == FoundFormat::None) {
    std::string message = "no frame begins with these bytes";
    const std::string name =
        describeForeignBytes(bytes, std::min(count, foreign_bytes_size));
    if (!name.empty())
      message += ", which begin as " + name;
    return {{CompressionCode::NoFrame, message}, 0, 0, bytesToDrop(bytes, count)};
  }
  if (count < smallest_frame)
    return {
        {CompressionCode::Truncated, "the beginning of a frame"}, 0, smallest_frame};
  const bool is_published = format == FoundFormat::Published;
  const std::size_t magic_size =
      is_published ? published::magic_size : version1_magic_size;
  MemoryBuffer buffer(bytes + magic_size, count - magic_size);
  ByteSource source(
      buffer, limits.max_frame_bytes - std::min(limits.max_frame_bytes, magic_size));
  std::size_t size = 0;
  CompressionStatus status = is_published ? readPublished(source, limits, size)
                                          : readVersion1(source, limits, size);
  if (status.code() == CompressionCode::Truncated)
    return {status, 0, count + 1};
  if (!status.ok())
    return {status, 0, 0, bytesToDrop(bytes, count)};
  return {status, magic_size + size, magic_size + size};
}

} // namespace

FrameSize
frameSize(const std::uint8_t* bytes, std::size_t count, const DecoderLimits& limits)
{
  return callOrElse([&] { return readSize(bytes, count, limits); },
                    [] { return FrameSize{outOfMemoryStatus<CompressionStatus>()}; });
}

} // namespace pcl_ext::PCL_EXT_ABI::io
