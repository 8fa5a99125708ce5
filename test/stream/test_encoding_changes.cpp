// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/voxel_changes.h>

#include "stream/frame_encoder.h"
#include "support/changing_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

using Bytes = std::vector<std::uint8_t>;

class EncodingChanges
: public ::testing::TestWithParam<std::tuple<Effort, unsigned int>> {
protected:
  static FrameEncoder
  encoder()
  {
    constexpr unsigned int i_frame_rate = 20;
    return {StreamFormat::Version1, i_frame_rate, std::get<0>(GetParam())};
  }

  /** \brief Whether the next frame is encoded by its changes; all bytes are compared. */
  bool
  encodeNext(unsigned int changes_of_frame)
  {
    const VoxelFrame frame = frames_.next(changes_of_frame);
    findChanges(last_, frame, changes_);
    changes_.is_from_nothing = last_.keys.empty();
    Bytes bytes;
    const auto status = by_changes_.encode(changes_, std::nullopt, bytes);
    if (status)
      EXPECT_TRUE(status->ok());
    else
      EXPECT_TRUE(by_changes_.encode(frame, std::nullopt, bytes).ok());
    EXPECT_EQ(bytes, encoded(whole_, frame));
    EXPECT_EQ(by_changes_.statistics().voxels, frame.size());
    EXPECT_EQ(status.has_value(), whole_.statistics().is_of_changes);
    last_ = frame;
    return status.has_value();
  }

  ChangingFrames frames_{std::get<1>(GetParam())};
  VoxelFrame last_;
  VoxelChanges changes_;
  FrameEncoder by_changes_ = encoder();
  FrameEncoder whole_ = encoder();
};

TEST_P(EncodingChanges, HasTheBytesOfAllVoxels)
{
  std::size_t by_changes = 0;
  for (std::size_t i = 0; i < 60; ++i)
    by_changes += encodeNext(i % 7 == 6 ? 900 : 12) ? 1 : 0;
  EXPECT_GT(by_changes, 10u);
  EXPECT_LT(by_changes, 57u);
}

TEST_P(EncodingChanges, OfAnotherFrameAreRefused)
{
  while (!encodeNext(12)) {
  }
  const VoxelFrame none = emptyFrame(ChangingFrames::depth, std::get<1>(GetParam()));
  VoxelFrame one = none;
  one.keys = {last_.keys[7]};
  one.intensities.assign(std::get<1>(GetParam()) > 0 ? 1 : 0, 0);
  VoxelFrame other = one;
  other.keys = {last_.keys.back() + 1};
  Bytes bytes;
  const auto is_refused = [&](const VoxelFrame& gone, const VoxelFrame& came) {
    return !by_changes_.encode(VoxelChanges{gone, came}, std::nullopt, bytes) &&
           bytes.empty();
  };
  EXPECT_TRUE(is_refused(other, none)); // is not there
  EXPECT_TRUE(is_refused(none, one));   // is there
  if (one.hasIntensities())
    one.intensities[0] = last_.intensities[7];
  EXPECT_TRUE(is_refused(one, one)); // stays as it is
  other.grid.first_index[0] += 1;
  EXPECT_TRUE(is_refused(other, other)); // of another grid
  // The stream goes on as if they had not been there.
  EXPECT_TRUE(encodeNext(12));
}

INSTANTIATE_TEST_SUITE_P(
    Of,
    EncodingChanges,
    ::testing::Combine(::testing::Values(Effort::Fast, Effort::Balanced, Effort::Small),
                       ::testing::Values(0u, 8u)));

} // namespace
