/** \file
 * \brief Streams of clouds with regions: what comes back, what P-frames have of a sensor
 * that moves, and forged regions.
 */
#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/forged_frames.h"
#include "support/voxelized_stream.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::WorldPose;

constexpr Effort every_effort[] = {Effort::Fast, Effort::Balanced, Effort::Small};

EncoderSettings
boxSettings()
{
  EncoderSettings settings;
  settings.resolution = 0.02;
  settings.regions.boxes = {{{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}}, 0},
                            {{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}}, 1},
                            {{{-4.0, -4.0, -4.0}, {4.0, 4.0, 4.0}}, 3}};
  return settings;
}

WorldPose
poseAt(double x)
{
  WorldPose pose = WorldPose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.1 * x, Eigen::Vector3d::UnitZ()).matrix();
  pose.translation().x() = x;
  return pose;
}

/** \brief A plane of points, a little moved. */
Cloud
plane(double x)
{
  Cloud cloud;
  for (int i = -100; i < 100; ++i)
    for (int j = -100; j < 100; ++j)
      cloud.push_back({static_cast<float>(x + 0.013 * i),
                       static_cast<float>(0.013 * j),
                       static_cast<float>(0.1 * x)});
  return cloud;
}

/** \brief Encodes and decodes clouds of a stream, and compares the frames. */
class RegionStream {
public:
  explicit RegionStream(const EncoderSettings& settings)
  : encoder_(settings, pcl_ext::IntensityUnit::Points)
  {}

  const Bytes&
  add(const Cloud& cloud, const WorldPose& pose)
  {
    VoxelFrame back;
    EXPECT_TRUE(encoder_.voxelize(viewOf(cloud), pose, frame_).ok());
    EXPECT_TRUE(encoder_.filterOverTime(frame_).ok());
    const CompressionStatus status = encoder_.encode(frame_, std::nullopt, bytes_);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(decoded(decoder_, bytes_, back), CompressionCode::Ok);
    expectSameFrame(back, frame_);
    return bytes_;
  }

  CodedFrameStatistics
  statistics() const
  {
    return encoder_.statistics().coding;
  }

  const VoxelFrame&
  frame() const
  {
    return frame_;
  }

private:
  CloudEncoder encoder_;
  FrameDecoder decoder_;
  VoxelFrame frame_;
  Bytes bytes_;
};

TEST(RegionStreams, ComeBackWithEveryEffortAndColours)
{
  for (const Effort effort : every_effort) {
    EncoderSettings settings = boxSettings();
    settings.effort = effort;
    RegionStream stream(settings);
    for (int i = 0; i < 4; ++i) {
      stream.add(plane(0.005 * i), poseAt(0.0));
      EXPECT_EQ(stream.statistics().is_i_frame, i == 0);
    }
  }
}

TEST(RegionStreams, MayBeginWithoutPoints)
{
  RegionStream stream(boxSettings());
  stream.add({}, poseAt(0.0));
  EXPECT_EQ(stream.frame().size(), 0u);
  stream.add(plane(0.0), poseAt(0.0));
  EXPECT_GT(stream.frame().size(), 1000u);
}

TEST(RegionStreams, OfAStillSceneHaveFramesOfChanges)
{
  RegionStream stream(boxSettings());
  stream.add(plane(0.0), poseAt(0.0));
  stream.add(plane(0.0), poseAt(3.0)); // world's boxes do not depend on the sensor
  EXPECT_TRUE(stream.statistics().is_of_changes);
  EXPECT_LT(stream.statistics().bytes, 100u);
}

TEST(RegionStreams, OfAMovingSensorHaveItsPoseInPFrames)
{
  EncoderSettings settings;
  settings.resolution = 0.02;
  settings.regions.coarser_beyond = 0.3;
  RegionStream by_distance(settings);
  settings.regions.boxes = boxSettings().regions.boxes;
  settings.regions.boxes[0].frame = RegionFrame::Sensor;
  RegionStream in_sensor_frame(settings);
  for (int i = 0; i < 6; ++i) {
    const double x = 0.3 * (i / 2);
    for (RegionStream* stream : {&by_distance, &in_sensor_frame}) {
      const Bytes bytes = stream->add(plane(0.007 * i), poseAt(x));
      EXPECT_EQ(stream->statistics().is_i_frame, i == 0);
      EXPECT_EQ(stream->frame().regions->pose.position[0], std::floor(x / 0.02));
      const bool is_new = takeApart(bytes).header.region_pose.has_value();
      EXPECT_EQ(is_new, i == 2 || i == 4);
    }
  }
}

TEST(RegionStreams, OtherRegionsNeedAnIFrame)
{
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  FrameDecoder decoder;
  VoxelFrame frame = emptyFrame(6);
  VoxelFrame back;
  const auto is_i_frame_with = [&](const std::optional<VoxelRegions>& regions) {
    frame.regions = regions;
    EXPECT_EQ(decoded(decoder, encoded(encoder, frame), back), CompressionCode::Ok);
    expectSameFrame(back, frame);
    return encoder.statistics().is_i_frame;
  };
  VoxelRegions regions;
  regions.coarser_beyond = 5;
  regions.levels_outside = 2;
  EXPECT_TRUE(is_i_frame_with(std::nullopt));
  EXPECT_TRUE(is_i_frame_with(regions));
  EXPECT_FALSE(is_i_frame_with(regions));
  regions.pose.position[1] = -7;
  EXPECT_FALSE(is_i_frame_with(regions));
  ++regions.coarser_beyond;
  EXPECT_TRUE(is_i_frame_with(regions));
  regions.boxes = {{{-4, -4, -4}, {4, 4, 4}, 1, false}};
  EXPECT_TRUE(is_i_frame_with(regions));
  EXPECT_TRUE(is_i_frame_with(std::nullopt));
}

