// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/point_types.h>

#include "simd/vector_choice.h"
#include "simulator/crop_box.h"
#include "support/cell_frames.h"
#include "support/message_layouts.h"
#include "support/node_tests.h"

#include <limits>

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::IntensityUnit;
using pcl_ext::NativeIntensity;
using pcl_ext::NoIntensity;
using pcl_ext::PointXYZRGBI;
using pcl_ext::SensorPreprocessor;
using pcl_ext::io::DepthLaw;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;

/** \brief Shares of a voxel face that the points bring along. */
struct GivenShare {
  static constexpr IntensityUnit unit = IntensityUnit::Share;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = true;

  explicit GivenShare(double /*resolution*/) {}

  float
  operator()(float /*depth*/, float native) const
  {
    return native;
  }
};

/** \brief A third of a turn about a diagonal, at a place that floats hold: clouds,
 * which have their pose in floats, lose nothing of it. */
WorldPose
exactPose(unsigned int frame)
{
  WorldPose pose = WorldPose::Identity();
  pose.linear().col(0) = Eigen::Vector3d(0.0, -1.0, 0.0);
  pose.linear().col(1) = Eigen::Vector3d(0.0, 0.0, -1.0);
  pose.linear().col(2) = Eigen::Vector3d(1.0, 0.0, 0.0);
  pose.translation() = Eigen::Vector3d(-3.0 - 0.25 * frame, 0.5, 0.125 * frame);
  return pose;
}

using ColouredCloud = pcl::PointCloud<PointXYZRGBI>;

/** \brief The points of cloudSeenFrom() with colours, one of which is not finite. */
ColouredCloud
colouredCloudSeenFrom(const WorldPose& pose, unsigned int seed)
{
  ColouredCloud cloud;
  std::uint32_t colour = seed;
  for (const pcl::PointXYZI& point : cloudSeenFrom(pose, seed)) {
    PointXYZRGBI& coloured = cloud.emplace_back();
    coloured.getVector3fMap() = point.getVector3fMap();
    coloured.intensity = point.intensity;
    coloured.rgba = 0xff000000u | (colour = colour * 1664525u + 1013904223u) >> 8;
  }
  cloud[3].y = std::numeric_limits<float>::quiet_NaN();
  return cloud;
}

/** \brief Expects the bytes of a node's stream to be those of a preprocessor and the
 * compression class. */
template <typename PreprocessingModelT, typename CompressionModelT>
void
expectBytesOfPipeline(const SensorNodeSettings& settings,
                      const PreprocessingModelT& preprocessing_model,
                      const std::optional<DepthLaw>& depth_law)
{
  SensorNode node(settings);
  const bool has_colours = settings.compression.format == StreamFormat::Version1;
  SensorPreprocessor<PreprocessingModelT, PointXYZRGBI> preprocessor(
      preprocessing_model);
  IntensityCompressionSettings codec;
  static_cast<pcl_ext::io::EncoderSettings&>(codec) = settings.compression;
  codec.carry_header = settings.carry_header;
  if (settings.crop_box) {
    preprocessor.setCropBox(Eigen::Vector3d(settings.crop_box->min.data()),
                            Eigen::Vector3d(settings.crop_box->max.data()));
    codec.bounding_box = settings.crop_box;
  }
  codec.depth_law = depth_law;
  OctreePointCloudIntensityCompression<PointXYZRGBI, CompressionModelT> compression(
      codec);
  for (unsigned int frame = 0; frame < 6; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    const WorldPose pose = exactPose(frame);
    const ColouredCloud seen = colouredCloudSeenFrom(pose, 30 + frame / 2);
    pcl::PCLPointCloud2 message = messageOf(seen, frame);
    const Bytes bytes = encoded(node, message, pose);

    message.header.frame_id = settings.global_frame;
    preprocessor.setSensorPose(Eigen::Isometry3d(pose));
    const ColouredCloud::Ptr preprocessed(new ColouredCloud);
    ASSERT_TRUE(preprocessor.process(message, *preprocessed).ok());
    const std::string expected = pcl_ext::test::encodeFrame(compression, preprocessed);
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), expected);
    const SensorNodeStatistics statistics = node.statistics();
    EXPECT_EQ(statistics.preprocessing.points, seen.size());
    EXPECT_EQ(statistics.preprocessing.points_not_finite, 1u);
    EXPECT_EQ(statistics.preprocessing.points_cropped,
              seen.size() - 1 - preprocessed->size());
    EXPECT_EQ(statistics.preprocessing.points_cropped > 100,
              settings.crop_box.has_value());
    EXPECT_EQ(statistics.frame.voxelization.points_used, preprocessed->size());
    EXPECT_EQ(statistics.preprocessing.has_colours, has_colours);
    EXPECT_EQ(statistics.frame.coding.attribute_bytes > 0, has_colours);
  }
}

