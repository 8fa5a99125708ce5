// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/forged_frames.h"
#include "support/scripted_fast_payloads.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

using namespace fast;
using namespace rans;

using Choices = std::function<void(FastScript&)>;

/** \brief A stream whose I-frame is written choice by choice, and what follows it. */
class ScriptedStream {
public:
  ScriptedStream(unsigned int depth,
                 unsigned int bits,
                 std::size_t voxel_count,
                 const Choices& i_frame)
  {
    parts_.header.effort = Effort::Fast;
    parts_.header.grid = emptyFrame(depth).grid;
    parts_.header.intensity_scale.bits = bits;
    FastScript script;
    i_frame(script);
    RansChoices choices;
    choices.states = voxel_count < 1024 ? 1 : 4;
    i_frame_ = frame(true, voxel_count, script.rans(choices).bytes);
    reference_ = takeApart(i_frame_).checksum;
    models_ = script.models;
  }

  const Models&
  models() const
  {
    return models_;
  }

  const Bytes&
  iFrame() const
  {
    return i_frame_;
  }

  /** \brief A frame with a payload and a checksum that is right. */
  Bytes
  frame(bool is_i_frame, std::size_t voxel_count, const Bytes& payload) const
  {
    Parts parts = parts_;
    parts.header.is_i_frame = is_i_frame;
    parts.header.frame_number = reference_ == 0 ? 1 : 2;
    parts.header.voxel_count = voxel_count;
    parts.payload = payload;
    return putTogetherSized(parts, is_i_frame ? 0 : reference_);
  }

  Bytes
  pFrame(std::size_t voxel_count, const Choices& choices) const
  {
    FastScript script(models_);
    choices(script);
    return frame(false, voxel_count, script.rans().bytes);
  }

  Bytes
  otherIFrame(unsigned int depth,
              unsigned int bits,
              std::size_t voxel_count,
              const Bytes& payload) const
  {
    Parts parts = takeApart(frame(true, voxel_count, payload));
    parts.header.grid = emptyFrame(depth).grid;
    parts.header.intensity_scale.bits = bits;
    return putTogether(parts);
  }

  /** \brief Sets a valid P-frame, which must be decoded after each invalid one. */
  void
  setGenuine(const Bytes& bytes)
  {
    genuine_ = bytes;
    FrameDecoder decoder;
    ASSERT_EQ(decoded(decoder, i_frame_, expected_), CompressionCode::Ok);
    ASSERT_EQ(decoded(decoder, bytes, expected_), CompressionCode::Ok);
  }

  CompressionCode
  answerTo(const Bytes& bytes) const
  {
    return test::answerTo(bytes, i_frame_, {genuine_}, {expected_});
  }

private:
  Parts parts_;
  Bytes i_frame_;
  std::uint32_t reference_ = 0;
  Models models_;
  Bytes genuine_;
  VoxelFrame expected_;
};

/** \brief A P-frame and the code that a decoder answers with. */
struct ScriptedFrame {
  std::string name;
  std::size_t voxels;
  Choices choices;
  CompressionCode answer = CompressionCode::Corrupt;
};

inline void
expectAnswers(const ScriptedStream& stream, const std::vector<ScriptedFrame>& cases)
{
  for (const ScriptedFrame& some : cases) {
    SCOPED_TRACE(some.name);
    EXPECT_EQ(stream.answerTo(stream.pFrame(some.voxels, some.choices)), some.answer);
  }
}

inline std::set<std::uint64_t>
keysOf(std::uint64_t block, std::uint64_t cells)
{
  std::set<std::uint64_t> keys;
  for (unsigned int cell = 0; cell < block_cells; ++cell)
    if ((cells >> cell & 1) != 0)
      keys.insert(block << block_key_bits | cell);
  return keys;
}

/** \brief Two blocks of a grid of eight, without intensities: block 2 has cell 0 and
 * cell 9, block 5 the whole octant 3. */
inline ScriptedStream
streamOfTwoBlocks()
{
  ScriptedStream stream(3, 0, 10, [](FastScript& script) {
    std::set<std::uint64_t> keys = keysOf(2, 1 | 1 << 9);
    keys.merge(keysOf(5, 0xff000000));
    script.newVoxels(3, keys);
  });
  stream.setGenuine(stream.pFrame(10, [](FastScript& script) {
    script.trackedVoxels(3, 10, 0x3ff);
    script.octants(false, 0);
    script.octants(false, 0);
    script.noNewBlocks();
  }));
  return stream;
}

/** \brief The I-frame of all voxels of a grid, except for the symbols. */
inline void
writeFullGrid(FastScript& script, unsigned int depth)
{
  std::set<std::uint64_t> keys;
  for (std::uint64_t key = 0; key < std::uint64_t{1} << 3 * depth; ++key)
    keys.insert(key);
  script.newVoxels(depth, keys);
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
