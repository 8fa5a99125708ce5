// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/message_layouts.h"
#include "support/naive_preprocessing.h"
#include "support/node_tests.h"

#include <functional>
#include <limits>

namespace {

using namespace pcl_ext::nodes::test;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

WorldVoxels
naiveCounts(const Cloud& seen, const WorldPose& pose)
{
  WorldVoxels counts;
  for (const auto& [index, voxel] :
       naiveVoxels(naivelyPreprocessed(seen, pose, naiveCount), resolution))
    counts[index] = voxel.sum;
  return counts;
}

class Link {
public:
  explicit Link(const SensorNodeSettings& settings = settingsOf(IntensityLaw::Count))
  : node(settings)
  {}

  void
  expectSent(const Cloud& seen,
             const std::optional<WorldPose>& pose,
             SensorNodeCode code,
             const WorldPose& used_pose)
  {
    Bytes bytes(7, 0xee);
    const SensorNodeStatus status = node.encode(messageOf(seen), pose, bytes);
    expectCode(status, code);
    EXPECT_TRUE(status.hasFrame());
    VoxelFrame frame;
    ASSERT_TRUE(decoder_.decode(bytes.data(), bytes.size(), frame).ok());
    EXPECT_EQ(worldVoxels(frame), naiveCounts(seen, used_pose));
  }

  SensorNode node;

private:
  FrameDecoder decoder_;
};

TEST(SensorNodeTransforms, TheLastOneHoldsForCloudsThatComeWithout)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.global_frame = "cell";
  Link link(settings);
  // Before the first one nothing is sent.
  const pcl::PCLPointCloud2 first = messageOf(cloudSeenFrom(poseOf(0), 1));
  expectLeftOut(link.node, first, std::nullopt, SensorNodeCode::NoTransform);
  Bytes bytes;
  EXPECT_EQ(
      link.node.encode(first, std::nullopt, bytes).message(),
      "there is no transform from the sensor to 'cell' yet; the cloud was not encoded");
  EXPECT_EQ(link.node.statistics().clouds_refused, 0u);
  EXPECT_EQ(link.node.statistics().frames, 0u);
  EXPECT_EQ(link.node.statistics().compressionRatio(), 0.0);
  for (unsigned int i = 0; i < 3; ++i) {
    link.expectSent(
        cloudSeenFrom(poseOf(i), 3 * i), poseOf(i), SensorNodeCode::Ok, poseOf(i));
    for (const unsigned int seed : {3 * i + 1, 3 * i + 2})
      link.expectSent(cloudSeenFrom(poseOf(i), seed),
                      std::nullopt,
                      SensorNodeCode::UsedLastTransform,
                      poseOf(i));
  }
  EXPECT_EQ(link.node.statistics().frames, 9u);
  EXPECT_EQ(link.node.statistics().frames_with_last_transform, 6u);
  EXPECT_EQ(link.node.statistics().clouds_without_transform, 2u);
}

TEST(SensorNodeTransforms, ABrokenOneIsRefusedAndTheLastGoodOneStays)
{
  const Cloud seen = cloudSeenFrom(poseOf(3), 1);
  for (const WorldPose& broken : pcl_ext::test::invalidPoses(poseOf(3))) {
    Link link;
    expectLeftOut(link.node, messageOf(seen), broken, SensorNodeCode::InvalidTransform);
    // Nor is it taken for one that is known.
    expectLeftOut(
        link.node, messageOf(seen), std::nullopt, SensorNodeCode::NoTransform);
    link.expectSent(seen, poseOf(3), SensorNodeCode::Ok, poseOf(3));
    expectLeftOut(link.node, messageOf(seen), broken, SensorNodeCode::InvalidTransform);
    link.expectSent(seen, std::nullopt, SensorNodeCode::UsedLastTransform, poseOf(3));
    EXPECT_EQ(link.node.statistics().clouds_refused, 2u);
    EXPECT_EQ(link.node.statistics().clouds_without_transform, 1u);
    EXPECT_EQ(link.node.statistics().frames, 2u);
  }
}

