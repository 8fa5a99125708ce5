// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Decoding as all targets that read streams check it: a frame is whole, or there
 * is none and a reason.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>

#include "fuzz_input.h"

#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

namespace pcl_ext::fuzz {

/** \brief Limits that small frames keep, so that no input takes long. */
inline io::DecoderLimits
smallLimits()
{
  io::DecoderLimits limits;
  limits.max_frame_bytes = std::size_t{1} << 13;
  limits.max_voxels = std::size_t{1} << 10;
  limits.max_points = std::size_t{1} << 12;
  limits.max_field_values = std::size_t{1} << 13;
  return limits;
}

/** \brief Requires that a frame that failed is empty and comes with a reason. */
inline void
requireReason(const io::CompressionStatus& status, const io::VoxelFrame& frame)
{
  require(!status.ok() && !status.message().empty());
  require(frame.keys.empty() && frame.intensities.empty() && frame.colours.empty() &&
          frame.point_counts.empty() && frame.fieldValueCount() == 0 &&
          !frame.points.areThere());
}

/** \brief Requires what isConsistent() checks, once more, and the small limits. */
inline void
requireWhole(const io::VoxelFrame& frame)
{
  require(isConsistent(frame));
  require(frame.size() <= smallLimits().max_voxels);
  const auto isWhole = [&](const auto& values, bool is_there) {
    return values.size() == (is_there ? frame.size() : 0);
  };
  require(isWhole(frame.intensities, frame.intensity_scale.bits > 0));
  require(isWhole(frame.colours, frame.colour_bits > 0));
  require(isWhole(frame.point_counts, frame.has_point_counts));
  for (std::size_t i = 0; i < frame.size(); ++i) {
    require(i == 0 || frame.keys[i - 1] < frame.keys[i]);
    require(frame.keys[i] >> (3 * frame.grid.depth) == 0);
  }
  for (const std::uint16_t symbol : frame.intensities)
    require(symbol <= frame.intensity_scale.maxSymbol());
  for (const io::VoxelColour& colour : frame.colours)
    require((colour.r | colour.g | colour.b) >> frame.colour_bits == 0);
  for (const std::uint32_t count : frame.point_counts)
    require(count > 0);
  require(frame.pointCount() <= smallLimits().max_points);
  require(frame.fieldValueCount() <= smallLimits().max_field_values);
}

/** \brief Requires that the size of a decoded frame is known from its bytes, and not
 * from fewer unless it is right. */
inline void
requireSize(const std::uint8_t* frame, std::size_t size)
{
  const io::FrameSize known = io::frameSize(frame, size, smallLimits());
  require(known.status.ok() && known.known == size && known.drop == 0);
  const io::FrameSize sooner = io::frameSize(frame, size - 1, smallLimits());
  require(sooner.known == size ||
          (sooner.status.code() == io::CompressionCode::Truncated &&
           sooner.needed <= size && sooner.drop == 0));
}

/** \brief Decodes a stream to its end.
 * \param[in] onFrame called with the end of each frame that was decoded, bytes
 */
template <typename OnFrameT>
void
decodeAll(const std::uint8_t* data,
          std::size_t size,
          io::FrameDecoder& decoder,
          OnFrameT onFrame)
{
  std::stringbuf buffer(std::string(data, data + size), std::ios_base::in);
  io::VoxelFrame frame;
  // Every call takes at least a byte or reports the end of the stream.
  for (std::size_t calls = 0;; ++calls) {
    require(calls <= size + 1);
    const io::CompressionStatus status = decoder.decode(buffer, frame);
    if (status.ok()) {
      requireWhole(frame);
      const auto end = static_cast<std::size_t>(
          std::streamoff(buffer.pubseekoff(0, std::ios_base::cur, std::ios_base::in)));
      requireSize(data + end - decoder.statistics().bytes, decoder.statistics().bytes);
      onFrame(end);
      continue;
    }
    requireReason(status, frame);
    if (status.code() == io::CompressionCode::EndOfStream)
      return;
  }
}

} // namespace pcl_ext::fuzz
