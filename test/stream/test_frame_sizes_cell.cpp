// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/labelled_stream.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::noise::LabelledFrame;
using pcl_ext::noise::LabelledStream;

// From fine voxels, of which most hold one point, to coarse ones with dozens in which
// it costs nothing to learn no voxel's count in the I-frame, but much after it.
TEST(FrameSizesOfTheCell, FastIsAnEighthLargerThanBalancedAtMost)
{
  for (const double resolution : {0.04, 0.1, 0.16, 0.19, 0.3, 0.5}) {
    LabelledStream stream(1, 1, resolution); // of sensor 1
    LabelledFrame frame;
    FrameEncoder balanced_encoder(StreamFormat::Version1, 30, Effort::Balanced);
    FrameEncoder fast_encoder(StreamFormat::Version1, 30, Effort::Fast);
    std::size_t balanced = 0;
    std::size_t fast = 0;
    for (std::uint32_t number = 0; number < 30; ++number) {
      stream.read(number, frame);
      const VoxelFrame& voxels = frame.of(pcl_ext::noise::Law::Count);
      balanced += encoded(balanced_encoder, voxels).size();
      fast += encoded(fast_encoder, voxels).size();
    }
    EXPECT_GT(fast, balanced) << resolution;
    EXPECT_LT(8 * fast, 9 * balanced) << resolution;
  }
}

} // namespace
