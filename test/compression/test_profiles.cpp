/** \file
 * \brief The constructor that takes PCL's arguments: its profiles and defaults.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <pcl/compression/compression_profiles.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

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

} // namespace
