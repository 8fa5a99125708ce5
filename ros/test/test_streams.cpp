/** \file
 * \brief Clouds in, voxels out: the same as by the library, voxel by voxel.
 */
#include "stream_scenario.h"

namespace pcl_ext_ros {
namespace test {

namespace {

namespace io = pcl_ext::io;
using pcl_ext::IntensityLaw;
using pcl_ext::nodes::SensorNodeSettings;

class Streams : public StreamScenario {
protected:
  /** \brief Sends some clouds and expects the library's voxels of each, once. */
  template <typename PointT>
  void
  expectStream(const SensorNodeSettings& settings, std::uint32_t count = 8)
  {
    DirectStream direct(settings);
    for (std::uint32_t i = 0; i < count; ++i) {
      const sensor_msgs::PointCloud2 sent = cloud<PointT>(i);
      const Voxels expected = direct.voxelsOf(sent, pose);
      EXPECT_GT(expected.size(), 500u);
      expectVoxels(sent, expected);
    }
    EXPECT_EQ(voxels.count(), count);
  }
};

TEST_F(Streams, XyzGivesTheLibrarysVoxels)
{
  startBoth();
  expectStream<pcl::PointXYZ>(compressorSettings());
}

TEST_F(Streams, XyzrgbGivesTheLibrarysVoxels)
{
  startBoth();
  expectStream<pcl::PointXYZRGB>(compressorSettings());
}

TEST_F(Streams, NativeIntensitiesOfXyziGiveTheLibrarysVoxels)
{
  startBoth(compressorParameters() + Parameters{{"intensity", "native"},
                                                {"intensity_range", 255.0},
                                                {"intensity_bits", 8}});
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Native;
  settings.compression.intensity_range = 255.0f;
  settings.compression.intensity_bits = 8;
  expectStream<pcl::PointXYZI>(settings);
}

TEST_F(Streams, LawsOfDepthGiveTheLibrarysVoxels)
{
  startBoth(compressorParameters() + Parameters{{"intensity", "quadratic"},
                                                {"sensor", "kinect_v2"},
                                                {"resolution", 0.05},
                                                {"effort", "small"}});
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Quadratic;
  const pcl_ext::KinectV2 sensor;
  settings.sensor.emplace(
      sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows);
  settings.compression.resolution = 0.05;
  settings.compression.effort = io::Effort::Small;
  expectStream<pcl::PointXYZI>(settings);
}

TEST_F(Streams, SensorToldByFiguresGivesTheLibrarysVoxels)
{
  startBoth(compressorParameters() + Parameters{{"intensity", "linear"},
                                                {"sensor_fov_x_deg", 60},
                                                {"sensor_fov_y_deg", 45.5},
                                                {"sensor_columns", 320},
                                                {"sensor_rows", 240},
                                                {"effort", "fast"}});
  SensorNodeSettings settings = compressorSettings();
  settings.law = IntensityLaw::Linear;
  settings.sensor.emplace(60.0, 45.5, 320u, 240u);
  settings.compression.effort = io::Effort::Fast;
  expectStream<pcl::PointXYZ>(settings, 3);
}

TEST_F(Streams, GridThatFollowsThePointsGivesTheLibrarysVoxels)
{
  startBoth({{"tf_timeout", 10.0}});
  SensorNodeSettings settings = compressorSettings();
  settings.crop_box.reset();
  expectStream<pcl::PointXYZ>(settings);
}

TEST_F(Streams, PublishedFormatGivesTheLibrarysVoxels)
{
  startBoth(compressorParameters() + Parameters{{"format", "published"}});
  SensorNodeSettings settings = compressorSettings();
  settings.compression.format = io::StreamFormat::Published;
  expectStream<pcl::PointXYZ>(settings);
  EXPECT_EQ(frames.last()->format, "pcl_ext/published");
}

TEST_F(Streams, CompandedIntensitiesGiveTheLibrarysVoxels)
{
  startBoth(compressorParameters() + Parameters{{"intensity_curve", "companded"}});
  SensorNodeSettings settings = compressorSettings();
  settings.compression.intensity_curve = io::IntensityCurve::Companded;
  expectStream<pcl::PointXYZ>(settings, 3);
}

TEST_F(Streams, OutliersThatTheCompressorRemovesAreTheLibrarys)
{
  startBoth(compressorParameters() +
            Parameters{{"remove_outliers", true}, {"min_log_odds", 3}});
  SensorNodeSettings settings = compressorSettings();
  DirectStream plain(settings);
  settings.outlier_removal.emplace().min_log_odds = 3.0f;
  expectStream<pcl::PointXYZ>(settings);
  EXPECT_LT(voxelsIn(*voxels.last()).size(), plain.voxelsOf(cloud(7), pose).size());
}

TEST_F(Streams, BytesAreTheLibrarysAndTheMessageTellsTheLayout)
{
  startBoth(compressorParameters() + Parameters{{"i_frame_rate", 5}});
  SensorNodeSettings settings = compressorSettings();
  settings.compression.i_frame_rate = 5;
  DirectStream direct(settings);
  for (std::uint32_t i = 0; i < 12; ++i) {
    const auto frame = compress(cloud(i));
    ASSERT_TRUE(frame) << compressor->output();
    EXPECT_TRUE(frame->compressed_data == direct.encode(cloud(i), pose))
        << "frame " << i;
    EXPECT_EQ(frame->header.frame_id, "world");
    EXPECT_EQ(frame->format, "pcl_ext/version1");
    // The layout is that of the cloud that it is decoded to.
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
  DirectStream direct(compressorSettings());
  const Voxels expected = direct.voxelsOf(cloud(0), pose);
  expectVoxels(cloud(0), expected); // waits for the transform, which the others do not
  for (const ros::Time stamp : {ros::Time(0, 1),
                                ros::Time(1700000000, 999999999),
                                ros::Time(1700000001, 1),
                                ros::Time(4294967295u, 999999999)}) {
    sensor_msgs::PointCloud2 sent = cloud(0);
    sent.header.stamp = stamp;
    expectVoxels(sent, expected);
  }
}

TEST_F(Streams, CloudsOfTheWorldFrameNeedNoTransform)
{
  startCompressor();
  startDecompressor();
  DirectStream direct(compressorSettings());
  sensor_msgs::PointCloud2 sent = cloud(0);
  sent.header.frame_id = "world";
  expectVoxels(sent, direct.voxelsOf(sent, pcl_ext::WorldPose::Identity()));
}

TEST_F(Streams, SlashBeforeTheFrameIsNoOtherFrame)
{
  startBoth();
  DirectStream direct(compressorSettings());
  sensor_msgs::PointCloud2 sent = cloud(0);
  sent.header.frame_id = "/" + sensor_frame;
  expectVoxels(sent, direct.voxelsOf(sent, pose));
}

TEST_F(Streams, OtherWorldFrame)
{
  geometry_msgs::TransformStamped in_hall = toMessage(sensor_frame, pose);
  in_hall.header.frame_id = "hall";
  transforms.send(in_hall);
  startCompressor(compressorParameters() + Parameters{{"global_frame", "hall"}});
  startDecompressor({{"global_frame", "/hall"}});
  const auto shown = show(cloud(0));
  ASSERT_TRUE(shown) << compressor->output() << decompressor->output();
  EXPECT_EQ(shown->header.frame_id, "hall");
  EXPECT_TRUE(voxelsIn(*shown) ==
              DirectStream(compressorSettings()).voxelsOf(cloud(0), pose));
}

TEST_F(Streams, CropBoxKeepsTheLibrarysVoxels)
{
  DirectStream whole(compressorSettings());
  const Voxels all = whole.voxelsOf(cloud(0), pose);
  const double middle = all[all.size() / 2][0];
  // Whole numbers are numbers, too.
  startBoth(compressorParameters() +
            Parameters{{"crop_box", listOf({middle, -10, -10.0, 10, 10, 10})}});
  SensorNodeSettings settings = compressorSettings();
  settings.crop_box->min[0] = middle;
  DirectStream cropped(settings);
  const Voxels expected = cropped.voxelsOf(cloud(0), pose);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_LT(expected.size(), all.size() - 100);
  expectVoxels(cloud(0), expected);
}

TEST_F(Streams, EmptyCropGivesFramesWithoutVoxels)
{
  // Nothing of the wall, which is three metres before the sensor, is here.
  startBoth(compressorParameters() +
            Parameters{{"crop_box", listOf({-9.0, -9.0, -9.0, -8.0, -8.0, -8.0})}});
  for (std::uint32_t i = 0; i < 5; ++i)
    expectVoxels(cloud(i), {});
  EXPECT_EQ(frames.count(), 5u);
  EXPECT_EQ(frames.last()->width, 0u);
}

TEST_F(Streams, CloudsWithoutPointsAndThoseBehindThem)
{
  startBoth();
  DirectStream direct(compressorSettings());
  for (std::uint32_t i = 0; i < 6; ++i) {
    const auto sent = makeCloud<pcl::PointXYZ>(i, sensor_frame, i % 2 == 0 ? 0 : 6000);
    expectVoxels(sent, i % 2 == 0 ? Voxels() : direct.voxelsOf(sent, pose));
  }
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
  // By the names of the code, and those that they became.
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
  ASSERT_TRUE(waitFor([&] { return camera_clouds.getNumSubscribers() == 1; }));
  ASSERT_TRUE(waitForSubscribers(other_compressor.name(), link, 2));
  ASSERT_TRUE(waitForSubscribers(other_decompressor.name(), shown.topic(), 1));
  ASSERT_TRUE(waitForSubscribers(other_decompressor.name(), merged.topic(), 1));
  camera_clouds.publish(cloud(0));
  ASSERT_TRUE(shown.waitForCount(1)) << other_decompressor.output();
  EXPECT_TRUE(voxelsIn(*shown[0]) ==
              DirectStream(compressorSettings()).voxelsOf(cloud(0), pose));
  EXPECT_EQ(link_frames.count(), 1u);
  EXPECT_TRUE(merged.waitForCount(1));
}

TEST_F(Streams, NodesEndWithCodeZeroWhenInterrupted)
{
  startBoth();
  ASSERT_TRUE(show(cloud(0)));
  EXPECT_EQ(compressor->interrupt(), 0) << compressor->output();
  EXPECT_EQ(decompressor->interrupt(), 0) << decompressor->output();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros
