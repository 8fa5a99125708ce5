/** \file
 * \brief Memory that runs out at any point of PCL's face on the codec: nothing is
 * thrown, and nothing wrong follows.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"
#include "support/test_memory.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <sstream>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;
using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

constexpr double coarse_resolution = 0.1;
constexpr unsigned int cloud_count = 4;

IntensityCompressionSettings
settings()
{
  IntensityCompressionSettings settings = settingsWith(coarse_resolution);
  settings.i_frame_rate = 3;
  settings.effort = Effort::Fast;
  settings.carry_header = true;
  settings.retain_octree = true;
  return settings;
}

/** \brief Clouds whose extent and number of points change. */
std::vector<Cloud::Ptr>
clouds()
{
  std::vector<Cloud::Ptr> clouds;
  for (unsigned int i = 0; i < cloud_count; ++i) {
    const double half_width = 0.5 + 0.5 * i;
    clouds.push_back(
        randomCloud<pcl::PointXYZI>(i, 60 + 40 * i, {1.0, 1.0, 1.0}, half_width));
    clouds.back()->header.stamp = 1000 * i;
    clouds.back()->header.frame_id = "a frame whose name has a length";
  }
  return clouds;
}

void
expectVoxels(const Cloud& decoded, const Cloud& cloud)
{
  const NaiveVoxels voxels = naiveVoxels(cloud, coarse_resolution);
  expectVoxelCentres(decoded, voxels, coarse_resolution);
  expectIntensities(
      decoded,
      voxels,
      coarse_resolution,
      [](const NaiveVoxel& voxel) { return voxel.mean(); },
      0.5001);
}

/** \brief Encodes all clouds and decodes what was encoded, while the memory fails at
 * one cloud, on one side.
 * \return false if that call has no n-th allocation
 */
bool
runWithFailure(std::size_t failing_cloud,
               bool fails_at_encoder,
               std::size_t n,
               bool do_later_ones_fail)
{
  const std::vector<Cloud::Ptr> all = clouds();
  Compression encoder(settings());
  Compression decoder(settings());
  bool has_failed = false;
  bool must_be_i_frame = false;
  bool is_known = true;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::stringstream stream;
    CompressionStatus status;
    const bool fails_here = i == failing_cloud && fails_at_encoder;
    {
      const FailingAllocation failing(fails_here ? n : 0, do_later_ones_fail);
      status = encoder.encodePointCloud(all[i], stream);
      has_failed = has_failed || (fails_here && failing.hasFailed());
    }
    if (!status.ok()) {
      EXPECT_EQ(i, failing_cloud);
      // A stream's own memory may fail, too.
      EXPECT_TRUE(status.code() == CompressionCode::OutOfMemory ||
                  status.code() == CompressionCode::OutputFailed)
          << status.message();
      must_be_i_frame = true;
      continue;
    }
    const bool is_i_frame = encoder.statistics().coding.is_i_frame;
    EXPECT_TRUE(is_i_frame || !must_be_i_frame);
    must_be_i_frame = false;
    Cloud::Ptr decoded(new Cloud);
    const bool decoder_fails_here = i == failing_cloud && !fails_at_encoder;
    {
      const FailingAllocation failing(decoder_fails_here ? n : 0, do_later_ones_fail);
      status = decoder.decodePointCloud(stream, decoded);
      has_failed = has_failed || (decoder_fails_here && failing.hasFailed());
    }
    if (status.ok()) {
      expectVoxels(*decoded, *all[i]);
      EXPECT_EQ(decoded->header.stamp, all[i]->header.stamp);
      EXPECT_EQ(decoder.getLeafCount(), decoded->size());
    }
    else {
      EXPECT_TRUE(decoded->empty());
      EXPECT_FALSE(is_known && is_i_frame && i != failing_cloud) << status.message();
    }
    is_known = status.ok() || is_i_frame;
  }
  return has_failed;
}

TEST(CompressionFailingMemory, IsReportedAndTheStreamGoesOn)
{
  for (const bool fails_at_encoder : {true, false}) {
    SCOPED_TRACE(fails_at_encoder ? "encoder" : "decoder");
    expectFailuresHandled(
        cloud_count, 5, [&](std::size_t cloud, std::size_t n, bool do_later_ones_fail) {
          return runWithFailure(cloud, fails_at_encoder, n, do_later_ones_fail);
        });
  }
}

} // namespace