TEST(SensorNode, BytesAreThoseOfThePipeline)
{
  using Quadratic = IntensityModel<RuntimeSensor, pcl_ext::QuadraticLaw>;
  using Linear = IntensityModel<RuntimeSensor, pcl_ext::LinearLaw>;
  const Quadratic quadratic(resolution, runtimeKinect());
  const Linear linear(resolution, runtimeKinect());
  std::vector<SensorNodeSettings> cases(5);
  cases[0].compression.effort = Effort::Fast;
  cases[1].compression.effort = Effort::Small;
  cases[2].compression.intensity_bits = 4;
  cases[3].crop_box = narrow_box;
  cases[4].compression.format = StreamFormat::Published;
  cases[4].crop_box = narrow_box;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE("case " + std::to_string(i));
    const auto settingsWith = [&](IntensityLaw law) {
      SensorNodeSettings settings = cases[i];
      settings.law = law;
      settings.sensor = runtimeKinect();
      settings.compression.resolution = resolution;
      settings.compression.colour_bits = 8;
      settings.carry_header = settings.compression.format == StreamFormat::Version1;
      settings.global_frame = "cell";
      return settings;
    };
    expectBytesOfPipeline<CountIntensity, CountIntensity>(
        settingsWith(IntensityLaw::Count), CountIntensity(resolution), std::nullopt);
    expectBytesOfPipeline<NativeIntensity, NativeIntensity>(
        settingsWith(IntensityLaw::Native), NativeIntensity(resolution), std::nullopt);
    expectBytesOfPipeline<NoIntensity, NoIntensity>(
        settingsWith(IntensityLaw::None), NoIntensity(resolution), std::nullopt);
    expectBytesOfPipeline<Quadratic, GivenShare>(
        settingsWith(IntensityLaw::Quadratic),
        quadratic,
        DepthLaw{2, quadratic.cutOffDepth(), 255.0});
    expectBytesOfPipeline<Linear, GivenShare>(settingsWith(IntensityLaw::Linear),
                                              linear,
                                              DepthLaw{1, linear.cutOffDepth(), 255.0});
  }
}

TEST(SensorNode, ReadsTheIntensityFieldOfTheSettings)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Native);
  SensorNode plain(settings);
  settings.intensity_field = "reflectivity";
  SensorNode node(settings);
  const pcl::PCLPointCloud2 cloud = messageOf(cloudSeenFrom(poseOf(0), 1));
  pcl::PCLPointCloud2 renamed = cloud;
  pcl_ext::test::fieldOf(renamed, "intensity").name = "reflectivity";
  EXPECT_EQ(encoded(node, renamed, poseOf(0)), encoded(plain, cloud, poseOf(0)));
  expectLeftOut(node, cloud, poseOf(0), SensorNodeCode::InvalidCloud);
}

TEST(SensorNode, ABoundingBoxOfItsOwnIsNotReplacedByTheCropBox)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.crop_box = wide_box;
  settings.compression.bounding_box = narrow_box;
  SensorNode node(settings);
  FrameDecoder decoder;
  const Cloud cloud = cloudSeenFrom(WorldPose::Identity(), 1);
  const Bytes bytes = encoded(node, messageOf(cloud), WorldPose::Identity());
  const Cloud inside =
      naivelyPreprocessed(cloud, WorldPose::Identity(), naiveCount, narrow_box);
  EXPECT_EQ(decodedWith(decoder, bytes).size(), naiveVoxels(inside, resolution).size());
  EXPECT_EQ(node.statistics().preprocessing.points_cropped, 0u);
  EXPECT_EQ(node.statistics().frame.voxelization.points_outside_box,
            cloud.size() - inside.size());
}

