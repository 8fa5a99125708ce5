#include "stream_scenario.h"

namespace pcl_ext_ros1 {
namespace test {

namespace {

constexpr double box_edge = 10.0;

std::string
nameOfThisTest()
{
  return ::testing::UnitTest::GetInstance()->current_test_info()->name();
}

} // namespace

Parameters
compressorParameters()
{
  return {{"crop_box",
           listOf({-box_edge, -box_edge, -box_edge, box_edge, box_edge, box_edge})},
          {"intensity", "count"},
          {"resolution", 0.04},
          {"tf_timeout", 10.0}};
}

pcl_ext::nodes::SensorNodeSettings
compressorSettings()
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.law = pcl_ext::IntensityLaw::Count;
  settings.compression.resolution = 0.04;
  settings.crop_box.emplace();
  settings.crop_box->min.fill(-box_edge);
  settings.crop_box->max.fill(box_edge);
  return settings;
}

StreamScenario::StreamScenario()
: space("/" + nameOfThisTest())
, sensor_frame("sensor_of_" + nameOfThisTest())
, input(full("input"))
, compressed(input + "/pcl_ext")
, pose(samplePose(0.0))
, clouds(node.advertise<sensor_msgs::PointCloud2>(input, 100))
, frames(compressed)
, voxels(compressed + "/voxels")
, compressor_health(full("compressor"))
, decompressor_health(full("decompressor"))
{}

std::string
StreamScenario::full(const std::string& name) const
{
  return space + "/" + name;
}

void
StreamScenario::startCompressor(const Parameters& changes)
{
  compressor.emplace(
      "intensity_compressor", full("compressor"), compressorParameters() + changes);
  EXPECT_TRUE(waitForSubscribers(clouds, 1)) << compressor->output();
  compressor->expectSubscribers(compressed, 1);
}

void
StreamScenario::startDecompressor(const Parameters& parameters)
{
  decompressor.emplace(
      "intensity_decompressor",
      full("decompressor"),
      Parameters{{"streams", listOf({compressed})}, {"resolution", 0.04}} + parameters);
  decompressor->expectSubscribers(voxels.topic(), 1);
  if (compressor && compressor->isRunning())
    compressor->expectSubscribers(compressed, 2);
}

void
StreamScenario::startBoth(const Parameters& compressor_changes,
                          const Parameters& decompressor_parameters)
{
  transforms.set(sensor_frame, pose);
  startCompressor(compressor_changes);
  startDecompressor(decompressor_parameters);
}

CompressedPointCloud2::ConstPtr
StreamScenario::compress(const sensor_msgs::PointCloud2& cloud)
{
  if (HasFatalFailure())
    return {};
  clouds.publish(cloud);
  return frames.waitForStamp(cloud.header.stamp);
}

sensor_msgs::PointCloud2::ConstPtr
StreamScenario::show(const sensor_msgs::PointCloud2& cloud)
{
  if (HasFatalFailure())
    return {};
  clouds.publish(cloud);
  return voxels.waitForStamp(cloud.header.stamp);
}

void
StreamScenario::expectVoxels(const sensor_msgs::PointCloud2& cloud,
                             const Voxels& expected)
{
  const auto shown = show(cloud);
  ASSERT_TRUE(shown) << compressor->output() << decompressor->output();
  EXPECT_EQ(shown->header.frame_id, "world");
  // EXPECT_EQ would print all voxels.
  EXPECT_TRUE(voxelsIn(*shown) == expected)
      << shown->width << " voxels, " << expected.size() << " expected";
}

void
StreamScenario::expectClouds(std::uint32_t begin, std::uint32_t end)
{
  for (std::uint32_t i = begin; i < end; ++i)
    expectVoxels(cloud(i), direct.voxelsOf(cloud(i), pose));
}

} // namespace test
} // namespace pcl_ext_ros1
