/** \file
 * \brief A replayed recording gives the voxels of the live stream.
 */
#include "stream_scenario.h"

#include <map>

namespace pcl_ext_ros1 {
namespace test {

namespace {

class Bags : public StreamScenario {
protected:
  Bags()
  : bag(temporaryFolder() + space + ".bag")
  , replayed(full("replayed"))
  , replayed_voxels(replayed + "/voxels")
  {}

  /** \brief Starts to record the compressed frames. */
  void
  startRecording()
  {
    const std::size_t others = compressor->subscribersOf(compressed);
    recording.emplace(
        std::vector<std::string>{"rosbag", "record", "-O", bag, compressed});
    compressor->expectSubscribers(compressed, others + 1);
  }

  /** \brief Completes the recording and ends both nodes. */
  void
  stopAll()
  {
    EXPECT_EQ(recording->interrupt(), 0) << recording->output();
    EXPECT_EQ(compressor->interrupt(), 0);
    EXPECT_EQ(decompressor->interrupt(), 0);
  }

  /** \brief Plays the recording to a new decompressor. */
  void
  replay(std::size_t expected_voxels)
  {
    NodeProcess fresh("intensity_decompressor",
                      full("fresh_decompressor"),
                      {{"streams", listOf({replayed})}});
    fresh.expectSubscribers(replayed_voxels.topic(), 1);
    ChildProcess player({"rosbag",
                         "play",
                         "--quiet",
                         "--wait-for-subscribers",
                         bag,
                         compressed + ":=" + replayed});
    EXPECT_EQ(player.waitForExit(seconds_to_wait), 0) << player.output();
    EXPECT_TRUE(replayed_voxels.waitForCount(expected_voxels)) << fresh.output();
  }

  static std::map<std::uint64_t, Voxels>
  byStamp(const Recorder<sensor_msgs::PointCloud2>& recorder)
  {
    std::map<std::uint64_t, Voxels> voxels;
    for (const auto& message : recorder.messages())
      voxels[message->header.stamp.toNSec()] = voxelsIn(*message);
    return voxels;
  }

  const std::string bag;
  const std::string replayed;
  Recorder<sensor_msgs::PointCloud2> replayed_voxels;
  std::optional<ChildProcess> recording;
};

TEST_F(Bags, ReplayGivesTheVoxelsOfTheLiveStream)
{
  startBoth({{"i_frame_rate", 8}});
  startRecording();
  constexpr std::uint32_t count = 20;
  expectClouds(0, count);
  stopAll();
  replay(count);
  EXPECT_EQ(replayed_voxels.count(), count);
  EXPECT_TRUE(byStamp(replayed_voxels) == byStamp(voxels));
}

TEST_F(Bags, RecordingFromTheMiddleOfAStreamIsInSyncWithinTwoFrames)
{
  startBoth({{"i_frame_rate", 1000000}});
  constexpr std::uint32_t first_recorded = 6;
  constexpr std::uint32_t count = 16;
  std::uint32_t number = 0;
  for (; number < first_recorded; ++number)
    ASSERT_TRUE(show(cloud(number)));
  startRecording();
  for (; number < count; ++number)
    ASSERT_TRUE(show(cloud(number)));
  stopAll();
  replay(count - first_recorded - 1);
  const auto live = byStamp(voxels);
  const auto again = byStamp(replayed_voxels);
  for (std::uint32_t i = first_recorded + 1; i < count; ++i)
    EXPECT_EQ(again.count(stampOf(i).toNSec()), 1u) << i;
  for (const auto& [stamp, shown] : again)
    EXPECT_TRUE(shown == live.at(stamp));
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
