#include "simulator/labelled_stream.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::noise::LabelledFrame;
using pcl_ext::noise::LabelledStream;

/** \brief Bytes of the robot cell's sensor 1, an I-frame and those that depend on
 * it. */
std::size_t
bytesOfCell(double resolution, Effort effort)
{
  LabelledStream stream(1, 1, resolution);
  LabelledFrame frame;
  FrameEncoder encoder(StreamFormat::Version1, 30, effort);
  std::size_t bytes = 0;
  for (std::uint32_t number = 0; number < 30; ++number) {
    stream.read(number, frame);
    bytes += encoded(encoder, frame.of(pcl_ext::noise::Law::Count)).size();
  }
  return bytes;
}

// From fine voxels, of which most hold one point, to coarse ones with dozens in which
// it costs nothing to learn no voxel's count in the I-frame, but much after it.
TEST(FrameSizesOfTheCell, FastIsAnEighthLargerThanBalancedAtMost)
{
  for (const double resolution : {0.04, 0.1, 0.16, 0.19, 0.3, 0.5}) {
    const std::size_t balanced = bytesOfCell(resolution, Effort::Balanced);
    const std::size_t fast = bytesOfCell(resolution, Effort::Fast);
    EXPECT_GT(fast, balanced) << resolution;
    EXPECT_LT(8 * fast, 9 * balanced) << resolution;
  }
}

} // namespace
