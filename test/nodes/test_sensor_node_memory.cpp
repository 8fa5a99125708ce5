/** \file
 * \brief A SensorNode of which each allocation fails in turn: the failure is reported, and
 * the next frame is a correct I-frame.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "support/fake_clock.h"
#include "support/sensor_clouds.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace {

using pcl_ext::IntensityLaw;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::FrameDecoder;
using pcl_ext::io::VoxelFrame;
using pcl_ext::io::test::expectSameFrame;
using pcl_ext::test::FailingAllocation;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::WorldVoxels;
using pcl_ext::test::worldVoxels;

constexpr unsigned int frame_count = 6;

/** \brief The sensor stands still; its clouds differ. */
std::vector<pcl::PCLPointCloud2>
messages()
{
  std::vector<pcl::PCLPointCloud2> clouds;
  for (unsigned int frame = 0; frame < frame_count; ++frame)
    clouds.push_back(messageOf(cloudSeenFrom(poseOf(0), frame + 1, 400, 5), 1000));
  return clouds;
}

struct SentFrame {
  VoxelFrame voxels;
  bool is_i_frame;
};

/** \brief What a node of these settings makes of clouds, from a frame on. */
std::vector<SentFrame>
framesFrom(std::size_t first,
           const std::vector<pcl::PCLPointCloud2>& clouds,
           const SensorNodeSettings& settings)
{
  SensorNode node(settings);
  FrameDecoder decoder;
  std::vector<SentFrame> frames;
  for (std::size_t i = first; i < clouds.size(); ++i) {
    const VoxelFrame voxels = decodedWith(decoder, encoded(node, clouds[i], poseOf(0)));
    EXPECT_GT(voxels.size(), 50u);
    EXPECT_GT(node.statistics().outliers_removed, 0u);
    frames.push_back({voxels, decoder.statistics().is_i_frame});
  }
  return frames;
}

/** \brief Has an allocation fail at one of the clouds.
 * \param[in] number of the allocation
 * \param[in] expected_behind the frames after, as of a node that begins there
 * \return false if there are no so many allocations
 */
bool
failAt(std::size_t failing_cloud,
       std::size_t number,
       const std::vector<pcl::PCLPointCloud2>& clouds,
       const SensorNodeSettings& settings,
       const std::vector<SentFrame>& expected_behind)
{
  SensorNode node(settings);
  FrameDecoder decoder;
  for (std::size_t i = 0; i < failing_cloud; ++i)
    decodedWith(decoder, encoded(node, clouds[i], poseOf(0)));
  Bytes bytes;
  bool has_failed = false;
  SensorNodeStatus status;
  {
    const FailingAllocation failing(number);
    status = node.encode(clouds[failing_cloud], poseOf(0), bytes);
    has_failed = failing.hasFailed();
  }
  if (status.ok()) { // nothing failed, or what can do without
    decodedWith(decoder, bytes);
    return has_failed;
  }
  expectCode(status, SensorNodeCode::OutOfMemory);
  EXPECT_TRUE(has_failed);
  EXPECT_FALSE(status.hasFrame());
  EXPECT_TRUE(bytes.empty());
  const SensorNodeStatistics statistics = node.statistics();
  EXPECT_EQ(statistics.clouds_refused, 1u);
  EXPECT_EQ(statistics.frames, failing_cloud);
  EXPECT_EQ(statistics.preprocessing.points, failing_cloud == 0 ? 0u : 400u);
  for (std::size_t i = failing_cloud + 1; i < clouds.size(); ++i) {
    const Bytes frame = encoded(node, clouds[i], poseOf(0));
    const SentFrame& expected = expected_behind.at(i - failing_cloud - 1);
    EXPECT_EQ(node.statistics().frame.coding.is_i_frame, expected.is_i_frame);
    // Both by the stream's decoder and by one that joins.
    const VoxelFrame voxels = decodedWith(decoder, frame);
    expectSameFrame(voxels, expected.voxels);
    if (i == failing_cloud + 1) {
      FrameDecoder joining;
      expectSameFrame(decodedWith(joining, frame), voxels);
    }
  }
  EXPECT_EQ(node.statistics().frames, clouds.size() - 1);
  return has_failed;
}

// What fails in the coders of each effort and layout is the codec's, see
// test/stream/test_failing_memory.cpp.
TEST(SensorNodeMemory, FailuresAreReportedAndTheStreamGoesOn)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Quadratic);
  settings.carry_header = true;
  settings.global_frame = "a frame whose name is no short one";
  settings.crop_box = BoundingBox{{-1, -1, -1}, {1, 1, 1}};
  settings.outlier_removal.emplace().min_log_odds = -1.0f;
  const std::vector<pcl::PCLPointCloud2> clouds = messages();
  for (const std::size_t failing_cloud : {0u, 3u}) {
    const std::vector<SentFrame> behind =
        framesFrom(failing_cloud + 1, clouds, settings);
    std::size_t number = 1;
    while (failAt(failing_cloud, number, clouds, settings, behind)) {
      ASSERT_FALSE(::testing::Test::HasFailure())
          << "allocation " << number << " at cloud " << failing_cloud;
      ++number;
    }
    EXPECT_GT(number, failing_cloud == 0 ? 10u : 1u);
  }
}

TEST(SensorNodeMemory, AnExceptionOfTheClockDropsTheFrame)
{
  const std::vector<pcl::PCLPointCloud2> clouds = messages();
  FakeClock clock;
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.clock = clock.clock();
  SensorNode node(settings);
  FrameDecoder decoder;
  decodedWith(decoder, encoded(node, clouds[0], poseOf(0)));
  clock.setBroken(true);
  expectLeftOut(node, clouds[1], poseOf(0), SensorNodeCode::EncodingFailed);
  clock.setBroken(false);
  const VoxelFrame voxels = decodedWith(decoder, encoded(node, clouds[2], poseOf(0)));
  EXPECT_TRUE(decoder.statistics().is_i_frame);
  WorldVoxels counts;
  const Cloud moved =
      naivelyPreprocessed(cloudSeenFrom(poseOf(0), 3, 400, 5), poseOf(0), naiveCount);
  for (const auto& [index, voxel] : naiveVoxels(moved, resolution))
    counts[index] = voxel.sum;
  EXPECT_EQ(worldVoxels(voxels), counts);
}

} // namespace
