// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/depth_split.h"
#include "codec/rans/classed_row.h"
#include "support/forged_frames.h"
#include "support/scripted_fast_payloads.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

using Numbers = std::vector<std::uint16_t>;

/** \brief A frame of voxels of one or two points, of which one is worth more the larger
 * x is, so that a depth model saves bytes. */
VoxelFrame
frameOfPoints(std::mt19937_64& random)
{
  VoxelFrame frame = emptyFrame(4);
  frame.depth_model.emplace();
  frame.depth_model->exponent = 1;
  frame.depth_model->full_symbol = 110 << 8;
  frame.depth_model->origin = std::int64_t{1} << 30;
  frame.depth_model->step = {3 << 26, 0, 0};
  std::set<std::uint64_t> keys;
  for (std::uint64_t i = 0; i < 300; ++i)
    keys.insert(below(random, 16) == 0 ? below(random, 4096) : 13 * i);
  for (const std::uint64_t key : keys) {
    const std::uint64_t point = frame.depth_model->pointSymbol(voxelPosition(key));
    frame.keys.push_back(key);
    frame.intensities.push_back(static_cast<std::uint16_t>(
        (((1 + key % 2) * point) >> 16) + below(random, 3) - below(random, 2)));
  }
  return frame;
}

struct SplitPayload {
  Bytes model; ///< none in P-frames
  Bytes numbers;
  Bytes residuals;

  SplitPayload() = default;

  explicit SplitPayload(const Parts& parts)
  {
    const std::size_t size = parts.header.has_depth_model ? depth_model_size : 0;
    MemoryBuffer buffer(parts.payload.data() + size, parts.payload.size() - size);
    ByteSource source(buffer, parts.payload.size());
    const auto numbers_size = static_cast<std::ptrdiff_t>(source.varint());
    const auto begin = parts.payload.begin();
    const auto numbers_begin =
        begin + static_cast<std::ptrdiff_t>(size + source.consumed());
    model.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
    numbers.assign(numbers_begin, numbers_begin + numbers_size);
    residuals.assign(numbers_begin + numbers_size, parts.payload.end());
  }

  Bytes
  together(std::uint64_t numbers_size) const
  {
    Bytes payload = model;
    ByteWriter(payload).varint(numbers_size);
    append(numbers, payload);
    append(residuals, payload);
    return payload;
  }

  Bytes
  together() const
  {
    return together(numbers.size());
  }
};

/** \brief The residuals of a frame and their classes, as the effort fast has them. */
struct Residuals {
  Numbers numbers;
  std::vector<std::uint8_t> classes;

  explicit Residuals(const VoxelFrame& frame)
  {
    BlockList blocks;
    blocks.assign(frame.keys);
    DepthSplit split;
    split.begin(*frame.depth_model, blocks, {}, frame.intensity_scale.maxSymbol());
    Numbers points;
    split.baseSymbolsOf(frame.intensities, points);
    split.predict(points);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::uint32_t size =
          std::clamp(split.predictionContext(i) >> 4, 4u, 7u) - 4;
      classes.push_back(
          static_cast<std::uint8_t>(size * 4 + (split.predictionContext(i) >> 2 & 3)));
      numbers.push_back(
          static_cast<std::uint16_t>(split.residual(i, frame.intensities[i])));
    }
  }
};

struct Stream {
  std::vector<VoxelFrame> frames;
  std::vector<Bytes> bytes;
  std::vector<Parts> parts;

  Stream()
  {
    std::mt19937_64 random(1);
    FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Fast);
    for (std::size_t i = 0; i < 3; ++i) {
      frames.push_back(frameOfPoints(random));
      bytes.push_back(encoded(encoder, frames[i]));
      parts.push_back(takeApart(bytes[i]));
      EXPECT_EQ(parts[i].header.is_i_frame, i == 0);
      EXPECT_EQ(parts[i].header.has_depth_model, i == 0);
    }
  }

  Bytes
  forged(Parts some, const Bytes& payload) const
  {
    some.header.frame_number = parts[1].header.frame_number;
    some.payload = payload;
    return putTogetherSized(some, some.header.is_i_frame ? 0 : parts[0].checksum);
  }

  CompressionCode
  answerTo(const Bytes& forgery) const
  {
    return pcl_ext::io::test::answerTo(
        forgery, bytes[0], {bytes[1], bytes[2]}, {frames[1], frames[2]});
  }
};

