// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/checked_link.h"
#include "support/node_tests.h"

#include <cmath>
#include <set>

namespace {

namespace sensor_node_rate {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelPosition;
using pcl_ext::io::test::CheckedLink;

const WorldPose identity = WorldPose::Identity();

/** \brief A wall with noise, in front of the sensor.
 * \param[in] step of the coordinates, metres
 */
pcl::PCLPointCloud2
wall(unsigned int seed, std::size_t size = 2000, double step = 0.0)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  std::normal_distribution<double> depth(2.0, 0.03);
  const auto rounded = [step](double x) {
    return static_cast<float>(step > 0.0 ? std::round(x / step) * step : x);
  };
  Cloud cloud;
  for (std::size_t i = 0; i < size; ++i) {
    pcl::PointXYZI point;
    point.x = rounded(place(random));
    point.y = rounded(place(random));
    point.z = rounded(depth(random));
    point.intensity = static_cast<float>(random() % 200);
    cloud.push_back(point);
  }
  return messageOf(cloud);
}

class RatedNode {
public:
  explicit RatedNode(SensorNodeSettings settings)
  : link_(settings.compression.max_rate, settings.compression.rate_buffer)
  , node(withClock(settings, clock_))
  {}

  SensorNodeStatus
  send(const pcl::PCLPointCloud2& cloud)
  {
    now_ += 100ms;
    clock_.set(now_);
    link_.advance(100ms);
    ++clouds_;
    Bytes bytes;
    SensorNodeStatus status;
    {
      const FailingAllocation failing(failing_allocation);
      status = node.encode(cloud, identity, bytes);
      has_failed = failing.hasFailed();
    }
    EXPECT_EQ(status.hasFrame(), !bytes.empty());
    const std::uint32_t expected_number = decoder.statistics().frame_number + 1;
    if (status.hasFrame()) {
      link_.add(bytes.size());
      frame = decodedWith(decoder, bytes);
      ++frames;
      EXPECT_TRUE(was_refused_ || decoder.statistics().frame_number == expected_number);
    }
    // With the memory for a frame's message its number may be lost.
    was_refused_ = status.code() == SensorNodeCode::OutOfMemory ||
                   (was_refused_ && !status.hasFrame());
    return status;
  }

  void
  expectAllCounted() const
  {
    const SensorNodeStatistics statistics = node.statistics();
    EXPECT_EQ(statistics.frames, frames);
    EXPECT_EQ(statistics.frames + statistics.rate_control.clouds_left_out +
                  statistics.clouds_refused,
              clouds_);
  }

private:
  FakeClock clock_;
  CheckedLink link_;
  Time now_ = 1000s;
  std::size_t clouds_ = 0;
  bool was_refused_ = false;

  static SensorNodeSettings
  withClock(SensorNodeSettings settings, const FakeClock& clock)
  {
    settings.clock = clock.clock();
    return settings;
  }

public:
  SensorNode node;
  FrameDecoder decoder;
  VoxelFrame frame; // the last one
  std::size_t frames = 0;
  std::size_t failing_allocation = 0; // of the next clouds; 0: none
  bool has_failed = false;
};

SensorNodeSettings
limitedSettings(double max_rate)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Native);
  settings.compression.resolution = 0.02;
  settings.compression.max_rate = max_rate;
  settings.compression.rate_sent_share = 1.0;
  return settings;
}

TEST(SensorNodeRate, OutliersStayWhereVoxelsBecomeTooLargeToBeJudged)
{
  SensorNodeSettings settings = limitedSettings(4e3);
  settings.compression.resolution = 0.15;
  settings.outlier_removal.emplace();
  RatedNode sent(settings);
  for (unsigned int i = 0; i < 30; ++i)
    sent.send(wall(i));
  EXPECT_GT(sent.frames, 0u);
  EXPECT_GT(sent.frame.grid.resolution, pcl_ext::VoxelOutlierRemoval::max_resolution);
  EXPECT_TRUE(sent.node.statistics().outliers_stay);
}

