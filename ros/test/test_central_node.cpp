/** \file
 * \brief Several streams in one node, their merged voxels, and the removal of noise.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "stream_scenario.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/param.h>

#include <algorithm>

namespace pcl_ext_ros1 {
namespace test {

namespace {

using pcl_ext::VoxelOutlierRemoval;

std::optional<VoxelOutlierRemoval>
removalAt(std::optional<float> min_log_odds)
{
  if (!min_log_odds)
    return std::nullopt;
  pcl_ext::VoxelOutlierRemovalSettings settings;
  settings.min_log_odds = *min_log_odds;
  settings.unit = pcl_ext::DensityUnit::Points;
  return VoxelOutlierRemoval(settings);
}

/** \brief Expected voxels of a frame after the filters of its stream. */
Voxels
filtered(pcl_ext::io::VoxelFrame frame,
         std::optional<VoxelOutlierRemoval>& removal,
         float min_intensity = 0.0f)
{
  if (removal) {
    EXPECT_GT(removal->filter(frame).removed, 0u);
    EXPECT_GT(frame.size(), 100u);
  }
  Voxels voxels = voxelsIn(frame);
  const auto is_faint = [=](const auto& voxel) { return voxel[3] < min_intensity; };
  voxels.erase(std::remove_if(voxels.begin(), voxels.end(), is_faint), voxels.end());
  EXPECT_FALSE(voxels.empty());
  return voxels;
}

Voxels
sorted(Voxels voxels)
{
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

/** \brief Adds a second sensor to the scenario. */
class CentralNodes : public StreamScenario {
protected:
  CentralNodes()
  : other_frame("other_" + sensor_frame)
  , other_pose(samplePose(1.0))
  , other_clouds(node.advertise<sensor_msgs::PointCloud2>(full("other"), 100))
  , other_topic(full("other/pcl_ext"))
  , other_voxels(other_topic + "/voxels")
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
    ASSERT_TRUE(waitForSubscribers(other_clouds, 1));
    startDecompressor(Parameters{{"streams", listOf({compressed, other_topic})}} +
                      decompressor_parameters);
    other_compressor->expectSubscribers(other_topic, 1);
    decompressor->expectSubscribers(other_voxels.topic(), 1);
    decompressor->expectSubscribers(merged.topic(), 1);
  }

  sensor_msgs::PointCloud2
  otherCloud(std::uint32_t number) const
  {
    return makeCloud<pcl::PointXYZI>(number + 77, other_frame, 4000);
  }

  /** \brief Publishes a cloud of the other sensor and expects its voxels. */
  void
  expectOtherVoxels(const sensor_msgs::PointCloud2& cloud, const Voxels& expected)
  {
    other_clouds.publish(cloud);
    const auto shown = other_voxels.waitForStamp(cloud.header.stamp);
    ASSERT_TRUE(shown) << decompressor->output();
    EXPECT_TRUE(voxelsIn(*shown) == expected);
  }

  /** \brief Waits for these merged voxels. Their order depends on the grid, and that on
   * earlier frames. */
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
  const std::string other_topic;
  Recorder<sensor_msgs::PointCloud2> other_voxels;
  Recorder<sensor_msgs::PointCloud2> merged;
  std::optional<NodeProcess> other_compressor;
  DirectStream other_direct{compressorSettings()};
};

