#include "stream_scenario.h"

#include <algorithm>

namespace pcl_ext_ros {
namespace test {

namespace {

constexpr double box_edge = 10.0;

std::string
nameOfThisTest()
{
  const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
  return test->name();
}

} // namespace

Parameters
compressorParameters()
{
  return {{"crop_box",
           listOf({-box_edge, -box_edge, -box_edge, box_edge, box_edge, box_edge})},
          {"tf_timeout", 10.0}};
}

pcl_ext::nodes::SensorNodeSettings
compressorSettings()
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.compression.resolution = 0.04;
  settings.crop_box.emplace();
  settings.crop_box->min.fill(-box_edge);
  settings.crop_box->max.fill(box_edge);
  return settings;
}

Parameters
operator+(Parameters parameters, const Parameters& others)
{
  for (const auto& other : others) {
    const auto same =
        std::find_if(parameters.begin(), parameters.end(), [&](const auto& parameter) {
          return parameter.first == other.first;
        });
    if (same != parameters.end())
      *same = other;
    else
      parameters.push_back(other);
  }
  return parameters;
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
{}

std::string
StreamScenario::full(const std::string& name) const
{
  return space + "/" + name;
}

void
StreamScenario::startCompressor(const Parameters& parameters,
                                const std::vector<std::string>& arguments)
{
  compressor.emplace("intensity_compressor", full("compressor"), parameters, arguments);
  EXPECT_TRUE(waitFor([this] { return clouds.getNumSubscribers() == 1; }))
      << compressor->output();
  EXPECT_TRUE(waitForSubscribers(compressor->name(), compressed, 1));
}

void
StreamScenario::startDecompressor(const Parameters& parameters,
                                  const std::vector<std::string>& arguments)
{
  decompressor.emplace("intensity_decompressor",
                       full("decompressor"),
                       Parameters{{"streams", listOf({compressed})}} + parameters,
                       arguments);
  EXPECT_TRUE(waitForSubscribers(decompressor->name(), voxels.topic(), 1))
      << decompressor->output();
  if (compressor && compressor->isRunning()) {
    EXPECT_TRUE(waitForSubscribers(compressor->name(), compressed, 2));
  }
}

void
StreamScenario::startBoth(const Parameters& parameters)
{
  transforms.set(sensor_frame, pose);
  startCompressor(parameters);
  startDecompressor();
}

CompressedPointCloud2::ConstPtr
StreamScenario::compress(const sensor_msgs::PointCloud2& cloud)
{
  clouds.publish(cloud);
  return frames.waitForOne([&](const CompressedPointCloud2& frame) {
    return frame.header.stamp == cloud.header.stamp;
  });
}

sensor_msgs::PointCloud2::ConstPtr
StreamScenario::show(const sensor_msgs::PointCloud2& cloud)
{
  clouds.publish(cloud);
  return voxels.waitForOne([&](const sensor_msgs::PointCloud2& message) {
    return message.header.stamp == cloud.header.stamp;
  });
}

void
StreamScenario::expectVoxels(const sensor_msgs::PointCloud2& cloud,
                             const Voxels& expected)
{
  const auto shown = show(cloud);
  ASSERT_TRUE(shown) << compressor->output() << decompressor->output();
  EXPECT_EQ(shown->header.frame_id, "world");
  EXPECT_EQ(shown->header.stamp.toNSec(), cloud.header.stamp.toNSec());
  // Not EXPECT_EQ, which would print thousands of voxels.
  EXPECT_TRUE(voxelsIn(*shown) == expected)
      << shown->width << " voxels, " << expected.size() << " expected";
}

} // namespace test
} // namespace pcl_ext_ros