TEST(SensorNodeRate, ReceiversMissNothingOfWhatIsSent)
{
  for (const auto& [format, effort] :
       {std::pair(StreamFormat::Version1, Effort::Fast),
        std::pair(StreamFormat::Version1, Effort::Balanced),
        std::pair(StreamFormat::Published, Effort::Fast)}) {
    SensorNodeSettings settings =
        limitedSettings(format == StreamFormat::Published ? 1.4e5 : 3e5);
    settings.compression.format = format;
    settings.compression.effort = effort;
    settings.compression.i_frame_rate = 1000;
    settings.compression.max_encode_ms = 1e4; // efforts rise, too
    RatedNode sent(settings);
    std::size_t dropped = 0; // after encoding
    std::size_t changes = 0;
    bool is_left_out = false;
    for (unsigned int i = 0; i < 200; ++i) {
      // Now and then a cloud that nothing has told of.
      const std::size_t points = i % 40 == 39 ? 30000 : i < 100 ? 3000 : 300;
      const SensorNodeStatus status = sent.send(wall(i, points));
      if (!status.hasFrame()) {
        expectCode(status, SensorNodeCode::LeftOut);
        is_left_out = true;
        continue;
      }
      const std::size_t changes_now = sent.node.statistics().rate_control.changes;
      EXPECT_EQ(status.message().find("rate control: voxels of ") != std::string::npos,
                changes_now > changes)
          << status.message();
      dropped += is_left_out && changes_now == changes &&
                         sent.decoder.statistics().is_i_frame && sent.frames > 1
                     ? 1
                     : 0;
      is_left_out = false;
      changes = changes_now;
      EXPECT_EQ(sent.frame.grid.resolution,
                sent.node.statistics().rate_control.resolution);
    }
    EXPECT_GT(dropped, 0u);
    EXPECT_GT(changes, 1u);
    EXPECT_GT(sent.frames, 100u);
    sent.expectAllCounted();
  }
}

using LatticeVoxels = std::set<std::array<std::int64_t, 3>>;

/** \brief The voxels, as those of 2^doublings times the edge that hold them. */
LatticeVoxels
latticeVoxels(const VoxelFrame& frame, unsigned int doublings)
{
  LatticeVoxels voxels;
  for (const std::uint64_t key : frame.keys) {
    const VoxelPosition position = pcl_ext::io::voxelPosition(key);
    const auto index = [&](std::size_t axis, std::uint32_t place) {
      return (std::int64_t{frame.grid.first_index[axis]} + place) >> doublings;
    };
    voxels.insert({index(0, position.x), index(1, position.y), index(2, position.z)});
  }
  return voxels;
}

/** \brief A node whose time is never enough, so that its voxels become coarser. */
SensorNodeSettings
hurriedSettings(IntensityLaw law)
{
  SensorNodeSettings settings = settingsOf(law);
  settings.compression.resolution = 0.02;
  settings.compression.effort = Effort::Fast;
  settings.compression.max_encode_ms = 0.1;
  settings.compression.rate_doublings = 2;
  return settings;
}

TEST(SensorNodeRate, CoarseVoxelsAreUnionsOfFineOnes)
{
  WorldPose far = identity;
  far.translate(Eigen::Vector3d(468123.4, 5261011.7, 312.6));
  struct Case {
    const char* what;
    WorldPose pose;
    double step; ///< of coordinates
    bool use_step;
  };
  for (const Case& one : {Case{"UTM", far, 0.0, false},
                          Case{"coordinates on a lattice", identity, 0.02, false},
                          Case{"voxels that follow a lattice", identity, 0.05, true}}) {
    SCOPED_TRACE(one.what);
    SensorNodeSettings settings = hurriedSettings(IntensityLaw::None);
    settings.compression.use_coordinate_step = one.use_step;
    SensorNode rated(settings);
    settings.compression.max_encode_ms = 0.0;
    SensorNode fine_node(settings);
    FrameDecoder decoder;
    FrameDecoder fine_decoder;
    std::size_t coarse_frames = 0;
    for (unsigned int i = 0; i < 40 && coarse_frames < 3; ++i) {
      const pcl::PCLPointCloud2 cloud = wall(i, 20000, one.step);
      const VoxelFrame fine =
          decodedWith(fine_decoder, encoded(fine_node, cloud, one.pose));
      const VoxelFrame frame = decodedWith(decoder, encoded(rated, cloud, one.pose));
      const unsigned int doublings = rated.statistics().rate_control.step.doublings;
      EXPECT_EQ(frame.grid.origin, fine.grid.origin);
      EXPECT_EQ(frame.grid.resolution,
                std::ldexp(fine.grid.resolution, static_cast<int>(doublings)));
      EXPECT_EQ(latticeVoxels(frame, 0), latticeVoxels(fine, doublings));
      coarse_frames += doublings == 2 ? 1 : 0;
    }
    EXPECT_GT(coarse_frames, 0u);
  }
}

