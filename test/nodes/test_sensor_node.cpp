/** \file
 * \brief What a SensorNode sends: the voxels of each cloud with its transform, whatever
 * the law and the format.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "support/message_layouts.h"
#include "support/sensor_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using pcl_ext::IntensityLaw;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::IntensityUnit;
using pcl_ext::NativeIntensity;
using pcl_ext::RuntimeSensor;
using pcl_ext::SensorPreprocessor;
using pcl_ext::WorldPose;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::DepthLaw;
using pcl_ext::io::Effort;
using pcl_ext::io::FrameDecoder;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::io::StreamFormat;
using pcl_ext::io::VoxelFrame;
using pcl_ext::test::NaiveVoxel;
using pcl_ext::test::NaiveVoxels;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::WorldVoxels;
using pcl_ext::test::worldVoxels;

/** \brief A law, and what it makes of points and voxels. */
struct LawCase {
  const char* name;
  IntensityLaw law;
  PointIntensity intensity_of_point;
  double unit_factor; ///< from the sum of a voxel's points to what is decoded
  bool is_mean;       ///< in Version1

  /** \brief Of a voxel as it would be without quantisation. */
  double
  intensityOf(const NaiveVoxel& voxel, StreamFormat format) const
  {
    const bool takes_mean = is_mean && format == StreamFormat::Version1;
    const double value = takes_mean ? voxel.mean() : unit_factor * voxel.sum;
    return std::min(value, 255.0);
  }
};

std::ostream&
operator<<(std::ostream& output, const LawCase& law)
{
  return output << law.name;
}

class SensorNodeLaws
: public ::testing::TestWithParam<std::tuple<LawCase, StreamFormat>> {
protected:
  const LawCase&
  law() const
  {
    return std::get<0>(GetParam());
  }

  StreamFormat
  format() const
  {
    return std::get<1>(GetParam());
  }

  SensorNodeSettings
  settings() const
  {
    SensorNodeSettings settings = settingsOf(law().law);
    settings.compression.format = format();
    settings.compression.bounding_box = wide_box;
    return settings;
  }

  void
  expectVoxels(const VoxelFrame& frame, const NaiveVoxels& expected) const
  {
    const WorldVoxels voxels = worldVoxels(frame);
    ASSERT_EQ(voxels.size(), expected.size());
    double below = 0.0;
    double above = 0.0;
    for (const auto& [index, voxel] : expected) {
      const auto found = voxels.find(index);
      ASSERT_NE(found, voxels.end());
      const double error = found->second - law().intensityOf(voxel, format());
      below = std::min(below, error);
      above = std::max(above, error);
    }
    // Counts are exact; else steps are 1, and the published layout cuts them off.
    const double rounding = law().law == IntensityLaw::Count ? 0.0 : 1e-3;
    const double half_step = law().law == IntensityLaw::Count ? 0.0 : 0.5;
    const bool is_cut_off = format() == StreamFormat::Published;
    EXPECT_GE(below, -(is_cut_off ? 2.0 : 1.0) * half_step - rounding);
    EXPECT_LE(above, (is_cut_off ? 0.0 : half_step) + rounding);
  }
};

INSTANTIATE_TEST_SUITE_P(
    All,
    SensorNodeLaws,
    ::testing::Combine(
        ::testing::Values(
            LawCase{"Count", IntensityLaw::Count, naiveCount, 1.0, false},
            LawCase{"Quadratic", IntensityLaw::Quadratic, naiveQuadratic, 255.0, false},
            LawCase{"Linear", IntensityLaw::Linear, naiveLinear, 255.0, false},
            LawCase{"Native", IntensityLaw::Native, naiveNative, 1.0, true}),
        ::testing::Values(StreamFormat::Version1, StreamFormat::Published)),
    [](const auto& test) {
      return std::string(std::get<0>(test.param).name) +
             (std::get<1>(test.param) == StreamFormat::Version1 ? "Version1"
                                                                : "Published");
    });

TEST_P(SensorNodeLaws, FramesHoldTheVoxelsOfCloudsThatComeWithTheirTransforms)
{
  SensorNode node(settings());
  FrameDecoder decoder;
  for (unsigned int frame = 0; frame < 5; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    const WorldPose pose = poseOf(frame);
    Cloud seen = cloudSeenFrom(pose, 10 + frame);
    seen[3].y = std::numeric_limits<float>::quiet_NaN();
    const Bytes bytes = encoded(node, messageOf(seen), pose);
    const Cloud preprocessed =
        naivelyPreprocessed(seen, pose, law().intensity_of_point, wide_box);
    ASSERT_EQ(preprocessed.size(), seen.size() - 1);
    expectVoxels(decodedWith(decoder, bytes), naiveVoxels(preprocessed, resolution));
  }
}