TEST_F(CentralNodes, TwoStreamsAndTheirMergedVoxelsAreTheLibrarys)
{
  startTwoSensors({{"max_merge_age", 3600.0}, {"resolution", 0.08}});
  for (std::uint32_t i = 0; i < 6; ++i) {
    const Voxels other = other_direct.voxelsOf(otherCloud(i), other_pose);
    // Frames of both sensors arrive at the same time.
    clouds.publish(cloud(i));
    expectOtherVoxels(otherCloud(i), other);
    const auto shown = voxels.waitForStamp(cloud(i).header.stamp);
    ASSERT_TRUE(shown) << decompressor->output();
    EXPECT_TRUE(voxelsIn(*shown) == direct.voxelsOf(cloud(i), pose));

    DirectStream fresh(compressorSettings());
    DirectStream other_fresh(compressorSettings());
    EXPECT_TRUE(waitForMerged(
        mergedDirectly(0.08,
                       {{compressed, fresh.encode(cloud(i), pose)},
                        {other_topic, other_fresh.encode(otherCloud(i), other_pose)}})))
        << "frame " << i;
  }
  EXPECT_EQ(merged.last()->header.frame_id, "world");
  // The time of merging: those of the clouds are in the future.
  EXPECT_LT(merged.last()->header.stamp, cloud(0).header.stamp);
}

TEST_F(CentralNodes, MergedVoxelsHaveTheColoursOfTheStreamsThatHaveThem)
{
  startTwoSensors({{"max_merge_age", 3600.0}, {"resolution", 0.08}});
  const auto coloured = cloud<pcl::PointXYZRGB>(0);
  ASSERT_TRUE(show(coloured));
  other_clouds.publish(otherCloud(0));
  DirectStream fresh(compressorSettings());
  DirectStream other_fresh(compressorSettings());
  EXPECT_TRUE(waitForMerged(
      mergedDirectly(0.08,
                     {{compressed, fresh.encode(coloured, pose)},
                      {other_topic, other_fresh.encode(otherCloud(0), other_pose)}})));
  EXPECT_EQ(merged.last()->fields.size(), 5u);
}

TEST_F(CentralNodes, SilentStreamIsNotMergedAndNamed)
{
  startTwoSensors({{"max_merge_age", 0.5}});
  const Recorder<diagnostic_msgs::DiagnosticArray> streams(
      full("decompressor/merged/streams"));
  ASSERT_TRUE(show(cloud(0)));
  EXPECT_TRUE(waitForMerged({}));
  EXPECT_TRUE(waitFor([&] {
    const auto last = streams.last();
    return last && last->status.size() == 3 &&
           last->status[0].level == diagnostic_msgs::DiagnosticStatus::STALE &&
           last->status[0].hardware_id == compressed;
  }));
}

TEST_F(CentralNodes, EachStreamHasItsThreshold)
{
  startTwoSensors(
      {{"min_intensity", 2},
       {"streams",
        listOf({compressed, streamEntry(other_topic, "min_intensity", 3.0)})}});
  std::optional<VoxelOutlierRemoval> none;
  expectVoxels(cloud(0), filtered(direct.frameOf(cloud(0), pose), none, 2.0f));
  expectOtherVoxels(
      otherCloud(0),
      filtered(other_direct.frameOf(otherCloud(0), other_pose), none, 3.0f));
  ASSERT_TRUE(voxels.last());
  EXPECT_LT(voxels.last()->width, direct.frameOf(cloud(0), pose).size());
}

TEST_F(CentralNodes, EachStreamHasItsOutlierRemovalBeforeMerging)
{
  startTwoSensors(
      {{"remove_outliers", true},
       {"min_log_odds", 3.0},
       {"density_unit", "points"},
       {"max_merge_age", 3600.0},
       {"streams",
        listOf({compressed, streamEntry(other_topic, "min_log_odds", 2.0)})}});
  std::optional<VoxelOutlierRemoval> removal = removalAt(3.0f);
  std::optional<VoxelOutlierRemoval> other_removal = removalAt(2.0f);
  for (std::uint32_t i = 0; i < 6; ++i) {
    expectVoxels(cloud(i), filtered(direct.frameOf(cloud(i), pose), removal));
    expectOtherVoxels(
        otherCloud(i),
        filtered(other_direct.frameOf(otherCloud(i), other_pose), other_removal));
  }
  ASSERT_TRUE(voxels.last() && other_voxels.last());
  // The sensors see different places.
  EXPECT_TRUE(waitFor([&] {
    return merged.last() &&
           merged.last()->width == voxels.last()->width + other_voxels.last()->width;
  }));
}