TEST(SensorNodeClouds, ABrokenOneIsRefusedAndTheStreamGoesOn)
{
  const pcl::PCLPointCloud2 good = messageOf(cloudSeenFrom(poseOf(0), 1));
  std::vector<pcl::PCLPointCloud2> broken(5, good);
  broken[0] = pcl::PCLPointCloud2();
  pcl_ext::test::fieldOf(broken[1], "z").name = "height";
  pcl_ext::test::fieldOf(broken[2], "y").datatype = pcl_ext::detail::bool_datatype;
  pcl_ext::test::fieldOf(broken[3], "x").offset = good.point_step - 2;
  broken[4].data.pop_back();
  Link link;
  const Cloud seen = cloudSeenFrom(poseOf(0), 2);
  link.expectSent(seen, poseOf(0), SensorNodeCode::Ok, poseOf(0));
  const SensorNodeStatistics before = link.node.statistics();
  for (const pcl::PCLPointCloud2& cloud : broken)
    expectLeftOut(link.node, cloud, poseOf(2), SensorNodeCode::InvalidCloud);
  const SensorNodeStatistics behind = link.node.statistics();
  EXPECT_EQ(behind.clouds_refused, broken.size());
  EXPECT_EQ(behind.frames, 1u);
  EXPECT_EQ(behind.cloud_bytes, before.cloud_bytes);
  EXPECT_EQ(behind.frame_bytes, before.frame_bytes);
  EXPECT_EQ(behind.preprocessing.points, seen.size()); // of the last frame
  // The transform of a broken one holds for the next.
  link.expectSent(cloudSeenFrom(poseOf(2), 3),
                  std::nullopt,
                  SensorNodeCode::UsedLastTransform,
                  poseOf(2));
}

void
expectInvalid(const SensorNodeSettings& settings, const std::string& message)
{
  SensorNode node(settings);
  expectCode(node.settingsStatus(), SensorNodeCode::InvalidSettings);
  EXPECT_EQ(node.settingsStatus().message(), message);
  const Cloud seen = cloudSeenFrom(poseOf(0), 1);
  expectLeftOut(node, messageOf(seen), poseOf(0), SensorNodeCode::InvalidSettings);
  Bytes bytes;
  EXPECT_EQ(node.encode(messageOf(seen), poseOf(0), bytes).message(), message);
  node.requestIFrame();
  EXPECT_EQ(node.statistics().frames, 0u);
  EXPECT_EQ(node.statistics().rates.frames_per_second, 0.0);
}

const BoundingBox too_wide_box{{-1e6, 0, 0}, {1e6, 1, 1}};

TEST(SensorNodeClouds, AnExceptionOfTheClockDropsTheFrame)
{
  const auto cloud = [](unsigned int seed) { return cloudSeenFrom(poseOf(0), seed); };
  FakeClock clock;
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.clock = clock.clock();
  SensorNode node(settings);
  FrameDecoder decoder;
  decodedWith(decoder, encoded(node, messageOf(cloud(1)), poseOf(0)));
  clock.setBroken(true);
  expectLeftOut(node, messageOf(cloud(2)), poseOf(0), SensorNodeCode::EncodingFailed);
  clock.setBroken(false);
  const VoxelFrame voxels =
      decodedWith(decoder, encoded(node, messageOf(cloud(3)), poseOf(0)));
  EXPECT_TRUE(decoder.statistics().is_i_frame);
  EXPECT_EQ(worldVoxels(voxels), naiveCounts(cloud(3), poseOf(0)));
}

