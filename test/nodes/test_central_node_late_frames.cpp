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

/** \brief A node with one stream, which is fed message by message. */
class LateFrames : public ::testing::Test {
protected:
  LateFrames() { node.addStream("a"); }

  void
  sendFrames(const CodedStream& stream, const std::vector<std::size_t>& indices)
  {
    for (const std::size_t index : indices)
      sendAndWait(node, "a", stream.frames.at(index));
  }

  StreamHealth
  health() const
  {
    return onlyHealth(node);
  }

  Listener listener;
  CentralNode node{centralSettings(), listener.listener()};
};

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
  const HeardFrame dropped = listener.heard("a").back();
  EXPECT_EQ(dropped.code, CompressionCode::OldFrame);
  EXPECT_EQ(dropped.voxels.size(), 0u);
  EXPECT_EQ(dropped.statistics.voxels, 0u);
  VoxelFrame latest;
  node.latestVoxels("a", latest);
  expectSameFrame(latest, stream.decoded[2]);
  EXPECT_TRUE(health().in_sync);
  sendFrames(stream, {3, 3, 4});
  EXPECT_EQ(listener.course("a"), "...d.d.");
  expectSameFrame(listener.heard("a").back().voxels, stream.decoded[4]);
  EXPECT_EQ(health().frames_received, 7u);
  EXPECT_EQ(health().frames_decoded, 5u);
  EXPECT_EQ(health().frames_dropped, 2u);
  EXPECT_EQ(health().frames_failed, 0u);
  EXPECT_EQ(health().i_frame_requests, 0u);
  EXPECT_TRUE(health().last_failure.ok());
}

TEST_F(LateFrames, AreNoneOfThoseThatAreMissing)
{
  const CodedStream stream = streamOf(12, 4);
  sendFrames(stream, {0, 1, 0, 1, /* 2, 3 */ 4, 5});
  EXPECT_EQ(listener.course("a"), "..dd..");
  EXPECT_EQ(health().frames_lost, 2u);
  // Nor are they found again when they come, as nobody can tell them from copies.
  sendFrames(stream, {2, 3, 6, /* 7 */ 8});
  EXPECT_EQ(listener.course("a"), "..dd..dd..");
  EXPECT_EQ(health().frames_lost, 3u);
}

TEST_F(LateFrames, NeitherMendAStreamNorBreakIt)
{
  const CodedStream stream = streamOf(9, 8);
  sendFrames(stream, {0, 1, /* 2 */ 3});
  EXPECT_FALSE(health().in_sync);
  sendFrames(stream, {1});
  EXPECT_FALSE(health().in_sync);
  // The requests for the frames that fail go on as if it had not come.
  sendFrames(stream, {4, 1, 5, 6, 8});
  EXPECT_EQ(listener.course("a"), "..idxdxi.");
  EXPECT_TRUE(health().in_sync);
  EXPECT_EQ(health().i_frame_requests, 2u);
}

TEST_F(LateFrames, ThreeInARowAskForAnIFrameAsOfASenderThatBeganAgain)
{
  const CodedStream first = streamOf(20);
  const CodedStream second = streamOf(13, 10, 2);
  sendFrames(first, numbersFrom(0, 20));
  sendFrames(second, numbersFrom(1, 13)); // its first I-frame is lost
  EXPECT_EQ(listener.course("a"), std::string(20, '.') + "ddDddDddD...");
  expectSameFrame(listener.heard("a").back().voxels, second.decoded[12]);
  EXPECT_EQ(health().frames_dropped, 9u);
  EXPECT_EQ(health().i_frame_requests, 3u);
  EXPECT_EQ(health().frames_lost, 0u);
}

TEST_F(LateFrames, ThatComeBetweenOthersAskForNothing)
{
  const CodedStream stream = streamOf(8);
  sendFrames(stream, {0, 1, 0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 4, 5});
  EXPECT_EQ(listener.course("a"), "..dd.dd.dd.dd.");
  EXPECT_EQ(health().i_frame_requests, 0u);
}

} // namespace