/** \brief Changes the noise settings of a running node. */
class ChangedNoise : public StreamScenario {
protected:
  void
  set(const std::string& parameter, const XmlRpc::XmlRpcValue& value) const
  {
    ros::param::set(full("decompressor/" + parameter), value);
  }

  void
  unset(const std::string& parameter) const
  {
    ros::param::del(full("decompressor/" + parameter));
  }

  /** \brief Expects the filters in force for a few frames. */
  void
  expectFrames()
  {
    for (int i = 0; i < 3; ++i, ++number)
      expectVoxels(cloud(number),
                   filtered(direct.frameOf(cloud(number), pose), removal, threshold));
  }

  /** \brief Publishes clouds until other filters are in force. Until then the previous
   * filters must be. A changed outlier removal starts without history.
   * \param[in] min_intensity the threshold
   * \param[in] min_log_odds nothing: outliers are not removed
   */
  void
  expectChange(float min_intensity, std::optional<float> min_log_odds = std::nullopt)
  {
    if (HasFailure())
      return;
    SCOPED_TRACE(std::to_string(min_intensity) + ", " +
                 (min_log_odds ? std::to_string(*min_log_odds) : "no removal"));
    EXPECT_TRUE(waitFor([&] {
      const auto sent = cloud(number++);
      const auto shown = show(sent);
      if (!shown)
        return false;
      const auto frame = direct.frameOf(sent, pose);
      auto fresh = removalAt(min_log_odds);
      const Voxels now = filtered(frame, fresh, min_intensity);
      const Voxels before = filtered(frame, removal, threshold);
      EXPECT_TRUE(now != before);
      const bool is_changed = voxelsIn(*shown) == now;
      EXPECT_TRUE(is_changed || voxelsIn(*shown) == before);
      if (is_changed) {
        removal = std::move(fresh);
        threshold = min_intensity;
      }
      return is_changed;
    })) << decompressor->output();
    expectFrames();
  }

  std::optional<VoxelOutlierRemoval> removal; // in force
  float threshold = 0.0f;                     // in force
  std::uint32_t number = 0;
};

TEST_F(ChangedNoise, OutlierRemoval)
{
  startBoth({},
            {{"streams", listOf({streamEntry(compressed, "density_unit", "points")})}});
  expectFrames();
  set("min_log_odds", 3.5); // without effect while outliers are not removed
  expectFrames();
  set("remove_outliers", true);
  expectChange(0.0f, 3.5f);
  set("min_log_odds", 2);
  expectChange(0.0f, 2.0f);
  set("min_log_odds_of" + compressed, 2.75);
  expectChange(0.0f, 2.75f);
  set("remove_outliers_of" + compressed, false);
  expectChange(0.0f);
  unset("remove_outliers_of" + compressed);
  expectChange(0.0f, 2.75f);

  set("remove_outliers", "often");
  decompressor->expectOutput("'often'; it must be true or false");
  set("min_log_odds_of" + compressed, 1e39);
  decompressor->expectOutput("1e+39; it must be a finite number");
  expectFrames(); // nothing changed
  set("remove_outliers", false);
  expectChange(0.0f);
}

TEST_F(ChangedNoise, Threshold)
{
  startBoth();
  expectFrames();
  set("min_intensity", 3);
  expectChange(3.0f);
  set("min_intensity", 1.5);
  expectChange(1.5f);
  set("min_intensity", -1.0); // below all voxels
  expectChange(-1.0f);
  set("min_intensity", 1.5);
  expectChange(1.5f);
  set("min_intensity_of" + compressed, 4.0);
  expectChange(4.0f);
  unset("min_intensity_of" + compressed);
  expectChange(1.5f);

  set("min_intensity", "many");
  decompressor->expectOutput("'many'; it must be");
  expectFrames();
  set("min_intensity", true);
  decompressor->expectOutput("is true; it must be");
  expectFrames();
  set("min_intensity", 5.0);
  expectChange(5.0f);
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
