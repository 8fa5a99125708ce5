// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/depth_split.h"
#include "support/forged_frames.h"
#include "support/scripted_context_payloads.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using namespace pcl_ext::io::test;

using Numbers = std::vector<std::uint16_t>;
using Choices = std::function<void(ContextScript&)>;

class Stream {
public:
  Stream(unsigned int depth, const std::vector<std::uint64_t>& keys)
  : expected_(emptyFrame(depth))
  {
    expected_.keys = keys;
    expected_.intensities.assign(keys.size(), 3);
    i_frame_ = genuine(true);
    reference_ = takeApart(i_frame_).checksum;
    p_frame_ = genuine(false);
  }

  Bytes
  frame(const VoxelFrame& like,
        bool is_i_frame,
        std::size_t voxel_count,
        const Bytes& payload) const
  {
    Parts parts;
    parts.header.is_i_frame = is_i_frame;
    parts.header.effort = Effort::Balanced;
    parts.header.grid = like.grid;
    parts.header.intensity_scale = like.intensity_scale;
    parts.header.frame_number = reference_ == 0 ? 1 : 2;
    parts.header.voxel_count = voxel_count;
    if (like.depth_model) {
      parts.header.has_depth_model = true;
      writeDepthModel(*like.depth_model, parts.payload);
    }
    append(payload, parts.payload);
    return putTogetherSized(parts, is_i_frame ? 0 : reference_);
  }

  CompressionCode
  answerToPFrame(std::size_t voxel_count, const Choices& choices) const
  {
    ContextScript script(before_p_frame_, expected_);
    choices(script);
    return answerTo(frame(expected_, false, voxel_count, script.finish()));
  }

  /** \brief The answer to an I-frame that has some of an octant's first voxels. */
  CompressionCode
  answerToIFrame(const VoxelFrame& like, const Choices& choices) const
  {
    ContextScript script(ContextState(), like);
    script.occupancy(blocksOf(like.keys));
    choices(script);
    return answerTo(frame(like, true, like.size(), script.finish()));
  }

private:
  Bytes
  genuine(bool is_i_frame)
  {
    const BlockList blocks = blocksOf(expected_.keys);
    ContextScript script(before_p_frame_, expected_);
    EXPECT_TRUE(script.occupancy(blocks));
    script.numbers(blocks, expected_.intensities);
    const Bytes payload = script.finish(blocks, expected_.intensities);
    if (is_i_frame)
      before_p_frame_ = script.state;
    return frame(expected_, is_i_frame, expected_.size(), payload);
  }

  CompressionCode
  answerTo(const Bytes& bytes) const
  {
    return pcl_ext::io::test::answerTo(bytes, i_frame_, {p_frame_}, {expected_});
  }
  VoxelFrame expected_;
  ContextState before_p_frame_;
  Bytes i_frame_;
  Bytes p_frame_;
  std::uint32_t reference_ = 0;
};

constexpr CompressionCode ok = CompressionCode::Ok;
constexpr CompressionCode corrupt = CompressionCode::Corrupt;

TEST(ScriptedContextPayloads, ANewBlockThatIsTracked)
{
  // The one block of a grid. Said to be new, it has the voxel below the tracked one:
  // the keys ascend.
  const Stream stream(2, {5});
  EXPECT_EQ(stream.answerToPFrame(2,
                                  [&](ContextScript& script) {
                                    EXPECT_FALSE(script.occupancyWithNewBlock(
                                        blocksOf({5}), 0, 1 << 3));
                                    script.newVoxel(3);
                                    script.numbers(blocksOf({3, 5}), {3, 3});
                                  }),
            corrupt);
  // A tracked one that has it.
  EXPECT_EQ(stream.answerToPFrame(2,
                                  [&](ContextScript& script) {
                                    const BlockList both = blocksOf({3, 5});
                                    EXPECT_TRUE(script.occupancy(both));
                                    script.numbers(both, {3, 3});
                                  }),
            ok);
}

