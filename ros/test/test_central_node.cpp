/** \file
 * \brief Many streams in one node, their sum, and the threshold of noise.
 */
#include "stream_scenario.h"

#include <ros/param.h>

#include <algorithm>

namespace pcl_ext_ros {
namespace test {

namespace {

XmlRpc::XmlRpcValue
streamEntry(const std::string& topic, double min_intensity)
{
  XmlRpc::XmlRpcValue entry;
  entry["topic"] = topic;
  entry["min_intensity"] = min_intensity;
  return entry;
}

Voxels
sorted(Voxels voxels)
{
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

/** \brief A second sensor beside that of the scenario. */
class CentralNodes : public StreamScenario {
protected:
  CentralNodes()
  : other_frame("other_" + sensor_frame)
  , other_pose(samplePose(1.0))
  , other_clouds(node.advertise<sensor_msgs::PointCloud2>(full("other"), 100))
  , other_frames(full("other/pcl_ext"))
  , other_voxels(full("other/pcl_ext/voxels"))
  , merged(full("decompressor/merged"))
  {}

  void
  startTwoSensors(const Parameters& decompressor_parameters)
  {
    transforms.set(sensor_frame, pose);
    transforms.set(other_frame, other_pose);
    startCompressor();
    other_compressor.emplace("intensity_compressor",
                             full("other_compressor"),
                             compressorParameters(),
                             std::vector<std::string>{"input:=other"});
    ASSERT_TRUE(waitFor([this] { return other_clouds.getNumSubscribers() == 1; }));
    startDecompressor(
        Parameters{{"streams", listOf({compressed, other_frames.topic()})}} +
        decompressor_parameters);
    ASSERT_TRUE(waitForSubscribers(other_compressor->name(), other_frames.topic(), 2));
    ASSERT_TRUE(waitForSubscribers(decompressor->name(), other_voxels.topic(), 1));
    ASSERT_TRUE(waitForSubscribers(decompressor->name(), merged.topic(), 1));
  }

  sensor_msgs::PointCloud2
  otherCloud(std::uint32_t number) const
  {
    return makeCloud<pcl::PointXYZI>(number + 77, other_frame, 4000);
  }

  /** \brief Waits until the sum of the streams is this; the order of its voxels depends on
   * its grid, and that on what was merged before. */
  bool
  waitForMerged(const Voxels& expected)
  {
    return waitFor([&] {
      const auto last = merged.last();
      return last && sorted(voxelsIn(*last)) == sorted(expected);
    });
  }

  const std::string other_frame;
  const pcl_ext::WorldPose other_pose;
  ros::Publisher other_clouds;
  Recorder<CompressedPointCloud2> other_frames;
  Recorder<sensor_msgs::PointCloud2> other_voxels;
  Recorder<sensor_msgs::PointCloud2> merged;
  std::optional<NodeProcess> other_compressor;
  DirectStream direct{compressorSettings()};
  DirectStream other_direct{compressorSettings()};
};

TEST_F(CentralNodes, TwoStreamsAreEachTheLibrarysAndSoIsTheirSum)
{
  startTwoSensors({{"max_merge_age", 3600.0}, {"resolution", 0.08}});
  for (std::uint32_t i = 0; i < 6; ++i) {
    // Both wait in the node at the same time.
    clouds.publish(cloud(i));
    other_clouds.publish(otherCloud(i));
    ASSERT_TRUE(voxels.waitForCount(i + 1)) << decompressor->output();
    ASSERT_TRUE(other_voxels.waitForCount(i + 1)) << decompressor->output();
    EXPECT_TRUE(voxelsIn(*voxels[i]) == direct.voxelsOf(cloud(i), pose));
    EXPECT_TRUE(voxelsIn(*other_voxels[i]) ==
                other_direct.voxelsOf(otherCloud(i), other_pose));
    EXPECT_EQ(voxels[i]->header.stamp, cloud(i).header.stamp);
    EXPECT_EQ(other_voxels[i]->header.stamp, otherCloud(i).header.stamp);

    DirectStream fresh(compressorSettings());
    DirectStream other_fresh(compressorSettings());
    EXPECT_TRUE(waitForMerged(mergedDirectly(
        0.08,
        {{compressed, fresh.encode(cloud(i), pose)},
         {other_frames.topic(), other_fresh.encode(otherCloud(i), other_pose)}})))
        << "sum of frames " << i;
  }
  EXPECT_EQ(merged.last()->header.frame_id, "world");
}

TEST_F(CentralNodes, StreamThatFallsSilentLeavesTheSum)
{
  startTwoSensors({{"max_merge_age", 0.5}});
  clouds.publish(cloud(0));
  ASSERT_TRUE(voxels.waitForCount(1));
  EXPECT_TRUE(waitForMerged({}));
}

TEST_F(CentralNodes, EachStreamHasItsThreshold)
{
  startTwoSensors(
      {{"min_intensity", 2},
       {"streams", listOf({compressed, streamEntry(other_frames.topic(), 3.0)})}});
  const Voxels expected = direct.voxelsOf(cloud(0), pose, 2.0f);
  EXPECT_LT(expected.size(), direct.voxelsOf(cloud(0), pose).size());
  expectVoxels(cloud(0), expected);
  const Voxels other_expected = other_direct.voxelsOf(otherCloud(0), other_pose, 3.0f);
  other_clouds.publish(otherCloud(0));
  ASSERT_TRUE(other_voxels.waitForCount(1));
  EXPECT_GT(other_expected.size(), 0u);
  EXPECT_TRUE(voxelsIn(*other_voxels[0]) == other_expected);
}

/** \brief The threshold of one stream as it is changed. */
class Thresholds : public CentralNodes {
protected:
  /** \brief Sends clouds until the threshold in force is this one; until then it must be
   * that of before. */
  void
  expectChange(float before, float now)
  {
    SCOPED_TRACE(std::to_string(before) + " to " + std::to_string(now));
    EXPECT_TRUE(waitFor([&] {
      const auto sent = cloud(number++);
      const auto shown = show(sent);
      if (!shown)
        return false;
      if (voxelsIn(*shown) == direct.voxelsOf(sent, pose, now))
        return true;
      EXPECT_TRUE(voxelsIn(*shown) == direct.voxelsOf(sent, pose, before));
      return false;
    })) << decompressor->output();
    expectThreshold(now);
  }

  void
  expectThreshold(float min_intensity)
  {
    const auto sent = cloud(number++);
    expectVoxels(sent, direct.voxelsOf(sent, pose, min_intensity));
  }

  std::uint32_t number = 0;
};

TEST_F(Thresholds, ChangeWhileTheNodeRuns)
{
  const std::string for_all = full("decompressor/min_intensity");
  const std::string of_this = full("decompressor/min_intensity_of") + compressed;
  startBoth();
  expectThreshold(0.0f);
  ros::param::set(for_all, 3);
  expectChange(0.0f, 3.0f);
  ros::param::set(for_all, 1.5);
  expectChange(3.0f, 1.5f);
  ros::param::set(for_all, -1.0); // above it are all voxels
  expectChange(1.5f, -1.0f);
  ros::param::set(for_all, 1.5);
  expectChange(-1.0f, 1.5f);
  ros::param::set(of_this, 4.0);
  expectChange(1.5f, 4.0f);
  ros::param::del(of_this);
  expectChange(4.0f, 1.5f);
}

TEST_F(Thresholds, WrongValueIsWarnedOfAndChangesNothing)
{
  startBoth();
  const std::string name = full("decompressor/min_intensity");
  ros::param::set(name, 2.0);
  expectChange(0.0f, 2.0f);
  ros::param::set(name, "many");
  EXPECT_TRUE(waitFor([&] {
    return decompressor->output().find("'many'; it must be") != std::string::npos;
  })) << decompressor->output();
  expectThreshold(2.0f);
  ros::param::set(name, true);
  EXPECT_TRUE(waitFor([&] {
    return decompressor->output().find("is 1; it must be") != std::string::npos;
  })) << decompressor->output();
  expectThreshold(2.0f);
  ros::param::set(name, 5.0);
  expectChange(2.0f, 5.0f);
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