TEST(SensorNodeSettings, InvalidOnesAreReported)
{
  expectCode(SensorNode(SensorNodeSettings()).settingsStatus(), SensorNodeCode::Ok);
  using Change = std::function<void(SensorNodeSettings&)>;
  const std::vector<std::pair<Change, std::string>> of_counts = {
      {[](auto& settings) { settings.law = static_cast<IntensityLaw>(7); },
       "law is 7; it must be one of count, quadratic, linear, native, none"},
      {[](auto& settings) { settings.clock = nullptr; },
       "clock is empty; it must be set"},
      {[](auto& settings) {
         settings.crop_box = BoundingBox{{0, 0, 2}, {1, 1, 1}};
       },
       "crop_box is 2.000000 to 1.000000; it must be finite, with min below max on "
       "each axis"},
      {[](auto& settings) { settings.crop_box = too_wide_box; },
       "crop_box as bounding_box is 2e+06 m wide; it must be no wider than 2^21 - 1 "
       "voxels, as with a resolution of 0.96"},
      {[](auto& settings) { settings.compression.resolution = 0.0; },
       "resolution is 0; it must be 1e-06 to 1e+06 m"},
      {[](auto& settings) {
         settings.compression.format = StreamFormat::Published;
         settings.carry_header = true;
       },
       "carry_header is on; it must be off in the published layout"},
      {[](auto& settings) {
         settings.carry_header = true;
         settings.global_frame = std::string(1025, 'w');
       },
       "global_frame is 1025 bytes long; it must be 1024 or less, for frames to carry "
       "it"}};
  const std::vector<std::pair<Change, std::string>> of_depths = {
      {[](auto& settings) { settings.sensor.reset(); },
       "sensor is not set; the quadratic and the linear law need its field of view and "
       "size"},
      {[](auto& settings) { settings.sensor->columns = 0; },
       "sensor: a sensor needs at least one column and one row"},
      {[](auto& settings) { settings.sensor->fov_y_deg = nan_value; },
       "sensor: field of view must be between 0 and 180 degrees, got nan"}};
  for (const auto& [law, cases] : {std::pair(IntensityLaw::Count, of_counts),
                                   std::pair(IntensityLaw::Quadratic, of_depths),
                                   std::pair(IntensityLaw::Linear, of_depths)})
    for (const auto& [change, message] : cases) {
      SensorNodeSettings settings = settingsOf(law);
      EXPECT_TRUE(SensorNode(settings).settingsStatus().ok());
      change(settings);
      expectInvalid(settings, message);
    }
  // What is not used is not checked: a sensor, the width of a crop box that the grid
  // does not follow from, the length of a name that is not carried.
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.sensor = runtimeKinect();
  settings.sensor->rows = 0;
  settings.crop_box = too_wide_box;
  settings.compression.bounding_box = BoundingBox{{0, 0, 0}, {1, 1, 1}};
  settings.global_frame = std::string(1025, 'w');
  EXPECT_TRUE(SensorNode(settings).settingsStatus().ok());
  settings.carry_header = true;
  settings.global_frame.pop_back();
  SensorNode node(settings);
  encoded(node, messageOf(cloudSeenFrom(poseOf(0), 1)), poseOf(0));
}

TEST(SensorNodeWarnings, ComeWithTheFrame)
{
  // A driver whose z axis points backwards: all depths are negative.
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (int i = 0; i < 20; ++i)
    cloud.emplace_back(0.1f * static_cast<float>(i), 0.0f, -2.0f, 1.0f);
  cloud.emplace_back(0.0f, 0.0f, 2.0f, 1.0f);
  SensorNode node(settingsOf(IntensityLaw::Quadratic));
  Bytes bytes;
  SensorNodeStatus status = node.encode(messageOf(cloud), poseOf(1), bytes);
  const std::string words = "20 of 21 points are behind the sensor";
  EXPECT_TRUE(status.hasWarning());
  EXPECT_NE(status.message().find(words), std::string::npos) << status;
  EXPECT_FALSE(bytes.empty());
  EXPECT_EQ(node.statistics().preprocessing.points_behind_sensor, 20u);
  status = node.encode(messageOf(cloud), std::nullopt, bytes);
  EXPECT_EQ(status.code(), SensorNodeCode::UsedLastTransform);
  EXPECT_NE(status.message().find(words), std::string::npos) << status;
  SensorNode counting(settingsOf(IntensityLaw::Count));
  expectCode(counting.encode(messageOf(cloud), poseOf(1), bytes), SensorNodeCode::Ok);
}

} // namespace
