// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_encoder.h"
#include "support/bitwise_crc.h"
#include "support/forged_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

std::string
hex(const Bytes& bytes)
{
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

/** \brief The header of a frame without its checksum, which is checked. */
std::string
headerOf(const Bytes& frame, std::size_t header_size, std::uint32_t reference)
{
  Bytes checked;
  ByteWriter(checked).u32(reference);
  checked.insert(checked.end(),
                 frame.begin() + static_cast<std::ptrdiff_t>(flags_offset),
                 frame.end());
  Bytes checksum;
  ByteWriter(checksum).u32(bitwiseCrc(checked));
  EXPECT_EQ(hex({frame.begin() + 5, frame.begin() + 9}), hex(checksum));
  return hex({frame.begin(), frame.begin() + 5}) + "........" +
         hex({frame.begin() + static_cast<std::ptrdiff_t>(flags_offset),
              frame.begin() + static_cast<std::ptrdiff_t>(header_size)});
}

/** \brief A number below 128 as it stands in a header. */
std::string
varint(std::size_t number)
{
  EXPECT_LT(number, 128u);
  return hex({static_cast<std::uint8_t>(number)});
}

TEST(FrameHeader, BytesAreThoseOfTheSpecification)
{
  VoxelFrame frame;
  frame.grid.resolution = 0.5;
  frame.grid.first_index = {-1, 2, -256};
  frame.grid.depth = 2;
  frame.keys = {0, 63};
  frame.intensities = {7, 255};
  FrameEncoder encoder(StreamFormat::Version1, 9, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  const Bytes i_frame = encoded(encoder, frame, FrameStamp{0x0102, "cam"});
  const std::size_t i_payload = i_frame.size() - encoder.statistics().header_bytes;
  EXPECT_EQ(headerOf(i_frame, encoder.statistics().header_bytes, 0),
            "5043584901........" // magic, version, checksum
            "1d01000000"         // I-frame, stamp, frame_id, balanced coder; its number
            "000000000000e03f"   // resolution
            "ffffffff0200000000ffffff02" // first index, depth
            "000000000000803f08"         // offset 0, step 1, 8 bits
            "02010000000000000363616d"   // stamp, frame_id
            "02" +
                varint(i_payload)); // voxels, bytes of the payload
  ASSERT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
  expectSameFrame(back, frame);

  // The same time, and the same frame_id, which is not sent again.
  const Bytes second = encoded(encoder, frame, FrameStamp{0x0102, "cam"});
  const std::size_t second_payload = second.size() - encoder.statistics().header_bytes;
  EXPECT_EQ(
      headerOf(second, encoder.statistics().header_bytes, takeApart(i_frame).checksum),
      "5043584901........"
      "1402000000" // P-frame, stamp
      "00"         // change of the stamp
      "02" +
          varint(second_payload));
  ASSERT_EQ(decoded(decoder, second, back), CompressionCode::Ok);

  // Back in time by 0x41, another frame_id.
  frame.keys = {0};
  frame.intensities = {9};
  const Bytes third = encoded(encoder, frame, FrameStamp{0xc1, "b"});
  const std::size_t third_payload = third.size() - encoder.statistics().header_bytes;
  EXPECT_EQ(
      headerOf(third, encoder.statistics().header_bytes, takeApart(second).checksum),
      "5043584901........"
      "1c03000000" // P-frame, stamp, frame_id
      "81010162"   // change of the stamp, frame_id
      "01" +
          varint(third_payload));
  ASSERT_EQ(decoded(decoder, third, back), CompressionCode::Ok);

  // Nothing at all.
  clearVoxels(frame);
  const Bytes fourth = encoded(encoder, frame);
  EXPECT_EQ(
      headerOf(fourth, encoder.statistics().header_bytes, takeApart(third).checksum),
      "5043584901........" // magic, version, checksum
      "1004000000"         // P-frame, its number
      "0000");             // no voxels, no payload
  EXPECT_EQ(fourth.size(), encoder.statistics().header_bytes);
  ASSERT_EQ(decoded(decoder, fourth, back), CompressionCode::Ok);
}

TEST(FrameHeader, CompandedScalesStoreTheirRange)
{
  VoxelFrame frame = emptyFrame(2);
  frame.intensity_scale = {1.0f, 0.5f, 4, 0x1234};
  FrameEncoder encoder(StreamFormat::Version1, 9, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  const Bytes bytes = encoded(encoder, frame);
  const std::string header = headerOf(bytes, encoder.statistics().header_bytes, 0);
  EXPECT_EQ(header.substr(header.size() - 26),
            "0000803f" // offset 1
            "0000003f" // step 1/2
            "843412"   // companded, 4 bits; the range
            "0000");   // no voxels, no payload
  ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
  EXPECT_EQ(back.intensity_scale, frame.intensity_scale);
}

TEST(FrameHeader, DepthModelsPrecedeThePayload)
{
  VoxelFrame frame = emptyFrame(4);
  DepthModel model;
  model.exponent = 1;
  model.full_symbol = 0x123456;
  model.origin = -2;
  model.step = {1, -1, 0x01020304};
  frame.depth_model = model;
  FrameEncoder encoder(StreamFormat::Version1, 9, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame back;
  const Bytes i_frame = encoded(encoder, frame);
  ASSERT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
  EXPECT_TRUE(back.depth_model == model);
  EXPECT_EQ(i_frame[flags_offset], 0x13);         // I-frame, depth model, balanced
  const std::string expected = "01"               // exponent
                               "56341200"         // full symbol
                               "feffffffffffffff" // origin
                               "01000000ffffffff04030201";
  EXPECT_EQ(hex(takeApart(i_frame).payload), expected);

  // On P-frames only if it changed.
  const Bytes second = encoded(encoder, frame);
  EXPECT_EQ(second[flags_offset], 0x10);
  EXPECT_TRUE(takeApart(second).payload.empty());
  ASSERT_EQ(decoded(decoder, second, back), CompressionCode::Ok);
  EXPECT_TRUE(back.depth_model == model);
  model.origin = 17;
  frame.depth_model = model;
  const Bytes third = encoded(encoder, frame);
  EXPECT_EQ(third[flags_offset], 0x12);
  EXPECT_EQ(takeApart(third).payload.size(), depth_model_size);
  ASSERT_EQ(decoded(decoder, third, back), CompressionCode::Ok);
  EXPECT_TRUE(back.depth_model == model);
  // It comes and goes with I-frames only.
  frame.depth_model.reset();
  const Bytes fourth = encoded(encoder, frame);
  EXPECT_EQ(fourth[flags_offset], 0x11);
  ASSERT_EQ(decoded(decoder, fourth, back), CompressionCode::Ok);
  EXPECT_FALSE(back.depth_model.has_value());
  frame.depth_model = model;
  EXPECT_EQ(encoded(encoder, frame)[flags_offset], 0x13);
}

// ---------------------------------------------------------------- sizes

TEST(FrameHeader, AnIFrameWithoutFrameIdClearsIt)
{
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  const Bytes named = encoded(encoder, emptyFrame(4), FrameStamp{5, "sensor"});
  Parts parts = takeApart(encoded(encoder, emptyFrame(4), FrameStamp{6, "sensor"}));
  parts.header.has_frame_id = false;
  FrameDecoder decoder;
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, named, back), CompressionCode::Ok);
  EXPECT_EQ(decoder.stamp()->frame_id, "sensor");
  ASSERT_EQ(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
  EXPECT_EQ(decoder.stamp()->frame_id, "");
  EXPECT_EQ(decoder.stamp()->stamp, 6u);
}

TEST(FrameHeader, HeadersAreShortWithAllFields)
{
  std::mt19937_64 random(10);
  // 20 Hz and 1 Hz in microseconds, two minutes of nothing, and a minute back.
  for (const std::int64_t change : {50000, 1000000, 120000000, -60000000})
    for (const std::size_t count : {0u, 1u, 50u, 20000u, 200000u}) {
      FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
      VoxelFrame frame = randomFrame(random, 21, count, 16);
      frame.depth_model.emplace();
      FrameStamp stamp{1700000000000000, std::string(16, 'x')};
      for (int i = 0; i < 3; ++i) {
        encoded(encoder, frame, stamp);
        EXPECT_EQ(encoder.statistics().is_i_frame, i == 0);
        EXPECT_LE(encoder.statistics().header_bytes, i == 0 ? 96u : 24u)
            << count << " voxels, change " << change;
        stamp.stamp += static_cast<std::uint64_t>(change);
      }
    }
}

} // namespace
