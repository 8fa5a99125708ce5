// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Short streams of few voxels in both formats and with all efforts, which
 * targets make once, so that they need not encode for each input.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>

#include "frame_row.h"
#include "fuzz_input.h"
#include "stream/frame_encoder.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace pcl_ext::fuzz {

using io::test::Bytes;

struct StreamKind {
  io::StreamFormat format;
  io::Effort effort;
  bool has_depth_model;
  bool has_fields = false; ///< and numbers of points
};

/** \brief Bytes of an input that mean different streams. */
constexpr std::uint8_t stream_choices = 16;

/** \brief The kinds by the byte of an input that chooses one. Effort Small takes
 * several times longer than the others to begin a stream, so that few bytes mean it. */
inline StreamKind
streamKind(std::uint8_t choice)
{
  using io::Effort;
  using io::StreamFormat;
  constexpr StreamKind kinds[] = {{StreamFormat::Version1, Effort::Fast, false},
                                  {StreamFormat::Version1, Effort::Balanced, false},
                                  {StreamFormat::Published, Effort::Balanced, false},
                                  {StreamFormat::Version1, Effort::Fast, true},
                                  {StreamFormat::Version1, Effort::Balanced, true},
                                  {StreamFormat::Version1, Effort::Fast, false, true}};
  constexpr StreamKind dear_kinds[] = {{StreamFormat::Version1, Effort::Small, false},
                                       {StreamFormat::Version1, Effort::Small, true}};
  choice = choice % stream_choices;
  return choice < 14 ? kinds[choice % 6] : dear_kinds[choice % 2];
}

/** \brief What a sensor saw. */
struct SensorFrame {
  io::VoxelFrame voxels;
  std::optional<io::FrameStamp> stamp;
};

/** \brief Frames with some voxels that come and go, one of them empty.
 * \param[in] resolution makes the streams of two sensors differ in every I-frame
 */
inline std::vector<SensorFrame>
sensorFrames(const StreamKind& kind,
             std::uint64_t seed,
             std::size_t count,
             double resolution)
{
  std::mt19937_64 random(seed);
  constexpr unsigned int depth = 4;
  io::VoxelFrame voxels = io::test::randomFrame(random, depth, 12);
  voxels.grid.resolution = resolution;
  if (kind.has_depth_model)
    voxels.depth_model = io::test::roomDepthModel(depth, voxels.intensity_scale.bits);
  std::vector<SensorFrame> frames;
  for (std::size_t i = 0; i < count; ++i) {
    SensorFrame frame{voxels, std::nullopt};
    if (i == 7)
      io::test::clearVoxels(frame.voxels);
    if (kind.has_fields) {
      frame.voxels.has_point_counts = true;
      frame.voxels.point_counts.assign(frame.voxels.size(), 1 + i % 2);
      io::test::addFields(random, frame.voxels);
    }
    // A name that does not fit into a short string, which would take no memory.
    if (kind.format == io::StreamFormat::Version1 && i % 3 != 2)
      frame.stamp =
          io::FrameStamp{1000 * seed + 33 * i,
                         i < 5 ? "sensor" : "a name that needs memory of its own"};
    frames.push_back(frame);
    io::test::walk(random, 3, voxels);
    if (kind.has_depth_model && i % 4 == 2)
      voxels.depth_model->origin += 1 << 20;
  }
  return frames;
}

/** \brief A frame of a stream as it is sent. */
struct SentFrame {
  const StreamKind* kind = nullptr;
  SensorFrame sensor_frame;
  Bytes bytes;
  bool is_i_frame = false;
  std::uint32_t number = 0;
  const SentFrame* predecessor = nullptr; ///< sent before it by the same encoder
};

struct SentStream {
  StreamKind kind{};
  std::vector<SentFrame> frames;

  SentStream() = default;
  SentStream(const SentStream&) = delete; // frames have pointers to each other
  SentStream(SentStream&&) = delete;
};

/** \brief Gives a frame of version 1 another number and makes its checksum right.
 * \param[in] reference_checksum of the frame that it depends on, 0 for an I-frame
 * \return its own checksum
 */
inline std::uint32_t
renumber(std::uint32_t number, std::uint32_t reference_checksum, Bytes& frame)
{
  RowFrame changed;
  changed.bytes = std::move(frame);
  changed.setFrameNumber(number);
  changed.setChecksum(reference_checksum);
  const std::uint32_t checksum = changed.checksum();
  frame = std::move(changed.bytes);
  return checksum;
}

/** \brief Encodes what a sensor saw.
 * \param[in] first_number number of the first frame; other than 1 for version 1 only
 */
inline void
sendAll(const StreamKind& kind,
        const std::vector<SensorFrame>& sensor_frames,
        unsigned int i_frame_rate,
        std::uint32_t first_number,
        SentStream& stream)
{
  stream.kind = kind;
  io::FrameEncoder encoder(kind.format, i_frame_rate, kind.effort);
  stream.frames.resize(sensor_frames.size());
  std::uint32_t checksum = 0;
  for (std::size_t i = 0; i < sensor_frames.size(); ++i) {
    SentFrame& frame = stream.frames[i];
    frame.kind = &stream.kind;
    frame.sensor_frame = sensor_frames[i];
    require(
        encoder.encode(frame.sensor_frame.voxels, frame.sensor_frame.stamp, frame.bytes)
            .ok());
    frame.is_i_frame = encoder.statistics().is_i_frame;
    frame.number = first_number + static_cast<std::uint32_t>(i);
    frame.predecessor = i == 0 ? nullptr : &stream.frames[i - 1];
    if (first_number != 1)
      checksum = renumber(frame.number, frame.is_i_frame ? 0 : checksum, frame.bytes);
  }
}

/** \brief Whether a decoder made of a frame's bytes what the sensor saw. */
inline bool
isSame(const SentFrame& sent,
       const io::VoxelFrame& decoded,
       const std::optional<io::FrameStamp>& stamp)
{
  const io::VoxelFrame& voxels = sent.sensor_frame.voxels;
  if (decoded.keys != voxels.keys || decoded.intensities != voxels.intensities ||
      decoded.intensity_scale != voxels.intensity_scale ||
      decoded.grid.resolution != voxels.grid.resolution ||
      decoded.grid.depth != voxels.grid.depth)
    return false;
  // The published layout stores the box of a grid, not its place on a lattice.
  if (sent.kind->format == io::StreamFormat::Published)
    return !stamp;
  const std::optional<io::FrameStamp>& expected = sent.sensor_frame.stamp;
  return decoded.grid == voxels.grid && stamp.has_value() == expected.has_value() &&
         (!stamp ||
          (stamp->stamp == expected->stamp && stamp->frame_id == expected->frame_id));
}

} // namespace pcl_ext::fuzz
