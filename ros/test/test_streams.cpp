/** \file
 * \brief The voxels of a stream are those of the library without ROS.
 */
#include "stream_scenario.h"

namespace pcl_ext_ros1 {
namespace test {

namespace {

namespace io = pcl_ext::io;
using pcl_ext::IntensityLaw;
using pcl_ext::nodes::SensorNodeSettings;

class Streams : public StreamScenario {
protected:
  /** \brief Starts the nodes; expects the library's voxels of each cloud, once.
   * \param[in] changes of compressorParameters()
   * \param[in] settings the same for the library
   */
  template <typename PointT>
  void
  expectStream(const Parameters& changes, const SensorNodeSettings& settings)
  {
    constexpr std::uint32_t count = 8;
    startBoth(changes);
    DirectStream stream(settings);
    for (std::uint32_t i = 0; i < count; ++i) {
      const sensor_msgs::PointCloud2 sent = cloud<PointT>(i);
      const Voxels expected = stream.voxelsOf(sent, pose);
      EXPECT_GT(expected.size(), 500u);
      expectVoxels(sent, expected);
    }
    EXPECT_EQ(voxels.count(), count);
  }
};

TEST_F(Streams, XyzGivesTheLibrarysVoxels)
{
  expectStream<pcl::PointXYZ>({}, compressorSettings());
}

TEST_F(Streams, XyzrgbGivesTheLibrarysVoxels)
{
  SensorNodeSettings settings = compressorSettings();
  settings.compression.colour_bits = 3;
  expectStream<pcl::PointXYZRGB>({{"colour_bits", 3}}, settings);
  EXPECT_EQ(voxels.last()->fields.size(), 5u);
  EXPECT_EQ(frames.last()->fields, voxels.last()->fields);
}

TEST_F(Streams, IntensitiesOfTheSensorAreSentUnlessAParameterSaysOtherwise)
{
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Native;
  settings.compression.intensity_range = 255.0f;
  settings.compression.intensity_bits = 8;
  expectStream<pcl::PointXYZI>(
      {{"intensity", "automatic"}, {"intensity_range", 255.0}, {"intensity_bits", 8}},
      settings);
  compressor->expectOutput("The intensities are: native");
}

TEST_F(Streams, CloudThatIsRefusedDoesNotChooseTheIntensities)
{
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Native;
  startBoth({{"intensity", "automatic"}});
  sensor_msgs::PointCloud2 empty;
  empty.header = cloud(0).header;
  clouds.publish(empty);
  compressor->expectOutput("A cloud is dropped");
  DirectStream stream(settings);
  const auto sent = cloud<pcl::PointXYZI>(1);
  expectVoxels(sent, stream.voxelsOf(sent, pose));
}

TEST_F(Streams, LawsOfDepthGiveTheLibrarysVoxels)
{
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Quadratic;
  settings.sensor = pcl_ext::runtimeSensor(pcl_ext::KinectV2());
  settings.compression.resolution = 0.05;
  settings.compression.effort = io::Effort::Small;
  expectStream<pcl::PointXYZI>({{"intensity", "quadratic"},
                                {"sensor", "kinect_v2"},
                                {"resolution", 0.05},
                                {"effort", "small"}},
                               settings);
}

TEST_F(Streams, SensorByItsNumbersGivesTheLibrarysVoxels)
{
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Linear;
  settings.sensor.emplace(60.0, 45.5, 320u, 240u);
  settings.compression.effort = io::Effort::Fast;
  settings.compression.intensity_curve = io::IntensityCurve::Companded;
  expectStream<pcl::PointXYZ>({{"intensity", "linear"},
                               {"sensor_fov_x_deg", 60},
                               {"sensor_fov_y_deg", 45.5},
                               {"sensor_columns", 320},
                               {"sensor_rows", 240},
                               {"effort", "fast"},
                               {"intensity_curve", "companded"}},
                              settings);
}

TEST_F(Streams, PublishedFormatGivesTheLibrarysVoxels)
{
  SensorNodeSettings settings = compressorSettings();
  settings.compression.format = io::StreamFormat::Published;
  settings.crop_box.reset(); // the grid follows the points
  expectStream<pcl::PointXYZ>({{"format", "published"}, {"crop_box", listOf({})}},
                              settings);
  EXPECT_EQ(frames.last()->format, "pcl_ext/published");
}

TEST_F(Streams, OutliersThatTheCompressorRemovesAreTheLibrarys)
{
  SensorNodeSettings settings = compressorSettings();
  settings.outlier_removal.emplace().min_log_odds = 3.0f;
  expectStream<pcl::PointXYZ>({{"remove_outliers", true}, {"min_log_odds", 3}},
                              settings);
  EXPECT_LT(voxelsIn(*voxels.last()).size(), direct.voxelsOf(cloud(7), pose).size());
}

TEST_F(Streams, BytesAreTheLibrarysAndTheMessageHasTheLayout)
{
  startBoth({{"i_frame_rate", 5}});
  SensorNodeSettings settings = compressorSettings();
  settings.compression.i_frame_rate = 5;
  DirectStream stream(settings);
  for (std::uint32_t i = 0; i < 12; ++i) {
    const auto frame = compress(cloud(i));
    ASSERT_TRUE(frame) << compressor->output();
    EXPECT_TRUE(frame->compressed_data == stream.encode(cloud(i), pose))
        << "frame " << i;
    EXPECT_EQ(frame->header.frame_id, "world");
    EXPECT_EQ(frame->format, "pcl_ext/version1");
    // The layout of the decoded cloud.
    ASSERT_TRUE(voxels.waitForCount(i + 1));
    const auto shown = voxels.last();
    EXPECT_EQ(frame->header.stamp, shown->header.stamp);
    EXPECT_EQ(frame->width, shown->width);
    EXPECT_EQ(frame->height, shown->height);
    EXPECT_EQ(frame->fields, shown->fields);
    EXPECT_EQ(frame->point_step, shown->point_step);
    EXPECT_EQ(frame->row_step, shown->row_step);
    EXPECT_EQ(frame->is_dense, shown->is_dense);
    EXPECT_EQ(frame->is_bigendian, shown->is_bigendian);
  }
}

TEST_F(Streams, StampsAreKeptToTheNanosecond)
{
  startBoth();
  const Voxels expected = direct.voxelsOf(cloud(0), pose);
  expectVoxels(cloud(0), expected); // waits for the transform; the stamps below do not
  for (const ros::Time stamp : {ros::Time(0, 1),
                                ros::Time(1700000000, 999999999),
                                ros::Time(1700000001, 1),
                                ros::Time(4294967295u, 999999999)}) {
    sensor_msgs::PointCloud2 sent = cloud(0);
    sent.header.stamp = stamp;
    expectVoxels(sent, expected);
  }
}

TEST_F(Streams, CloudsInTheGlobalFrameNeedNoTransform)
{
  startCompressor();
  startDecompressor();
  sensor_msgs::PointCloud2 sent = cloud(0);
  sent.header.frame_id = "world";
  expectVoxels(sent, direct.voxelsOf(sent, pcl_ext::WorldPose::Identity()));
}

TEST_F(Streams, LeadingSlashOfAFrameIsIgnored)
{
  startBoth();
  sensor_msgs::PointCloud2 sent = cloud(0);
  sent.header.frame_id = "/" + sensor_frame;
  expectVoxels(sent, direct.voxelsOf(sent, pose));
}

TEST_F(Streams, OtherGlobalFrame)
{
  geometry_msgs::TransformStamped in_hall = toMessage(sensor_frame, pose);
  in_hall.header.frame_id = "hall";
  transforms.send(in_hall);
  startCompressor({{"global_frame", "hall"}});
  startDecompressor({{"global_frame", "/hall"}});
  const auto shown = show(cloud(0));
  ASSERT_TRUE(shown) << compressor->output() << decompressor->output();
  EXPECT_EQ(shown->header.frame_id, "hall");
  EXPECT_TRUE(voxelsIn(*shown) == direct.voxelsOf(cloud(0), pose));
}

TEST_F(Streams, CropBoxKeepsTheLibrarysVoxels)
{
  const Voxels all = direct.voxelsOf(cloud(0), pose);
  const double middle = all[all.size() / 2][0];
  // Integers are accepted as numbers.
  startBoth({{"crop_box", listOf({middle, -10, -10.0, 10, 10, 10})}});
  SensorNodeSettings settings = compressorSettings();
  settings.crop_box->min[0] = middle;
  const Voxels expected = DirectStream(settings).voxelsOf(cloud(0), pose);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_LT(expected.size(), all.size() - 100);
  expectVoxels(cloud(0), expected);
}

TEST_F(Streams, EmptyCropGivesFramesWithoutVoxels)
{
  // The wall is outside of this box.
  startBoth({{"crop_box", listOf({-9.0, -9.0, -9.0, -8.0, -8.0, -8.0})}});
  for (std::uint32_t i = 0; i < 5; ++i)
    expectVoxels(cloud(i), {});
  EXPECT_EQ(frames.count(), 5u);
  EXPECT_EQ(frames.last()->width, 0u);
}

TEST_F(Streams, EachTopicCanBeRemapped)
{
  transforms.set(sensor_frame, pose);
  const std::string camera = full("camera");
  const std::string link = full("link");
  ros::Publisher camera_clouds = node.advertise<sensor_msgs::PointCloud2>(camera, 10);
  Recorder<CompressedPointCloud2> link_frames(link);
  Recorder<sensor_msgs::PointCloud2> shown(full("shown"));
  Recorder<sensor_msgs::PointCloud2> merged(full("merged_elsewhere"));
  // The second name is derived from the first one after its remapping.
  NodeProcess other_compressor("intensity_compressor",
                               full("other_compressor"),
                               compressorParameters(),
                               {"input:=" + camera, camera + "/pcl_ext:=" + link});
  NodeProcess other_decompressor("intensity_decompressor",
                                 full("other_decompressor"),
                                 {},
                                 {"input:=" + link,
                                  link + "/voxels:=" + shown.topic(),
                                  "~merged:=" + merged.topic()});
  ASSERT_TRUE(waitForSubscribers(camera_clouds, 1));
  other_compressor.expectSubscribers(link, 2);
  other_decompressor.expectSubscribers(shown.topic(), 1);
  other_decompressor.expectSubscribers(merged.topic(), 1);
  camera_clouds.publish(cloud(0));
  ASSERT_TRUE(shown.waitForCount(1)) << other_decompressor.output();
  EXPECT_TRUE(voxelsIn(*shown[0]) == direct.voxelsOf(cloud(0), pose));
  EXPECT_EQ(link_frames.count(), 1u);
  EXPECT_TRUE(merged.waitForCount(1));
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1