TEST(SensorNode, PointsOnTheFacesOfTheCropBoxAreInside)
{
  // Their floats are beyond these decimals, on some axis.
  const BoundingBox box{{-1.998, -0.3, 0.001}, {0.1, 1.997, 2.499}};
  Cloud corners;
  for (const BoundingBox& given : {box, BoundingBox{{0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}}})
    for (unsigned int corner = 0; corner < 8; ++corner) {
      const auto coordinate = [&](std::size_t axis) {
        return static_cast<float>((corner >> axis & 1) != 0 ? given.max[axis]
                                                            : given.min[axis]);
      };
      corners.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    }
  SensorNodeSettings settings = settingsOf(IntensityLaw::None);
  settings.crop_box = box;
  SensorNode node(settings);
  Bytes bytes;
  const auto status = node.encode(messageOf(corners), WorldPose::Identity(), bytes);
  EXPECT_EQ(status.message(), "");
  EXPECT_EQ(node.statistics().frame.voxelization.points_used, 8u);
}

TEST(SensorNode, CloudsOfWhichNothingIsLeftAreFramesWithoutVoxels)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Quadratic);
  settings.crop_box = BoundingBox{{50.0, 50.0, 50.0}, {51.0, 51.0, 51.0}};
  for (const StreamFormat format : {StreamFormat::Version1, StreamFormat::Published}) {
    settings.compression.format = format;
    SensorNode node(settings);
    FrameDecoder decoder;
    const std::vector<pcl::PCLPointCloud2> clouds = {
        messageOf(Cloud()), messageOf(cloudSeenFrom(poseOf(0), 1))};
    for (unsigned int frame = 0; frame < 4; ++frame)
      EXPECT_EQ(
          decodedWith(decoder, encoded(node, clouds[frame % 2], poseOf(0))).size(), 0u);
    EXPECT_EQ(node.statistics().frames, 4u);
    EXPECT_EQ(node.statistics().clouds_refused, 0u);
  }
}

TEST(SensorNode, IFramesComeByStampsOrWithoutThemByTheClock)
{
  FakeClock clock;
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.crop_box = wide_box;
  settings.compression.i_frame_every = 0.5;
  settings.clock = clock.clock();
  for (const bool has_stamps : {true, false}) {
    SensorNode node(settings);
    pcl::PCLPointCloud2 message = messageOf(cloudSeenFrom(poseOf(0), 1));
    FrameDecoder decoder;
    std::string frame_types;
    for (const int ms : {1000, 1300, 1499, 1501, 1900, 2001}) {
      clock.set(has_stamps ? Time(0) : Time(std::chrono::milliseconds(ms)));
      message.header.stamp = has_stamps ? static_cast<std::uint64_t>(ms) * 1000 : 0;
      decodedWith(decoder, encoded(node, message, poseOf(0)));
      frame_types += decoder.statistics().is_i_frame ? 'I' : 'P';
    }
    EXPECT_EQ(frame_types, "IPPIPI");
  }
}