TEST(SensorNodeRate, CoarseIntensitiesAreThoseOfANodeOfThatResolution)
{
  for (const IntensityLaw law : {IntensityLaw::Quadratic, IntensityLaw::Count}) {
    SensorNode rated(hurriedSettings(law));
    SensorNodeSettings coarse = settingsOf(law);
    coarse.compression.resolution = 0.08;
    SensorNode fixed(coarse);
    FrameDecoder decoder;
    FrameDecoder fixed_decoder;
    std::size_t compared = 0;
    for (unsigned int i = 0; i < 40 && compared < 3; ++i) {
      const pcl::PCLPointCloud2 cloud = wall(i, 20000);
      const VoxelFrame expected =
          decodedWith(fixed_decoder, encoded(fixed, cloud, poseOf(0)));
      const VoxelFrame frame = decodedWith(decoder, encoded(rated, cloud, poseOf(0)));
      if (rated.statistics().rate_control.step.doublings != 2)
        continue;
      EXPECT_EQ(worldVoxels(frame), worldVoxels(expected));
      ++compared;
    }
    EXPECT_GT(compared, 0u);
  }
}

TEST(SensorNodeRate, ARequestOutlastsCloudsThatAreLeftOut)
{
  SensorNodeSettings settings = limitedSettings(5e4);
  settings.compression.rate_buffer = 0.5;
  settings.compression.rate_temporal_filter = 0;
  settings.compression.rate_doublings = 0;
  settings.compression.i_frame_rate = 1000;
  RatedNode sent(settings);
  std::string kinds; // of the frames; -: left out
  for (unsigned int i = 0; i < 300; ++i) {
    const bool is_sent = sent.send(wall(i, 600)).hasFrame();
    kinds += !is_sent ? '-' : sent.decoder.statistics().is_i_frame ? 'I' : 'P';
    if (i > 100 && !is_sent && kinds[kinds.size() - 2] == 'P') {
      sent.node.requestIFrame();
      kinds += 'r';
    }
  }
  std::size_t requests = 0;
  for (std::size_t i = kinds.find('r'); i < kinds.size(); i = kinds.find('r', i + 1)) {
    const std::size_t next = kinds.find_first_not_of("-r", i);
    EXPECT_TRUE(next == std::string::npos || kinds[next] == 'I') << kinds;
    ++requests;
  }
  EXPECT_GT(requests, 1u) << kinds;
}
/** \brief Sends clouds until the step has changed.
 * \return number of clouds, the last of which has a frame of the new step
 */
unsigned int
cloudsUntilChange(const SensorNodeSettings& settings)
{
  RatedNode sent(settings);
  for (unsigned int i = 0; i < 100; ++i)
    if (sent.send(wall(i, 300)).message().find("rate control") != std::string::npos)
      return i + 1;
  ADD_FAILURE() << "no change";
  return 1;
}

TEST(SensorNodeRate, MemoryMayRunOutDuringAChange)
{
  SensorNodeSettings settings = limitedSettings(3e4);
  settings.compression.rate_temporal_filter = 0;
  const unsigned int clouds = cloudsUntilChange(settings);
  std::size_t number = 0;
  for (bool has_failed = true; has_failed;) {
    RatedNode sent(settings);
    for (unsigned int i = 0; i + 1 < clouds; ++i)
      sent.send(wall(i, 300));
    sent.failing_allocation = ++number;
    const SensorNodeStatus status = sent.send(wall(clouds - 1, 300));
    sent.failing_allocation = 0;
    has_failed = sent.has_failed;
    if (status.hasFrame())
      continue;
    expectCode(status, SensorNodeCode::OutOfMemory);
    std::string kinds; // of the frames after it
    for (unsigned int i = clouds; i < clouds + 30; ++i)
      if (sent.send(wall(i, 300)).hasFrame())
        kinds += sent.decoder.statistics().is_i_frame ? 'I' : 'P';
    EXPECT_EQ(kinds.substr(0, 1), "I");
    EXPECT_GT(sent.node.statistics().rate_control.step_number, 0u);
    EXPECT_EQ(sent.frame.intensity_scale.bits, 4u); // of the new step
    sent.expectAllCounted();
    ASSERT_FALSE(::testing::Test::HasFailure()) << "allocation " << number;
  }
  EXPECT_GT(number, 10u);
}

} // namespace sensor_node_rate

} // namespace
