// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames that arrive in pieces: their size, and streams that wait for the rest.
 */
#include "support/golden_streams.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr CompressionCode truncated = CompressionCode::Truncated;

/** \brief Receives a stream as the documentation of frameSize() says, and returns the
 * frames' sizes. */
std::vector<std::size_t>
receive(const Bytes& stream)
{
  std::vector<std::size_t> sizes;
  Bytes buffer;
  std::size_t received = 0;
  std::size_t reads = 0;
  while (received < stream.size() || !buffer.empty()) {
    const FrameSize size = frameSize(buffer.data(), buffer.size());
    if (size.needed > buffer.size()) {
      // Never more than belongs to the frame.
      for (std::size_t i = buffer.size(); i < size.needed; ++i)
        buffer.push_back(stream.at(received++));
      ++reads;
    }
    else {
      EXPECT_EQ(size.status.ok(), size.drop == 0);
      EXPECT_LE(size.drop, buffer.size());
      EXPECT_GT(size.known + size.drop, 0u);
      if (size.drop == 0)
        sizes.push_back(size.known);
      buffer.erase(buffer.begin(),
                   buffer.begin() +
                       static_cast<std::ptrdiff_t>(size.known + size.drop));
    }
    if (reads > 2 * stream.size()) {
      ADD_FAILURE() << "no progress";
      break;
    }
  }
  return sizes;
}

TEST(FrameSizes, AreKnownOfAllGoldenStreams)
{
  for (const GoldenStream& golden : goldenStreams()) {
    SCOPED_TRACE(golden.name);
    FrameEncoder encoder(StreamFormat::Version1, golden.i_frame_rate, golden.effort);
    Bytes stream;
    std::vector<std::size_t> sizes;
    for (const GoldenFrame& golden_frame : golden.frames) {
      const Bytes frame =
          golden_frame.scan ? encoded(encoder, *golden_frame.scan, golden_frame.stamp)
                            : encoded(encoder, golden_frame.frame, golden_frame.stamp);
      append(frame, stream);
      sizes.push_back(frame.size());
    }
    EXPECT_EQ(receive(stream), sizes);
  }
}

TEST(FrameSizes, OfThePublishedLayoutAreKnownWhenTheFrameIsComplete)
{
  std::mt19937_64 random(3);
  FrameEncoder encoder(StreamFormat::Published, 3);
  const EncodedFrames sent =
      encodedWalk(encoder, random, randomFrame(random, 4, 12), 4, 5);
  for (const Bytes& frame : sent.bytes) {
    for (std::size_t count = 0; count < frame.size(); ++count) {
      const FrameSize size = frameSize(frame.data(), count);
      EXPECT_EQ(size.status.code(), truncated);
      EXPECT_GT(size.needed, count);
      EXPECT_LE(size.needed, frame.size());
    }
    Bytes more = frame;
    more.push_back('<');
    EXPECT_TRUE(frameSize(more.data(), more.size()).status.ok());
    EXPECT_EQ(frameSize(more.data(), more.size()).known, frame.size());
  }
}

TEST(FrameSizes, OfVersion1AreKnownFromTheHeader)
{
  std::mt19937_64 random(4);
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Balanced);
  const Bytes frame = encoded(encoder, randomFrame(random, 8, 3000));
  ASSERT_GT(frame.size(), 500u);
  EXPECT_TRUE(frameSize(frame.data(), 100).status.ok());
  EXPECT_EQ(frameSize(frame.data(), 100).known, frame.size());
}

TEST(FrameSizes, BytesInFrontOfAFrameAreToBeDropped)
{
  std::mt19937_64 random(5);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const Bytes frame = encoded(encoder, randomFrame(random, 4, 20));
    for (const std::string& text : {std::string("x"),
                                    std::string("PCX"),
                                    std::string("<HEAPCX<"),
                                    std::string(300, '\0')}) {
      Bytes stream(text.begin(), text.end());
      append(frame, stream);
      EXPECT_EQ(receive(stream), std::vector<std::size_t>{frame.size()});
    }
  }
}

TEST(FrameSizes, FramesThatADecoderRefusesAreToBeDropped)
{
  std::mt19937_64 random(6);
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Balanced);
  const Bytes frame = encoded(encoder, randomFrame(random, 8, 3000));
  DecoderLimits few_bytes;
  few_bytes.max_frame_bytes = frame.size() / 2;
  DecoderLimits few_voxels;
  few_voxels.max_voxels = 2000;
  for (const DecoderLimits& limits : {few_bytes, few_voxels}) {
    const FrameSize size = frameSize(frame.data(), frame.size(), limits);
    EXPECT_EQ(size.status.code(), CompressionCode::LimitExceeded);
    EXPECT_LE(size.drop, frame.size());
  }
  Bytes other_version = frame;
  other_version[4] = 2;
  EXPECT_EQ(frameSize(other_version.data(), other_version.size()).status.code(),
            CompressionCode::UnsupportedVersion);
}

