#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/status.h>

#include <pcl/compression/compression_profiles.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cfloat>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

using pcl_ext::io::Aggregation;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::checkSettings;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::CompressionStatus;
using pcl_ext::io::Effort;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::IntensityCurve;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::io::StreamFormat;

using Settings = IntensityCompressionSettings;
using Change = std::function<void(Settings&)>;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

CompressionStatus
statusAfter(const Change& change, const Settings& start = Settings())
{
  Settings settings = start;
  change(settings);
  return checkSettings(settings);
}

void
expectAccepted(const Change& change, const Settings& start = Settings())
{
  const CompressionStatus status = statusAfter(change, start);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status.message().empty()) << status.message();
}

void
expectRefused(const std::string& field,
              const Change& change,
              const Settings& start = Settings())
{
  const CompressionStatus status = statusAfter(change, start);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(static_cast<int>(status.code()),
            static_cast<int>(CompressionCode::InvalidSettings));
  EXPECT_NE(status.message().find(field), std::string::npos)
      << "'" << field << "' is not in: " << status.message();
}

Settings
publishedSettings()
{
  Settings settings;
  settings.format = StreamFormat::Published;
  return settings;
}

Settings
settingsWithBox(const BoundingBox& box, double resolution = 0.01)
{
  Settings settings;
  settings.resolution = resolution;
  settings.bounding_box = box;
  return settings;
}

TEST(CompressionSettings, DefaultsAreTheDocumentedOnesAndValid)
{
  const Settings settings;
  EXPECT_EQ(settings.resolution, 0.01);
  EXPECT_EQ(settings.i_frame_rate, 30u);
  EXPECT_EQ(settings.effort, Effort::Balanced);
  EXPECT_EQ(settings.format, StreamFormat::Version1);
  EXPECT_EQ(settings.aggregation, Aggregation::Automatic);
  EXPECT_EQ(settings.intensity_range, 0.0f);
  EXPECT_EQ(settings.intensity_bits, 0u);
  EXPECT_EQ(settings.intensity_curve, IntensityCurve::Linear);
  EXPECT_FALSE(settings.bounding_box.has_value());
  EXPECT_FALSE(settings.sensor_pose.has_value());
  EXPECT_FALSE(settings.carry_header);
  EXPECT_FALSE(settings.retain_octree);
  EXPECT_FALSE(settings.show_statistics);
  EXPECT_EQ(settings.decoder_limits.max_frame_bytes, std::size_t{1} << 24);
  EXPECT_EQ(settings.decoder_limits.max_voxels, std::size_t{1} << 20);
  EXPECT_TRUE(checkSettings(settings).ok());
  EXPECT_TRUE(checkSettings(publishedSettings()).ok());
}

TEST(CompressionSettings, ResolutionMustBeALength)
{
  for (const double good : {1e-6, 0.001, 0.04, 1.0, 1000.0, 1e6})
    expectAccepted([good](Settings& settings) { settings.resolution = good; });
  for (const double bad : {0.0,
                           -0.0,
                           -0.01,
                           9.9e-7,
                           1.01e6,
                           1e39,
                           DBL_MAX,
                           infinity,
                           -infinity,
                           not_a_number})
    expectRefused("resolution",
                  [bad](Settings& settings) { settings.resolution = bad; });
}

TEST(CompressionSettings, FinestAndCoarsestVoxelsHoldTheirPoint)
{
  for (const double resolution : {1e-6, 1e6}) {
    SCOPED_TRACE(resolution);
    Settings settings;
    settings.resolution = resolution;
    OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(settings);
    const pcl::PointXYZ point(0.5f, -0.25f, 0.75f);
    const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(
        new pcl::PointCloud<pcl::PointXYZ>(1, 1, point));
    std::stringstream stream;
    ASSERT_TRUE(compression.encodePointCloud(cloud, stream).ok());
    pcl::PointCloud<pcl::PointXYZ>::Ptr decoded;
    ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
    EXPECT_TRUE(decoded->is_dense);
    ASSERT_EQ(decoded->size(), 1u);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR((*decoded)[0].data[axis], point.data[axis], 0.5 * resolution + 1e-7);
  }
}

