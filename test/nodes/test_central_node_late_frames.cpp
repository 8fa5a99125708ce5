/** \file
 * \brief Frames that a CentralNode receives late or twice.
 */
#include <pcl_ext/nodes/central_node.h>

#include "support/central_streams.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using pcl_ext::io::test::expectSameFrame;

using LateFrames = OneStream;

std::vector<std::size_t>
numbersFrom(std::size_t first, std::size_t end)
{
  std::vector<std::size_t> numbers(end - first);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

TEST_F(LateFrames, AreDroppedAndTheStreamGoesOn)
{
  const CodedStream stream = streamOf(5);
  sendFrames(stream, {0, 1, 2, 1});
  const RecordedFrame dropped = recorder.frames("a").back();
  EXPECT_EQ(dropped.code, CompressionCode::OldFrame);
  EXPECT_EQ(dropped.voxels.size(), 0u);
  EXPECT_EQ(dropped.statistics.voxels, 0u);
  expectSameFrame(latestVoxels(node), stream.decoded[2]);
  EXPECT_TRUE(onlyHealth(node).in_sync);
  sendFrames(stream, {3, 3, 4});
  expectSameFrame(recorder.frames("a").back().voxels, stream.decoded[4]);
  expectCounts("...d.d.", 0);
  EXPECT_TRUE(onlyHealth(node).last_failure.ok());
}

TEST_F(LateFrames, AreNotCountedAsFoundOrLost)
{
  const CodedStream stream = streamOf(12, 4);
  sendFrames(stream, {0, 1, 0, 1, /* 2, 3 */ 4, 5});
  expectCounts("..dd..", 2);
  // Missing frames that come late look like copies, and stay lost.
  sendFrames(stream, {2, 3, 6, /* 7 */ 8});
  expectCounts("..dd..dd..", 3);
}

TEST_F(LateFrames, NeitherResumeAStreamNorBreakIt)
{
  const CodedStream stream = streamOf(9, 8);
  sendFrames(stream, {0, 1, /* 2 */ 3});
  EXPECT_FALSE(onlyHealth(node).in_sync);
  sendFrames(stream, {1});
  EXPECT_FALSE(onlyHealth(node).in_sync);
  // The requests for the frames that fail go on as if it had not come.
  sendFrames(stream, {4, 1, 5, 6, 8});
  expectCounts("..idxdxi.", 2);
  EXPECT_TRUE(onlyHealth(node).in_sync);
}

TEST_F(LateFrames, ThreeInARowRequestAnIFrame)
{
  const CodedStream first = streamOf(20);
  const CodedStream second = streamOf(13, 10, 2);
  sendFrames(first, numbersFrom(0, 20));
  sendFrames(second, numbersFrom(1, 13)); // its first I-frame is lost
  expectCounts(std::string(20, '.') + "ddDddDddD...", 0);
  expectSameFrame(recorder.frames("a").back().voxels, second.decoded[12]);
}

TEST_F(LateFrames, BetweenOtherFramesRequestNothing)
{
  const CodedStream stream = streamOf(8);
  sendFrames(stream, {0, 1, 0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 4, 5});
  expectCounts("..dd.dd.dd.dd.", 0);
}

} // namespace
