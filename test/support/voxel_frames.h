// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "stream/frame_encoder.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

using Bytes = std::vector<std::uint8_t>;

inline constexpr StreamFormat all_formats[] = {StreamFormat::Version1,
                                               StreamFormat::Published};
inline constexpr Effort all_efforts[] = {Effort::Fast, Effort::Balanced, Effort::Small};

inline std::string
nameOf(Effort effort)
{
  return effort == Effort::Fast       ? "Fast"
         : effort == Effort::Balanced ? "Balanced"
                                      : "Small";
}

inline std::string
nameOf(StreamFormat format)
{
  return format == StreamFormat::Version1 ? "Version1" : "Published";
}

/** \brief A number below `end`, the same on every machine. */
inline std::uint64_t
below(std::mt19937_64& random, std::uint64_t end)
{
  return random() % end;
}

inline float
uniform(std::mt19937_64& random, double low, double high)
{
  return static_cast<float>(low + (high - low) * static_cast<double>(random() >> 11) *
                                      0x1p-53);
}

/** \brief A frame of a grid about the origin, without voxels. */
inline VoxelFrame
emptyFrame(unsigned int depth, unsigned int bits = 8)
{
  VoxelFrame frame;
  frame.grid.resolution = 0.04;
  frame.grid.depth = depth;
  frame.grid.first_index.fill(
      static_cast<std::int32_t>(-(std::int64_t{1} << (depth - 1))));
  frame.intensity_scale.bits = bits;
  return frame;
}

inline void
clearVoxels(VoxelFrame& frame)
{
  frame.clearVoxels();
}

/** \brief Index of a voxel on the lattice of its frame's grid. */
inline std::array<std::int64_t, 3>
latticeIndex(const VoxelFrame& frame, std::size_t voxel)
{
  const VoxelPosition position = voxelPosition(frame.keys[voxel]);
  const auto& first = frame.grid.first_index;
  return {std::int64_t{first[0]} + position.x,
          std::int64_t{first[1]} + position.y,
          std::int64_t{first[2]} + position.z};
}

/** \brief Centre of a voxel as a cloud has it, metres. */
inline std::array<float, 3>
centreOf(const VoxelFrame& frame, std::size_t voxel)
{
  const VoxelPosition position = voxelPosition(frame.keys[voxel]);
  return {static_cast<float>(frame.grid.centre(0, position.x)),
          static_cast<float>(frame.grid.centre(1, position.y)),
          static_cast<float>(frame.grid.centre(2, position.z))};
}

/** \brief Replaces the voxels of a frame by a set, with random intensities; half of
 * these are small, as those of real sensors are. */
inline void
setVoxels(std::mt19937_64& random,
          const std::set<std::uint64_t>& keys,
          VoxelFrame& frame)
{
  frame.keys.assign(keys.begin(), keys.end());
  frame.intensities.clear();
  const std::uint64_t end = std::uint64_t{frame.intensity_scale.maxSymbol()} + 1;
  for (std::size_t i = 0; i < keys.size(); ++i)
    frame.intensities.push_back(static_cast<std::uint16_t>(
        below(random, below(random, 2) == 0 && end > 8 ? 8 : end)));
}

inline VoxelFrame
randomFrame(std::mt19937_64& random,
            unsigned int depth,
            std::size_t count,
            unsigned int bits = 8)
{
  VoxelFrame frame = emptyFrame(depth, bits);
  std::set<std::uint64_t> keys;
  while (keys.size() < count)
    keys.insert(below(random, std::uint64_t{1} << (3 * depth)));
  setVoxels(random, keys, frame);
  return frame;
}

/** \brief The next frame of a walk: a share of the voxels goes, as many come. */
inline void
walk(std::mt19937_64& random, unsigned int changes, VoxelFrame& frame)
{
  std::set<std::uint64_t> keys(frame.keys.begin(), frame.keys.end());
  const std::uint64_t end = std::uint64_t{1} << (3 * frame.grid.depth);
  for (unsigned int i = 0; i < changes && !keys.empty(); ++i)
    keys.erase(keys.lower_bound(below(random, *keys.rbegin() + 1)));
  for (unsigned int i = 0; i < changes; ++i)
    keys.insert(below(random, end));
  setVoxels(random, keys, frame);
}