TEST(CompressionSettings, EveryIFrameRateWillDo)
{
  for (const unsigned int rate : {0u, 1u, 2u, 30u, 4294967295u})
    expectAccepted([rate](Settings& settings) { settings.i_frame_rate = rate; });
}

TEST(CompressionSettings, EveryEffortAndAggregationWillDo)
{
  for (const Effort effort : {Effort::Fast, Effort::Balanced, Effort::Small})
    expectAccepted([effort](Settings& settings) { settings.effort = effort; });
  for (const Aggregation aggregation :
       {Aggregation::Automatic, Aggregation::Sum, Aggregation::Mean}) {
    expectAccepted(
        [aggregation](Settings& settings) { settings.aggregation = aggregation; });
    expectAccepted(
        [aggregation](Settings& settings) { settings.aggregation = aggregation; },
        publishedSettings());
  }
}

TEST(CompressionSettings, AnEffortThatIsNoneIsRefused)
{
  for (const int effort : {-1, 3, 7, 255})
    expectRefused("effort", [effort](Settings& settings) {
      settings.effort = static_cast<Effort>(effort);
    });
}

TEST(CompressionSettings, IntensityRangeMustBeZeroOrPositive)
{
  for (const float good : {0.0f, -0.0f, 1e-3f, 1.0f, 65535.0f, FLT_MAX})
    expectAccepted([good](Settings& settings) { settings.intensity_range = good; });
  for (const float bad : {-1e-30f,
                          -1.0f,
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()})
    expectRefused("intensity_range",
                  [bad](Settings& settings) { settings.intensity_range = bad; });
}

TEST(CompressionSettings, AnyPositiveIntensityRangeCanBeEncoded)
{
  for (const float range : {std::numeric_limits<float>::denorm_min(),
                            FLT_MIN,
                            1e-30f,
                            1.0f,
                            1e30f,
                            FLT_MAX})
    for (const unsigned int choice : {0u, 1u, 8u, 16u, 100u, 101u, 108u, 116u}) {
      const unsigned int bits = choice % 100;
      Settings settings;
      settings.intensity_range = range;
      settings.intensity_bits = bits;
      if (choice >= 100)
        settings.intensity_curve = IntensityCurve::Companded;
      ASSERT_TRUE(checkSettings(settings).ok());
      pcl::PointXYZI point;
      point.getVector3fMap().setZero();
      point.intensity = range / 2.0f;
      const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(
          new pcl::PointCloud<pcl::PointXYZI>(1, 1, point));
      OctreePointCloudIntensityCompression<pcl::PointXYZI> compression(settings);
      std::ostringstream stream;
      const CompressionStatus status = compression.encodePointCloud(cloud, stream);
      EXPECT_TRUE(status.ok())
          << "range " << range << ", " << bits << " bits: " << status.message();
    }
}

TEST(CompressionSettings, IntensityBitsMustBeAtMostSixteen)
{
  for (unsigned int bits = 0; bits <= 16; ++bits)
    expectAccepted([bits](Settings& settings) { settings.intensity_bits = bits; });
  for (const unsigned int bits : {17u, 32u, 4294967295u})
    expectRefused("intensity_bits",
                  [bits](Settings& settings) { settings.intensity_bits = bits; });
}

TEST(CompressionSettings, BoundingBoxMustHaveAnExtentOnEachAxis)
{
  const BoundingBox good{{-1.0, -2.0, -3.0}, {1.0, 2.0, 3.0}};
  expectAccepted([&](Settings& settings) { settings.bounding_box = good; });
  expectAccepted([&](Settings& settings) { settings.bounding_box = good; },
                 publishedSettings());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double bad_min :
         {good.max[axis], good.max[axis] + 0.5, infinity, -infinity, not_a_number}) {
      BoundingBox box = good;
      box.min[axis] = bad_min;
      expectRefused("bounding_box",
                    [&](Settings& settings) { settings.bounding_box = box; });
      expectRefused(
          "bounding_box",
          [&](Settings& settings) { settings.bounding_box = box; },
          publishedSettings());
    }
    for (const double bad_max :
         {good.min[axis], good.min[axis] - 0.5, infinity, -infinity, not_a_number}) {
      BoundingBox box = good;
      box.max[axis] = bad_max;
      expectRefused("bounding_box",
                    [&](Settings& settings) { settings.bounding_box = box; });
    }
  }
}

