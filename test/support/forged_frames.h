// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "stream/version1_header.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

struct Parts {
  Version1Header header;
  Bytes payload;
  std::uint32_t checksum = 0;
};

inline Parts
takeApart(const Bytes& frame)
{
  MemoryBuffer buffer(frame.data() + version1_magic_size,
                      frame.size() - version1_magic_size);
  ByteSource source(buffer, frame.size());
  Parts parts;
  Bytes header_bytes;
  const CompressionStatus status = readVersion1Header(
      source, DecoderLimits(), parts.header, parts.checksum, header_bytes);
  EXPECT_TRUE(status.ok()) << status.message();
  parts.payload.assign(frame.end() -
                           static_cast<std::ptrdiff_t>(parts.header.payload_size),
                       frame.end());
  return parts;
}

/** \brief A frame of a header, as it is, and a payload.
 * \param[in] reference_checksum of the frame that it depends on; 0 for an I-frame
 */
inline Bytes
putTogether(const Parts& parts, std::uint32_t reference_checksum = 0)
{
  Bytes bytes;
  writeVersion1Frame(parts.header, parts.payload, reference_checksum, bytes);
  return bytes;
}

/** \brief The same with the size that the payload has. */
inline Bytes
putTogetherSized(Parts parts, std::uint32_t reference_checksum = 0)
{
  parts.header.payload_size = parts.payload.size();
  return putTogether(parts, reference_checksum);
}

/** \brief The answer of a decoder to a forged frame after the first frame of a stream.
 * Refused, it must leave the stream as it was.
 * \param[in] next the stream's frames after the first one
 * \param[in] expected what these are decoded to
 */
inline CompressionCode
answerTo(const Bytes& forged,
         const Bytes& first,
         const std::vector<Bytes>& next,
         const std::vector<VoxelFrame>& expected)
{
  FrameDecoder decoder;
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, first, back), CompressionCode::Ok);
  const CompressionCode answer = decoded(decoder, forged, back);
  if (answer == CompressionCode::Ok) {
    EXPECT_TRUE(isConsistent(back));
    return answer;
  }
  for (std::size_t i = 0; i < next.size(); ++i) {
    EXPECT_EQ(decoded(decoder, next[i], back), CompressionCode::Ok);
    expectSameVoxels(back, expected[i]);
  }
  return answer;
}

constexpr std::size_t flags_offset = version1_magic_size + 1 + 4;

/** \brief A frame whose bytes were changed, with a valid checksum. */
inline Bytes
withChecksum(Bytes bytes, std::uint32_t reference_checksum = 0)
{
  const std::uint32_t checksum = chainedChecksum(
      reference_checksum, bytes.data() + flags_offset, bytes.size() - flags_offset);
  for (std::size_t i = 0; i < 4; ++i)
    bytes[version1_magic_size + 1 + i] = static_cast<std::uint8_t>(checksum >> 8 * i);
  return bytes;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