/** \brief The bytes of a frame, voxels or a scan, that the encoder is expected to take.
 * */
template <class FrameT>
Bytes
encoded(FrameEncoder& encoder,
        const FrameT& frame,
        const std::optional<FrameStamp>& stamp = std::nullopt)
{
  Bytes bytes;
  const CompressionStatus status = encoder.encode(frame, stamp, bytes);
  EXPECT_TRUE(status.ok()) << status.message();
  return bytes;
}

/** \brief Decodes bytes; a failure must leave the frame empty. */
inline CompressionCode
decoded(FrameDecoder& decoder, const Bytes& bytes, VoxelFrame& frame)
{
  frame.keys = {1, 2, 3};
  frame.intensities = {1, 2, 3};
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), frame);
  if (!status.ok()) {
    EXPECT_TRUE(frame.keys.empty());
    EXPECT_TRUE(frame.intensities.empty());
    EXPECT_FALSE(status.message().empty());
  }
  return status.code();
}

inline void
expectSameVoxels(const VoxelFrame& frame, const VoxelFrame& expected)
{
  EXPECT_EQ(frame.keys, expected.keys);
  EXPECT_EQ(frame.intensities, expected.intensities);
  EXPECT_TRUE(frame.intensity_scale == expected.intensity_scale);
  EXPECT_EQ(frame.colour_bits, expected.colour_bits);
  EXPECT_TRUE(frame.colours == expected.colours);
  EXPECT_EQ(frame.has_point_counts, expected.has_point_counts);
  EXPECT_EQ(frame.point_counts, expected.point_counts);
  EXPECT_EQ(frame.points.width, expected.points.width);
  EXPECT_EQ(frame.points.height, expected.points.height);
  EXPECT_EQ(frame.points.indices, expected.points.indices);
  EXPECT_EQ(frame.points.positions, expected.points.positions);
  EXPECT_EQ(frame.points.intensities, expected.points.intensities);
  EXPECT_TRUE(frame.points.colours == expected.points.colours);
  ASSERT_EQ(frame.fields.size(), expected.fields.size());
  for (std::size_t i = 0; i < frame.fields.size(); ++i) {
    EXPECT_TRUE(frame.fields[i] == expected.fields[i]) << expected.fields[i].name;
    EXPECT_EQ(frame.fields[i].numbers, expected.fields[i].numbers)
        << expected.fields[i].name;
  }
}

inline void
expectSameFrame(const VoxelFrame& frame, const VoxelFrame& expected)
{
  expectSameVoxels(frame, expected);
  EXPECT_TRUE(frame.grid == expected.grid);
}

inline void
append(const Bytes& bytes, Bytes& stream)
{
  stream.insert(stream.end(), bytes.begin(), bytes.end());
}

inline Bytes
prefixOf(const Bytes& bytes, std::size_t size)
{
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

/** \brief Bytes with one bit inverted; bits are counted modulo their number. */
inline Bytes
flipped(Bytes bytes, std::size_t bit)
{
  bit %= 8 * bytes.size();
  bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1u << bit % 8);
  return bytes;
}

inline std::stringbuf
bufferOf(const Bytes& bytes)
{
  return std::stringbuf(std::string(bytes.begin(), bytes.end()));
}

struct EncodedFrames {
  std::vector<VoxelFrame> frames;
  std::vector<Bytes> bytes;
};

/** \brief Encodes a frame, and frames that each walk() on from the one before. */
inline EncodedFrames
encodedWalk(FrameEncoder& encoder,
            std::mt19937_64& random,
            VoxelFrame frame,
            std::size_t count,
            unsigned int changes)
{
  EncodedFrames stream;
  for (std::size_t i = 0; i < count; ++i) {
    stream.frames.push_back(frame);
    stream.bytes.push_back(encoded(encoder, frame));
    walk(random, changes, frame);
  }
  return stream;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