TEST(ScriptedResiduals, InvalidSymbolsAreRefused)
{
  const Stream stream;
  for (const bool is_i_frame : {false, true}) {
    const std::size_t like = is_i_frame ? 0 : 1;
    const Residuals genuine(stream.frames[like]);
    const SplitPayload payload(stream.parts[like]);
    const auto answer = [&](const Numbers& residuals) {
      ClassedRow row;
      Bytes before;
      const Residuals first(stream.frames[0]);
      if (!is_i_frame)
        row.encode(true, first.numbers, first.classes, before);
      SplitPayload forged = payload;
      forged.residuals.clear();
      row.encode(is_i_frame, residuals, genuine.classes, forged.residuals);
      return stream.answerTo(stream.forged(stream.parts[like], forged.together()));
    };
    EXPECT_EQ(answer(genuine.numbers), CompressionCode::Ok);
    // Others than the stream's, so that what they teach would be noticed.
    Numbers residuals(genuine.numbers.size(), 14);
    EXPECT_EQ(answer(residuals), CompressionCode::Ok);
    for (const unsigned int wrong : {509u, 510u, 511u, 65535u})
      for (const std::size_t at : {std::size_t{0}, residuals.size() - 1}) {
        Numbers some = residuals;
        some[at] = static_cast<std::uint16_t>(wrong);
        EXPECT_EQ(answer(some), CompressionCode::Corrupt) << wrong;
      }
  }
}

TEST(ScriptedResiduals, OtherBytesAreRefused)
{
  const Stream stream;
  for (const std::size_t like : {0u, 1u}) {
    const SplitPayload payload(stream.parts[like]);
    const auto answer = [&](const Bytes& bytes) {
      return stream.answerTo(stream.forged(stream.parts[like], bytes));
    };
    EXPECT_EQ(answer(payload.together()), CompressionCode::Ok);
    for (const int more : {-2, -1, 1, 2, 4}) {
      SplitPayload forged = payload;
      forged.residuals.resize(payload.residuals.size() +
                              static_cast<std::size_t>(more));
      EXPECT_EQ(answer(forged.together()), CompressionCode::Corrupt);
    }
    const std::size_t size = payload.numbers.size();
    const std::size_t residuals = payload.residuals.size();
    for (const std::uint64_t wrong : {std::uint64_t{0},
                                      std::uint64_t{size - 1},
                                      std::uint64_t{size + 1},
                                      std::uint64_t{size + residuals},
                                      std::uint64_t{size + residuals + 1},
                                      std::uint64_t{size + residuals + 2},
                                      std::uint64_t{size} << 32,
                                      ~std::uint64_t{0} - 5,
                                      ~std::uint64_t{0}})
      EXPECT_EQ(answer(payload.together(wrong)), CompressionCode::Corrupt) << wrong;
    Bytes unfinished = payload.model;
    unfinished.push_back(0x80);
    EXPECT_EQ(answer(unfinished), CompressionCode::Corrupt);
    EXPECT_EQ(answer(payload.model), CompressionCode::Corrupt);
  }
}

TEST(ScriptedResiduals, NumbersOfARowHaveSixteenBits)
{
  // A voxel of one point that is worth 40000.
  Parts parts;
  parts.header.effort = Effort::Fast;
  parts.header.has_depth_model = true;
  parts.header.grid = emptyFrame(2).grid;
  parts.header.intensity_scale.bits = 16;
  parts.header.frame_number = 1;
  parts.header.voxel_count = 1;
  DepthModel model;
  model.exponent = 1;
  model.full_symbol = 40000 << 8;
  model.origin = std::int64_t{1} << 32;
  model.step = {0, 0, 0};
  SplitPayload payload;
  writeDepthModel(model, payload.model);
  FastScript numbers;
  numbers.newVoxels(2, {0});
  numbers.beginSteps();
  numbers.newStep(1);
  payload.numbers = numbers.rans().bytes;
  const auto answer = [&](std::uint32_t residual) {
    FastScript script;
    NibbleModel number;
    NibbleModel length;
    const std::uint32_t above = residual - 14; // 2^15 or more
    script.code(number, 15);
    script.code(length, 15);
    script.bits(7, above >> 8 & 127);
    script.bits(8, above & 255);
    payload.residuals = script.rans().bytes;
    parts.payload = payload.together();
    FrameDecoder decoder;
    VoxelFrame back;
    return decoded(decoder, putTogetherSized(parts), back);
  };
  EXPECT_EQ(answer(65533), CompressionCode::Ok); // symbol 7233
  EXPECT_EQ(answer(65535), CompressionCode::Ok);
  for (const std::uint32_t residual : {65536u, 65537u, 65549u})
    EXPECT_EQ(answer(residual), CompressionCode::Corrupt) << residual;
}

} // namespace