TEST_P(SensorNodeLaws, CropsInTheWorld)
{
  SensorNodeSettings cropped = settings();
  cropped.crop_box = narrow_box;
  SensorNode node(cropped);
  FrameDecoder decoder;
  for (unsigned int frame = 0; frame < 3; ++frame) {
    const WorldPose pose = poseOf(frame);
    const Cloud seen = cloudSeenFrom(pose, 20 + frame);
    const Cloud preprocessed =
        naivelyPreprocessed(seen, pose, law().intensity_of_point, narrow_box);
    ASSERT_GT(preprocessed.size(), 100u);
    ASSERT_LT(preprocessed.size(), seen.size() - 100);
    const Bytes bytes = encoded(node, messageOf(seen), pose);
    expectVoxels(decodedWith(decoder, bytes), naiveVoxels(preprocessed, resolution));
    const SensorNodeStatistics statistics = node.statistics();
    EXPECT_EQ(statistics.preprocessing.points, seen.size());
    EXPECT_EQ(statistics.preprocessing.points_cropped,
              seen.size() - preprocessed.size());
    EXPECT_EQ(statistics.frame.voxelization.points_used, preprocessed.size());
  }
}

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

/** \brief A third of a turn about a diagonal, at a place that floats hold: what goes
 * through the clouds' floats is then what the node knows in double. */
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

/** \brief Expects the bytes of a node's stream to be those of the pipeline that a program
 * would write itself. */
template <typename PreprocessingModelT, typename CompressionModelT>
void
expectBytesOfPipeline(const SensorNodeSettings& settings,
                      const PreprocessingModelT& preprocessing_model,
                      const std::optional<DepthLaw>& depth_law)
{
  SensorNode node(settings);
  SensorPreprocessor<PreprocessingModelT> preprocessor(preprocessing_model);
  IntensityCompressionSettings codec = settings.compression;
  codec.depth_law = depth_law;
  OctreePointCloudIntensityCompression<pcl::PointXYZI, CompressionModelT> compression(
      codec);
  for (unsigned int frame = 0; frame < 6; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    const WorldPose pose = exactPose(frame);
    pcl::PCLPointCloud2 message = messageOf(cloudSeenFrom(pose, 30 + frame / 2), frame);
    const Bytes bytes = encoded(node, message, pose);

    message.header.frame_id = settings.global_frame;
    preprocessor.setSensorPose(Eigen::Isometry3d(pose));
    const Cloud::Ptr preprocessed(new Cloud);
    ASSERT_TRUE(preprocessor.process(message, *preprocessed).ok());
    const std::string expected = pcl_ext::test::encodeFrame(compression, preprocessed);
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), expected);
  }
}

TEST(SensorNode, BytesAreThoseOfThePipeline)
{
  using Quadratic = IntensityModel<RuntimeSensor, pcl_ext::QuadraticLaw>;
  using Linear = IntensityModel<RuntimeSensor, pcl_ext::LinearLaw>;
  const Quadratic quadratic(resolution, runtimeKinect());
  const Linear linear(resolution, runtimeKinect());
  for (const Effort effort : {Effort::Fast, Effort::Balanced, Effort::Small})
    for (const unsigned int bits : {0u, 4u}) {
      SCOPED_TRACE("effort " + std::to_string(static_cast<int>(effort)) + ", bits " +
                   std::to_string(bits));
      const auto settingsWith = [&](IntensityLaw law) {
        SensorNodeSettings settings = settingsOf(law);
        settings.compression.effort = effort;
        settings.compression.intensity_bits = bits;
        settings.compression.carry_header = true;
        settings.global_frame = "cell";
        return settings;
      };
      expectBytesOfPipeline<CountIntensity, CountIntensity>(
          settingsWith(IntensityLaw::Count), CountIntensity(resolution), std::nullopt);
      expectBytesOfPipeline<NativeIntensity, NativeIntensity>(
          settingsWith(IntensityLaw::Native),
          NativeIntensity(resolution),
          std::nullopt);
      expectBytesOfPipeline<Quadratic, GivenShare>(
          settingsWith(IntensityLaw::Quadratic),
          quadratic,
          DepthLaw{2, quadratic.cutOffDepth(), 255.0});
      expectBytesOfPipeline<Linear, GivenShare>(
          settingsWith(IntensityLaw::Linear),
          linear,
          DepthLaw{1, linear.cutOffDepth(), 255.0});
    }
}

TEST(SensorNode, ReadsTheIntensityFieldOfTheSettings)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Native);
  settings.intensity_field = "reflectivity";
  settings.compression.bounding_box = BoundingBox{{-10, -10, -10}, {10, 10, 10}};
  SensorNode node(settings);
  using pcl_ext::test::makeField;
  const pcl::PCLPointCloud2 message = pcl_ext::test::makeMessage(
      {makeField("x", 0, pcl::PCLPointField::FLOAT32),
       makeField("y", 4, pcl::PCLPointField::FLOAT32),
       makeField("reflectivity", 8, pcl::PCLPointField::UINT16),
       makeField("z", 12, pcl::PCLPointField::FLOAT32)},
      20,
      9);
  FrameDecoder decoder;
  const VoxelFrame frame =
      decodedWith(decoder, encoded(node, message, WorldPose::Identity()));
  std::multiset<double> intensities;
  for (const auto& voxel : worldVoxels(frame))
    intensities.insert(voxel.second);
  EXPECT_EQ(intensities, (std::multiset<double>{0, 7, 14, 21, 28, 35, 42, 49, 56}));

  pcl::PCLPointCloud2 without = message;
  pcl_ext::test::fieldOf(without, "reflectivity").name = "intensity";
  expectLeftOut(node, without, WorldPose::Identity(), SensorNodeCode::InvalidCloud);
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

} // namespace