TEST(CompressionSettings, BoundingBoxMayBeUpToTheGridsWidth)
{
  const double most_voxels = 2097151.0; // 2^21 - 1
  for (std::size_t axis = 0; axis < 3; ++axis) {
    BoundingBox box{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
    box.min[axis] = -1048576.0 * 0.5;
    box.max[axis] = box.min[axis] + most_voxels * 0.5;
    expectAccepted([](Settings&) {}, settingsWithBox(box, 0.5));
    box.max[axis] += 0.5;
    expectRefused(
        "bounding_box", [](Settings&) {}, settingsWithBox(box, 0.5));
    box.max[axis] = 1e300;
    box.min[axis] = -1e300;
    expectRefused(
        "bounding_box", [](Settings&) {}, settingsWithBox(box, 0.5));
    box.max[axis] = DBL_MAX;
    box.min[axis] = -DBL_MAX;
    expectRefused(
        "bounding_box", [](Settings&) {}, settingsWithBox(box, 0.5));
  }
}

TEST(CompressionSettings, BoundingBoxIsJudgedAgainstTheResolution)
{
  const BoundingBox box{{-50.0, -50.0, -50.0}, {50.0, 50.0, 50.0}};
  expectAccepted([](Settings&) {}, settingsWithBox(box, 0.001));
  expectRefused(
      "bounding_box", [](Settings&) {}, settingsWithBox(box, 0.00001));
}

TEST(CompressionSettings, SensorPoseMustBeFinite)
{
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translate(Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  pose.rotate(Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()));
  expectAccepted([&](Settings& settings) { settings.sensor_pose = pose; });
  for (const auto bad : {std::numeric_limits<float>::quiet_NaN(),
                         std::numeric_limits<float>::infinity()}) {
    Eigen::Isometry3f bad_rotation = pose;
    bad_rotation.linear()(2, 1) = bad;
    expectRefused("sensor_pose",
                  [&](Settings& settings) { settings.sensor_pose = bad_rotation; });
    Eigen::Isometry3f bad_translation = pose;
    bad_translation.translation().z() = bad;
    expectRefused("sensor_pose",
                  [&](Settings& settings) { settings.sensor_pose = bad_translation; });
  }
}

TEST(CompressionSettings, SensorPoseMustBeRigid)
{
  // As SensorPreprocessor demands it: a stretched optical axis stretches the depth.
  Eigen::Isometry3f stretched = Eigen::Isometry3f::Identity();
  stretched.linear() *= 2.0f;
  expectRefused("sensor_pose",
                [&](Settings& settings) { settings.sensor_pose = stretched; });
  Eigen::Isometry3f collapsed = Eigen::Isometry3f::Identity();
  collapsed.linear().setZero();
  expectRefused("sensor_pose",
                [&](Settings& settings) { settings.sensor_pose = collapsed; });
}

TEST(CompressionSettings, DecoderLimitsMustBeAboveZero)
{
  expectAccepted([](Settings& settings) {
    settings.decoder_limits.max_frame_bytes = 1;
    settings.decoder_limits.max_voxels = 1;
  });
  expectAccepted([](Settings& settings) {
    settings.decoder_limits.max_frame_bytes = std::numeric_limits<std::size_t>::max();
    settings.decoder_limits.max_voxels = std::numeric_limits<std::size_t>::max();
  });
  expectRefused("max_frame_bytes", [](Settings& settings) {
    settings.decoder_limits.max_frame_bytes = 0;
  });
  expectRefused("max_voxels",
                [](Settings& settings) { settings.decoder_limits.max_voxels = 0; });
}

TEST(CompressionSettings, PublishedLayoutHasEightBitsAndItsOwnScale)
{
  expectAccepted([](Settings& settings) { settings.intensity_bits = 8; },
                 publishedSettings());
  for (unsigned int bits = 1; bits <= 16; ++bits)
    if (bits != 8)
      expectRefused(
          "intensity_bits",
          [bits](Settings& settings) { settings.intensity_bits = bits; },
          publishedSettings());
  for (const float range : {1e-3f, 1.0f, 255.0f})
    expectRefused(
        "intensity_range",
        [range](Settings& settings) { settings.intensity_range = range; },
        publishedSettings());
}

TEST(CompressionSettings, PublishedLayoutHasALinearScale)
{
  for (unsigned int bits = 0; bits <= 16; ++bits)
    expectAccepted([bits](Settings& settings) {
      settings.intensity_curve = IntensityCurve::Companded;
      settings.intensity_bits = bits;
    });
  expectRefused(
      "intensity_curve",
      [](Settings& settings) { settings.intensity_curve = IntensityCurve::Companded; },
      publishedSettings());
}

TEST(CompressionSettings, PublishedLayoutCarriesNoHeader)
{
  expectAccepted([](Settings& settings) { settings.carry_header = true; });
  expectRefused(
      "carry_header",
      [](Settings& settings) { settings.carry_header = true; },
      publishedSettings());
}

TEST(CompressionSettings, SwitchesAreFree)
{
  expectAccepted([](Settings& settings) { settings.retain_octree = true; });
  expectAccepted([](Settings& settings) { settings.show_statistics = true; });
  expectAccepted([](Settings& settings) { settings.retain_octree = true; },
                 publishedSettings());
}

TEST(CompressionSettings, MessagesShowTheValue)
{
  EXPECT_NE(statusAfter([](Settings& settings) { settings.resolution = -0.25; })
                .message()
                .find("-0.25"),
            std::string::npos);
  EXPECT_NE(statusAfter([](Settings& settings) { settings.intensity_bits = 17; })
                .message()
                .find("17"),
            std::string::npos);
  EXPECT_NE(statusAfter([](Settings& settings) { settings.intensity_range = -3.5f; })
                .message()
                .find("-3.5"),
            std::string::npos);
}

/** \brief A profile of PCL and the effort that it stands for. */
struct ProfileCase {
  pcl::io::compression_Profiles_e profile;
  Effort effort;
};

const std::vector<ProfileCase> all_profiles = {
    {pcl::io::LOW_RES_ONLINE_COMPRESSION_WITHOUT_COLOR, Effort::Balanced},
    {pcl::io::LOW_RES_ONLINE_COMPRESSION_WITH_COLOR, Effort::Balanced},
    {pcl::io::MED_RES_ONLINE_COMPRESSION_WITHOUT_COLOR, Effort::Balanced},
    {pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR, Effort::Balanced},
    {pcl::io::HIGH_RES_ONLINE_COMPRESSION_WITHOUT_COLOR, Effort::Balanced},
    {pcl::io::HIGH_RES_ONLINE_COMPRESSION_WITH_COLOR, Effort::Balanced},
    {pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR, Effort::Small},
    {pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITH_COLOR, Effort::Small},
    {pcl::io::MED_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR, Effort::Small},
    {pcl::io::MED_RES_OFFLINE_COMPRESSION_WITH_COLOR, Effort::Small},
    {pcl::io::HIGH_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR, Effort::Small},
    {pcl::io::HIGH_RES_OFFLINE_COMPRESSION_WITH_COLOR, Effort::Small}};

TEST(CompressionProfiles, ProfilesSetWhatPclsProfilesSet)
{
  ASSERT_EQ(all_profiles.size(),
            static_cast<std::size_t>(pcl::io::COMPRESSION_PROFILE_COUNT));
  for (const ProfileCase& test_case : all_profiles) {
    const auto& pcls = pcl::io::compressionProfiles_[test_case.profile];
    // The other arguments must not matter.
    const OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(
        test_case.profile, false, 0.5, 0.123, true, 7, false, 2);
    SCOPED_TRACE("profile " + std::to_string(test_case.profile));
    EXPECT_EQ(compression.getSettings().resolution, pcls.octreeResolution);
    EXPECT_EQ(compression.getSettings().i_frame_rate, pcls.iFrameRate);
    EXPECT_EQ(compression.getSettings().effort, test_case.effort);
    EXPECT_EQ(compression.getResolution(), pcls.octreeResolution);
    EXPECT_EQ(compression.getIntensityModel().resolution(), pcls.octreeResolution);
    EXPECT_FALSE(compression.getSettings().show_statistics);
    EXPECT_EQ(compression.getSettings().format, StreamFormat::Version1);
    EXPECT_TRUE(checkSettings(compression.getSettings()).ok());
  }
}

TEST(CompressionProfiles, ManualConfigurationTakesTheArguments)
{
  const OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(
      pcl::io::MANUAL_CONFIGURATION, true, 0.5, 0.123, true, 7, false, 2);
  EXPECT_EQ(compression.getSettings().resolution, 0.123);
  EXPECT_EQ(compression.getSettings().i_frame_rate, 7u);
  EXPECT_EQ(compression.getSettings().effort, Effort::Balanced);
  EXPECT_TRUE(compression.getSettings().show_statistics);
  EXPECT_EQ(compression.getResolution(), 0.123);
}

TEST(CompressionProfiles, ManualConfigurationHasPclsDefaults)
{
  const OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(
      pcl::io::MANUAL_CONFIGURATION);
  EXPECT_EQ(compression.getSettings().resolution, 0.01);
  EXPECT_EQ(compression.getSettings().i_frame_rate, 30u);
}

TEST(CompressionProfiles, TheDefaultIsPclsDefault)
{
  const OctreePointCloudIntensityCompression<pcl::PointXYZ> compression;
  const auto& pcls =
      pcl::io::compressionProfiles_[pcl::io::MED_RES_ONLINE_COMPRESSION_WITH_COLOR];
  EXPECT_EQ(compression.getSettings().resolution, pcls.octreeResolution);
  EXPECT_EQ(compression.getSettings().i_frame_rate, pcls.iFrameRate);
  EXPECT_FALSE(compression.getSettings().show_statistics);
}

TEST(CompressionProfiles, AnInvalidManualResolutionIsReportedNotThrown)
{
  for (const double resolution : {0.0, -1.0, infinity, not_a_number}) {
    OctreePointCloudIntensityCompression<pcl::PointXYZ> compression(
        pcl::io::MANUAL_CONFIGURATION, false, 0.001, resolution);
    std::stringstream stream;
    pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
    CompressionStatus status = compression.encodePointCloud(cloud, stream);
    EXPECT_EQ(status.code(), CompressionCode::InvalidSettings);
    EXPECT_NE(status.message().find("resolution"), std::string::npos);
    EXPECT_TRUE(stream.str().empty());
    EXPECT_EQ(compression.decodePointCloud(stream, cloud).code(),
              CompressionCode::InvalidSettings);
  }
}

TEST(CompressionStatus, DefaultIsPlainSuccess)
{
  const CompressionStatus status;
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status.message().empty());
}

TEST(CompressionStatus, KeepsCodeAndMessage)
{
  const CompressionStatus status(CompressionCode::Truncated, "the stream ends");
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(status.code(), CompressionCode::Truncated);
  EXPECT_EQ(status.message(), "the stream ends");
  const CompressionStatus copy = status;
  EXPECT_EQ(copy.code(), CompressionCode::Truncated);
  EXPECT_EQ(copy.message(), "the stream ends");
}

TEST(CompressionStatus, SuccessMayHaveSomethingToSay)
{
  const CompressionStatus status(CompressionCode::Ok, "with a remark");
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.message(), "with a remark");
}

TEST(CompressionStatus, NoCodeButOkIsSuccess)
{
  for (int code = static_cast<int>(CompressionCode::Ok) + 1;
       code <= static_cast<int>(CompressionCode::InputFailed);
       ++code)
    EXPECT_FALSE(CompressionStatus(static_cast<CompressionCode>(code), "").ok());
}

} // namespace
