/** \file
 * \brief Many streams in one node, their sum, and how their noise is removed.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "stream_scenario.h"

#include <ros/param.h>

#include <algorithm>

namespace pcl_ext_ros {
namespace test {

namespace {

using pcl_ext::VoxelOutlierRemoval;
using pcl_ext::VoxelOutlierRemovalSettings;

XmlRpc::XmlRpcValue
streamEntry(const std::string& topic,
            const std::string& key,
            const XmlRpc::XmlRpcValue& value)
{
  XmlRpc::XmlRpcValue entry;
  entry["topic"] = topic;
  entry[key] = value;
  return entry;
}

VoxelOutlierRemoval
removalAt(float min_log_odds)
{
  VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = min_log_odds;
  return VoxelOutlierRemoval(settings);
}

/** \brief What a frame is to become; all of it where there is no filter. */
Voxels
filtered(pcl_ext::io::VoxelFrame frame, std::optional<VoxelOutlierRemoval>& removal)
{
  if (removal) {
    EXPECT_GT(removal->filter(frame), 0u);
    EXPECT_GT(frame.size(), 100u);
  }
  return voxelsIn(frame);
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
       {"streams",
        listOf(
            {compressed, streamEntry(other_frames.topic(), "min_intensity", 3.0)})}});
  const Voxels expected = direct.voxelsOf(cloud(0), pose, 2.0f);
  EXPECT_LT(expected.size(), direct.voxelsOf(cloud(0), pose).size());
  expectVoxels(cloud(0), expected);
  const Voxels other_expected = other_direct.voxelsOf(otherCloud(0), other_pose, 3.0f);
  other_clouds.publish(otherCloud(0));
  ASSERT_TRUE(other_voxels.waitForCount(1));
  EXPECT_GT(other_expected.size(), 0u);
  EXPECT_TRUE(voxelsIn(*other_voxels[0]) == other_expected);
}

TEST_F(CentralNodes, EachStreamHasItsFilterOfOutliersAndMergesWhatStays)
{
  startTwoSensors(
      {{"remove_outliers", true},
       {"min_log_odds", 3.0},
       {"max_merge_age", 3600.0},
       {"streams",
        listOf({compressed, streamEntry(other_frames.topic(), "min_log_odds", 2.0)})}});
  std::optional<VoxelOutlierRemoval> removal = removalAt(3.0f);
  std::optional<VoxelOutlierRemoval> other_removal = removalAt(2.0f);
  std::size_t voxels_of_both = 0;
  for (std::uint32_t i = 0; i < 6; ++i) {
    expectVoxels(cloud(i), filtered(direct.frameOf(cloud(i), pose), removal));
    other_clouds.publish(otherCloud(i));
    ASSERT_TRUE(other_voxels.waitForCount(i + 1)) << decompressor->output();
    EXPECT_TRUE(
        voxelsIn(*other_voxels[i]) ==
        filtered(other_direct.frameOf(otherCloud(i), other_pose), other_removal));
    voxels_of_both = voxelsIn(*voxels[i]).size() + voxelsIn(*other_voxels[i]).size();
  }
  // The sensors see different places.
  EXPECT_TRUE(waitFor([&] {
    const auto last = merged.last();
    return last && last->width == voxels_of_both;
  }));
}

/** \brief The filter of one stream as it is changed. */
class Outliers : public CentralNodes {
protected:
  void
  expectFrames()
  {
    for (int i = 0; i < 3; ++i, ++number)
      expectVoxels(cloud(number),
                   filtered(direct.frameOf(cloud(number), pose), removal));
  }

  /** \brief Sends clouds until another filter is in force, which begins anew; until then
   * it must be that of before.
   * \param[in] min_log_odds none: no filter
   */
  void
  expectChange(std::optional<float> min_log_odds)
  {
    if (HasFatalFailure())
      return;
    SCOPED_TRACE(min_log_odds ? std::to_string(*min_log_odds) : "none");
    ASSERT_TRUE(waitFor([&] {
      const auto sent = cloud(number++);
      const auto shown = show(sent);
      if (!shown)
        return false;
      std::optional<VoxelOutlierRemoval> fresh;
      if (min_log_odds)
        fresh = removalAt(*min_log_odds);
      const Voxels now = filtered(direct.frameOf(sent, pose), fresh);
      const Voxels before = filtered(direct.frameOf(sent, pose), removal);
      EXPECT_TRUE(now != before);
      const bool is_changed = voxelsIn(*shown) == now;
      EXPECT_TRUE(is_changed || voxelsIn(*shown) == before);
      if (is_changed)
        removal = std::move(fresh);
      return is_changed;
    })) << decompressor->output();
    expectFrames();
  }

  std::optional<VoxelOutlierRemoval> removal; // in force
  std::uint32_t number = 0;
};

TEST_F(Outliers, FiltersChangeWhileTheNodeRuns)
{
  const std::string remove = full("decompressor/remove_outliers");
  const std::string remove_of_this =
      full("decompressor/remove_outliers_of") + compressed;
  const std::string log_odds = full("decompressor/min_log_odds");
  const std::string log_odds_of_this =
      full("decompressor/min_log_odds_of") + compressed;
  startBoth();
  expectFrames();
  ros::param::set(log_odds, 3.5); // of nothing yet
  expectFrames();
  ros::param::set(remove, true);
  expectChange(3.5f);
  ros::param::set(log_odds, 2);
  expectChange(2.0f);
  ros::param::set(log_odds_of_this, 2.75);
  expectChange(2.75f);
  ros::param::set(remove_of_this, false);
  expectChange(std::nullopt);
  ros::param::del(remove_of_this);
  expectChange(2.75f);

  ros::param::set(remove, "often");
  EXPECT_TRUE(waitFor([&] {
    return decompressor->output().find("'often'; it must be true or false") !=
           std::string::npos;
  })) << decompressor->output();
  ros::param::set(log_odds_of_this, 1e39);
  EXPECT_TRUE(waitFor([&] {
    return decompressor->output().find("1e+39; it must be a finite number") !=
           std::string::npos;
  })) << decompressor->output();
  expectFrames(); // the filter goes on
  ros::param::set(remove, false);
  expectChange(std::nullopt);
}

/** \brief The threshold of one stream as it is changed. */
class Thresholds : public CentralNodes {
protected:
  /** \brief Sends clouds until the threshold in force is this one; until then it must be
   * that of before. */
  void
  expectChange(float before, float now)
  {
    if (HasFatalFailure())
      return;
    SCOPED_TRACE(std::to_string(before) + " to " + std::to_string(now));
    ASSERT_TRUE(waitFor([&] {
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