TEST(ScriptedContextPayloads, NewBlocksWhereAllAreTracked)
{
  std::vector<std::uint64_t> keys;
  for (std::uint64_t block = 0; block < 8; ++block)
    keys.push_back(64 * block);
  const BlockList blocks = blocksOf(keys);
  const Stream stream(3, keys);
  const auto answer = [&](bool are_new) {
    return stream.answerToPFrame(8, [&](ContextScript& script) {
      if (are_new)
        EXPECT_FALSE(script.occupancyWithNewBlock(blocks, 7, 1 << 3));
      else
        EXPECT_TRUE(script.occupancy(blocks));
      script.numbers(blocks, Numbers(8, 3));
    });
  };
  EXPECT_EQ(answer(false), ok);
  EXPECT_EQ(answer(true), corrupt);
}

TEST(ScriptedContextPayloads, OtherNumbersOfVoxels)
{
  const Stream stream(3, {64 * 7 + 5});
  for (const std::size_t count : {1u, 2u, 3u, 4u, 5u, 100u}) {
    EXPECT_EQ(stream.answerToPFrame(count,
                                    [&](ContextScript& script) {
                                      const BlockList blocks = blocksOf({2, 66, 453});
                                      script.occupancy(blocks);
                                      script.numbers(blocks,
                                                     Numbers(blocks.voxelCount(), 3));
                                    }),
              count == 3 ? ok : corrupt);
  }
}

DepthModel
modelOfPoints(std::uint32_t symbol)
{
  DepthModel model;
  model.exponent = 1;
  model.full_symbol = symbol << 8;
  model.origin = std::int64_t{1} << 32;
  model.step = {0, 0, 0};
  return model;
}

/** \brief I-frames of one voxel of one point, with a residual. */
class ResidualPayload {
public:
  ResidualPayload(unsigned int bits, std::uint16_t point_symbol)
  : like_(emptyFrame(3, bits))
  {
    like_.keys = {0};
    like_.depth_model = modelOfPoints(point_symbol);
    DepthSplit split;
    split.begin(*like_.depth_model,
                blocksOf(like_.keys),
                {},
                like_.intensity_scale.maxSymbol());
    split.predict({1});
    EXPECT_EQ(split.residual(0, point_symbol), 0u);
    class_ = split.classes()[0];
  }

  /** \param[in] end first decision of the residual that is a no; 32: an escape
   * follows */
  CompressionCode
  answer(std::uint32_t end, const Choices& escape) const
  {
    return stream_.answerToIFrame(like_, [&](ContextScript& script) {
      script.numbers(blocksOf(like_.keys), {1});
      script.unary(script.state.intensity.residual,
                   class_ * IntensityContexts::longest_residual,
                   0,
                   end,
                   IntensityContexts::longest_residual);
      escape(script);
    });
  }

private:
  const Stream stream_{3, {64 * 7 + 5}};
  VoxelFrame like_;
  std::uint32_t class_ = 0;
};

Choices
escapedResidual(std::uint32_t residual)
{
  return [=](ContextScript& script) { script.escape(residual - 32); };
}

TEST(ScriptedContextPayloads, ResidualsOutOfRange)
{
  const ResidualPayload payload(8, 100);
  EXPECT_EQ(payload.answer(31, [](auto&) {}), ok);
  EXPECT_EQ(payload.answer(32, escapedResidual(199)), ok);      // symbol 0
  EXPECT_EQ(payload.answer(32, escapedResidual(201)), corrupt); // -1
  EXPECT_EQ(payload.answer(32, escapedResidual(310)), ok);      // 255
  EXPECT_EQ(payload.answer(32, escapedResidual(312)), corrupt); // 256
  for (const std::uint32_t large : {509u, 511u, 512u, 65535u, 65536u + 20, 131000u})
    EXPECT_EQ(payload.answer(32, escapedResidual(large)), corrupt) << large;
  EXPECT_EQ(payload.answer(32, [](auto& script) { script.longEscape(); }), corrupt);
}
TEST(ScriptedContextPayloads, ResidualsOfSeventeenBits)
{
  // The longest escape: of a symbol 0 where 40000 was expected.
  const ResidualPayload payload(16, 40000);
  EXPECT_EQ(payload.answer(32, escapedResidual(79999)), ok);
  EXPECT_EQ(payload.answer(32, escapedResidual(80001)), corrupt);
}
} // namespace