TEST(SensorNodeStatistics, CountBytesPointsAndVoxels)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.crop_box = BoundingBox{{-0.2, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  SensorNode node(settings);
  std::uint64_t cloud_bytes = 0;
  std::uint64_t frame_bytes = 0;
  for (unsigned int frame = 0; frame < 5; ++frame) {
    const Cloud seen = cloudSeenFrom(poseOf(frame), frame, 500 + 100 * frame);
    const Cloud preprocessed =
        naivelyPreprocessed(seen, poseOf(frame), naiveCount, settings.crop_box);
    if (frame == 2)
      node.requestIFrame();
    const Bytes bytes = encoded(node, messageOf(seen), poseOf(frame));
    EXPECT_EQ(node.statistics().frame.coding.is_i_frame, frame == 0 || frame == 2);
    cloud_bytes += sizeof(pcl::PointXYZI) * seen.size();
    frame_bytes += bytes.size();
    const SensorNodeStatistics statistics = node.statistics();
    EXPECT_EQ(statistics.frames, frame + 1);
    EXPECT_EQ(statistics.i_frames, frame < 2 ? 1u : 2u);
    EXPECT_EQ(statistics.encode_times.count(), frame + 1);
    EXPECT_GT(statistics.encode_times.sum_seconds, 0.0);
    EXPECT_EQ(statistics.cloud_bytes, cloud_bytes);
    EXPECT_EQ(statistics.frame_bytes, frame_bytes);
    EXPECT_DOUBLE_EQ(statistics.compressionRatio(),
                     static_cast<double>(cloud_bytes) /
                         static_cast<double>(frame_bytes));
    EXPECT_EQ(statistics.preprocessing.points, seen.size());
    EXPECT_EQ(statistics.preprocessing.points_cropped,
              seen.size() - preprocessed.size());
    EXPECT_EQ(statistics.frame.voxelization.points, preprocessed.size());
    EXPECT_EQ(statistics.frame.coding.voxels,
              naiveVoxels(preprocessed, resolution).size());
    EXPECT_EQ(statistics.frame.coding.bytes, bytes.size());
    EXPECT_EQ(statistics.frame.coding.frame_number, frame + 1);
  }
  EXPECT_GT(node.statistics().preprocessing.points_cropped, 0u);
}

TEST(SensorNodeStatistics, RatesAndLatenciesAreOfTheClockOfTheSettings)
{
  FakeClock clock;
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.clock = clock.clock();
  SensorNode node(settings);
  std::vector<std::size_t> sizes;
  // A quarter of a second apart, ready 50, 80 and 20 ms behind their stamps.
  for (const auto& [stamp, ready] :
       {std::pair(7000, 7050ms), {7220, 7300ms}, {7530, 7550ms}}) {
    clock.set(ready);
    const auto microseconds = std::uint64_t{1000} * static_cast<unsigned int>(stamp);
    const Cloud seen = cloudSeenFrom(poseOf(0), static_cast<unsigned int>(stamp));
    sizes.push_back(encoded(node, messageOf(seen, microseconds), poseOf(0)).size());
  }
  // Clouds that are left out are no frames.
  clock.set(7600ms);
  expectLeftOut(
      node, pcl::PCLPointCloud2(), std::nullopt, SensorNodeCode::InvalidCloud);
  const StreamRates rates = node.statistics().rates;
  EXPECT_DOUBLE_EQ(rates.frames_per_second, 4.0);
  EXPECT_DOUBLE_EQ(rates.bytes_per_second,
                   static_cast<double>(sizes[1] + sizes[2]) / 0.5);
  EXPECT_DOUBLE_EQ(rates.mean_latency_seconds, 0.05);
  EXPECT_DOUBLE_EQ(rates.max_latency_seconds, 0.08);
  EXPECT_GT(rates.mean_cycle_seconds, 0.0);
  EXPECT_GE(rates.max_cycle_seconds, rates.mean_cycle_seconds);
  clock.set(10s);
  EXPECT_EQ(node.statistics().rates.frames_per_second, 0.0);
}

TEST(SensorNodeVectors, BytesAreTheSameWithAvx2AndWithout)
{
  if (!pcl_ext::hasAvx2())
    GTEST_SKIP() << "this machine has no AVX2";
  pcl_ext::cell::RobotCell cell;
  std::vector<pcl_ext::cell::CellFrame> frames;
  for (std::uint32_t i = 0; i < 3; ++i)
    frames.push_back(pcl_ext::cell::test::capture(cell, 1, i));
  const auto encode = [&](double voxel_edge, bool uses_avx2) {
    pcl_ext::may_use_avx2 = uses_avx2;
    EXPECT_EQ(pcl_ext::usesAvx2(), uses_avx2);
    SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
    settings.compression.resolution = voxel_edge;
    settings.crop_box = pcl_ext::cell::cropBox();
    SensorNode node(settings);
    std::vector<Bytes> stream;
    for (const auto& frame : frames)
      stream.push_back(encoded(node, messageOf(frame.cloud), WorldPose(frame.pose)));
    pcl_ext::may_use_avx2 = true;
    return stream;
  };
  // In the third case the points' voxels are computed by division.
  for (const double voxel_edge : {0.04, 0.005, 0.00001})
    EXPECT_EQ(encode(voxel_edge, false), encode(voxel_edge, true)) << voxel_edge;
}

} // namespace