/** \brief Appends a stream to a buffer byte by byte and decodes after each. */
void
expectFramesWhenComplete(const EncodedFrames& sent, IncompleteFrame incomplete_frame)
{
  const bool keeps = incomplete_frame == IncompleteFrame::Keep;
  FrameDecoder decoder(DecoderLimits(), incomplete_frame);
  std::stringbuf buffer;
  VoxelFrame back;
  std::size_t decoded_frames = 0;
  for (std::size_t i = 0; i < sent.bytes.size(); ++i)
    for (std::size_t j = 0; j < sent.bytes[i].size(); ++j) {
      buffer.sputc(static_cast<char>(sent.bytes[i][j]));
      const CompressionStatus status = decoder.decode(buffer, back);
      decoded_frames += status.ok() ? 1 : 0;
      if (!keeps)
        continue;
      const bool is_complete = j + 1 == sent.bytes[i].size();
      ASSERT_EQ(status.code(), is_complete ? CompressionCode::Ok : truncated) << status;
      EXPECT_EQ(back.size(), is_complete ? sent.frames[i].size() : 0u);
    }
  EXPECT_EQ(decoded_frames, keeps ? sent.bytes.size() : 0u);
}

TEST(IncompleteFrames, WaitForTheirRestIfToldTo)
{
  std::mt19937_64 random(7);
  for (const StreamFormat format : all_formats) {
    FrameEncoder encoder(format, 3, Effort::Balanced);
    const EncodedFrames sent =
        encodedWalk(encoder, random, randomFrame(random, 4, 30), 5, 5);
    expectFramesWhenComplete(sent, IncompleteFrame::Keep);
    expectFramesWhenComplete(sent, IncompleteFrame::Skip);
  }
}

TEST(IncompleteFrames, WaitBehindOtherBytes)
{
  std::mt19937_64 random(8);
  FrameEncoder encoder(StreamFormat::Version1, 3, Effort::Balanced);
  const Bytes frame = encoded(encoder, randomFrame(random, 4, 30));
  FrameDecoder decoder(DecoderLimits(), IncompleteFrame::Keep);
  VoxelFrame back;
  std::stringbuf buffer;
  const std::string garbage = "<HEAVY>";
  buffer.sputn(garbage.data(), static_cast<std::streamsize>(garbage.size()));
  EXPECT_EQ(decoder.decode(buffer, back).code(), CompressionCode::NoFrame);
  for (const std::uint8_t byte : frame)
    buffer.sputc(static_cast<char>(byte));
  EXPECT_TRUE(decoder.decode(buffer, back).ok());
}

// ---------------------------------------------------------------- other formats

TEST(ForeignBytes, AreNamedWithWhatReadsThem)
{
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"<PCL-OCT-COMPRESSED>\x01\x02", "pcl::io::OctreePointCloudCompression"},
      {"<PCL-ORG-COMPRESSED>\x01", "pcl::io::OrganizedPointCloudCompression"},
      {"# .PCD v0.7 - Point Cloud Data file format\n", "loadPCDFile"},
      {"VERSION 0.7\nFIELDS x y z\n", "loadPCDFile"},
      {"ply\nformat binary_little_endian 1.0\n", "loadPLYFile"},
      {"#ROSBAG V2.0\n", "ROS bag"},
      {"\x89MCAP\x30\r\n", "MCAP"},
      {"a letter to the reader", "text"}};
  for (const auto& [bytes, name] : cases) {
    std::stringbuf buffer(bytes);
    FrameDecoder decoder;
    VoxelFrame back;
    const CompressionStatus status = decoder.decode(buffer, back);
    EXPECT_EQ(status.code(), CompressionCode::NoFrame);
    EXPECT_NE(status.message().find(", which begin as "), std::string::npos) << status;
    EXPECT_NE(status.message().find(name), std::string::npos) << status;
  }
  for (const std::string& bytes : {std::string("short"), std::string(40, '\0')}) {
    std::stringbuf buffer(bytes);
    VoxelFrame back;
    const CompressionStatus status = FrameDecoder().decode(buffer, back);
    EXPECT_EQ(status.message().find("begin as"), std::string::npos) << status;
  }
}

} // namespace