TEST(RegionStreams, TheHeaderHasTheBytesOfTheSpecification)
{
  VoxelFrame frame = emptyFrame(6);
  frame.regions.emplace();
  frame.regions->boxes = {{{-4, -4, -4}, {4, 4, 64}, 1, false},
                          {{0, 0, 0}, {1, 2, 3}, 3, true}};
  frame.regions->levels_outside = 2;
  frame.regions->coarser_beyond = 200;
  frame.regions->pose = {{-1, 1, 64},
                         {{{0, 1, 0}, {-1, 0, 0}, {0, 0, whole_rotation}}}};
  FrameEncoder encoder(StreamFormat::Version1, 9, Effort::Balanced);
  const auto end_of_header = [&](std::size_t size) {
    const Bytes bytes = encoded(encoder, frame);
    return Bytes(bytes.end() - static_cast<std::ptrdiff_t>(size), bytes.end());
  };
  const Bytes table = {2, 1, 7, 7, 7, 8, 8, 0x80, 1, 11, 0, 0, 0, 2, 4, 6, 18, 0xc8, 1};
  const Bytes pose = {1, 2, 0x80, 1, 1, 0, 2, 0, 1, 0, 0, 0, 0, 0x80, 0x80, 2};
  Bytes of_i_frame = table;
  append(pose, of_i_frame);
  append({0, 0}, of_i_frame); // voxels, bytes of the payload
  EXPECT_EQ(end_of_header(of_i_frame.size()), of_i_frame);
  frame.regions->pose.position = {0, 0, 0};
  const Bytes of_p_frame = {
      0x80, 0x10, 0, 0, 0, 1, 0, 2, 0, 1, 0, 0, 0, 0, 0x80, 0x80, 2, 0, 0};
  EXPECT_EQ(end_of_header(of_p_frame.size()), of_p_frame);
}

TEST(RegionStreams, ForgedRegionsAreRefused)
{
  EncoderSettings settings = boxSettings();
  settings.regions.coarser_beyond = 0.3;
  RegionStream stream(settings);
  const Bytes first = stream.add(plane(0.0), poseAt(0.0));
  const std::vector<Bytes> second = {stream.add(plane(0.0), poseAt(0.5))};
  const std::vector<VoxelFrame> expected = {stream.frame()};
  const Parts i_frame = takeApart(first);
  using Change = std::function<void(Version1Header&)>;
  const std::vector<std::pair<Change, std::string>> of_i_frames = {
      {[](auto& h) { h.regions->boxes[0].levels = 6; }, "invalid regions"},
      {[](auto& h) { h.regions->boxes.resize(65, h.regions->boxes[0]); },
       "invalid regions"},
      {[](auto& h) { h.regions->boxes[1].min[0] = h.regions->boxes[1].max[0]; },
       "invalid regions"},
      {[](auto& h) { h.regions->coarser_beyond = farthest_region + 1; },
       "invalid regions"},
      {[](auto& h) { h.regions->leaves_out_outside = true; }, "invalid regions"},
      {[](auto& h) { h.regions->pose.position[1] = farthest_region + 1; },
       "invalid regions"},
      {[](auto& h) { ++h.grid.first_index[2]; },
       "coarse voxels of regions across a face of the grid"},
      {[](auto& h) { h.regions->boxes.front().max[0] -= 7; }, "invalid voxels"},
      {[](auto& h) { h.regions->boxes[1].levels = 3; }, "invalid voxels"}};
  for (const auto& [change, message] : of_i_frames) {
    Parts parts = i_frame;
    change(parts.header);
    const Bytes forged = putTogether(parts);
    FrameDecoder decoder;
    VoxelFrame back;
    const CompressionStatus status = decoder.decode(forged.data(), forged.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::Corrupt);
    EXPECT_NE(status.message().find(message), std::string::npos)
        << message << ": " << status.message();
  }
  Parts p_frame = takeApart(second[0]);
  ASSERT_TRUE(p_frame.header.region_pose);
  const auto answer = [&](const RegionPose& pose, bool has_rotation) {
    p_frame.header.region_pose = pose;
    p_frame.header.has_region_rotation = has_rotation;
    return answerTo(putTogether(p_frame, i_frame.checksum), first, second, expected);
  };
  RegionPose pose = *p_frame.header.region_pose;
  EXPECT_EQ(answer(pose, false), CompressionCode::Ok);
  pose.position[2] = farthest_region + 1;
  EXPECT_EQ(answer(pose, false), CompressionCode::Corrupt);
  pose.position[2] = 0;
  pose.rotation[1][1] = 1; // no box is in the sensor's frame
  EXPECT_EQ(answer(pose, true), CompressionCode::Corrupt);
}

} // namespace
