// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/cloud_receiver.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "support/fake_clock.h"
#include "support/voxel_frames.h"

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityLaw;
using pcl_ext::WorldPose;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::FrameDecoder;
using pcl_ext::io::VoxelFrame;
using Frame = std::vector<std::uint8_t>;

const WorldPose identity = WorldPose::Identity();

template <typename PointT>
pcl::PCLPointCloud2
wall(std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  pcl::PointCloud<PointT> points;
  for (int i = 0; i < 2000; ++i) {
    PointT point;
    point.x = uniform(random, -1.0, 1.0);
    point.y = uniform(random, -1.0, 1.0);
    point.z = 2.0f + uniform(random, 0.0, 0.05);
    if constexpr (pcl::traits::has_intensity<PointT>::value)
      point.intensity = static_cast<float>(below(random, 200));
    points.push_back(point);
  }
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(points, cloud);
  cloud.header.frame_id = "camera";
  cloud.header.stamp = 1000000 * seed;
  return cloud;
}

Frame
encoded(CloudSender& sender,
        const pcl::PCLPointCloud2& cloud,
        std::size_t receivers = 1)
{
  Frame frame;
  const SensorNodeStatus status = sender.encode(cloud, identity, receivers, frame);
  EXPECT_TRUE(status.hasFrame()) << status.message();
  return frame;
}

bool
isIFrame(const Frame& frame)
{
  FrameDecoder decoder;
  VoxelFrame voxels;
  return decoder.decode(frame.data(), frame.size(), voxels).ok();
}

/** \brief The frames of a node whose sensor is at the origin. */
std::vector<Frame>
framesOfNode(const SensorNodeSettings& settings,
             const std::vector<pcl::PCLPointCloud2>& clouds)
{
  SensorNodeSettings of_transport = settings;
  of_transport.carry_layout = true;
  SensorNode node(of_transport);
  std::vector<Frame> frames;
  for (const pcl::PCLPointCloud2& cloud : clouds) {
    Frame& frame = frames.emplace_back();
    EXPECT_TRUE(node.encode(cloud, identity, frame).hasFrame());
  }
  return frames;
}

TEST(CloudTransport, FramesAreThoseOfANodeAtTheOriginOfItsClouds)
{
  SensorNodeSettings settings;
  const std::vector<pcl::PCLPointCloud2> with{wall<pcl::PointXYZI>(1),
                                              wall<pcl::PointXYZI>(2)};
  const std::vector<pcl::PCLPointCloud2> without{wall<pcl::PointXYZ>(1),
                                                 wall<pcl::PointXYZ>(2)};
  CloudSender sender;
  settings.law = IntensityLaw::Native;
  EXPECT_EQ(framesOfNode(settings, with),
            (std::vector<Frame>{encoded(sender, with[0]), encoded(sender, with[1])}));
  // Another layout begins another stream.
  settings.law = IntensityLaw::None;
  EXPECT_EQ(
      framesOfNode(settings, without),
      (std::vector<Frame>{encoded(sender, without[0]), encoded(sender, without[1])}));
}

TEST(CloudTransport, ParametersTakeEffectWithTheNextCloud)
{
  CloudSender sender;
  const auto cloud = wall<pcl::PointXYZ>(3);
  for (const double edge : {0.04, 0.1, 0.02}) {
    EXPECT_EQ(sender.setParameters({{"resolution", edge}}), "");
    CloudReceiver receiver;
    VoxelFrame voxels;
    ASSERT_TRUE(receiver.receive(encoded(sender, cloud), Time(0), voxels).ok());
    EXPECT_EQ(voxels.grid.resolution, edge);
  }
  // The same again begins no new stream, nor does what is refused.
  EXPECT_EQ(sender.setParameters({{"resolution", 0.02}}), "");
  EXPECT_FALSE(isIFrame(encoded(sender, cloud)));
  EXPECT_NE(sender.setParameters({{"intensity", std::string("linear")}}).find("sensor"),
            std::string::npos);
  EXPECT_FALSE(isIFrame(encoded(sender, cloud)));
  EXPECT_EQ(sender.settings().compression.resolution, 0.02);
  EXPECT_EQ(sender.settings().law, IntensityLaw::None);
}

TEST(CloudTransport, FromOneMaxRateToAnotherTheStreamGoesOn)
{
  pcl_ext::nodes::test::FakeClock clock;
  SensorNodeSettings settings;
  settings.clock = clock.clock();
  CloudSender sender(settings);
  const auto cloud = wall<pcl::PointXYZI>(3);
  Time now = std::chrono::seconds(1000);
  std::string kinds;
  const auto send = [&] {
    clock.set(now += std::chrono::seconds(1));
    kinds += isIFrame(encoded(sender, cloud)) ? 'I' : 'P';
  };
  send();
  send();
  EXPECT_EQ(sender.setParameters({{"max_rate", 1e7}}), "");
  send();
  send();
  ASSERT_EQ(sender.settings().law, IntensityLaw::Native); // of its clouds
  EXPECT_EQ(sender.setParameters({{"max_rate", 2e7}}), "");
  send();
  EXPECT_EQ(sender.settings().law, IntensityLaw::Native);
  EXPECT_EQ(sender.health().node.rate_control.max_rate, 2e7);
  EXPECT_EQ(sender.health().node.rate_control.changes, 0u);
  EXPECT_EQ(sender.settings().compression.max_rate, 2e7);
  EXPECT_EQ(sender.health().node.frames, 3u);
  EXPECT_EQ(sender.setParameters({{"max_rate", 3e7}, {"rate_buffer", 0.5}}), "");
  send();
  EXPECT_EQ(sender.setParameters({{"max_rate", 0.0}}), "");
  send();
  EXPECT_FALSE(sender.health().node.rate_control.is_on);
  EXPECT_EQ(kinds, "IPIPPII");
}

TEST(CloudTransport, NewReceiversAndRequestsGetIFrames)
{
  CloudSender sender;
  const auto cloud = wall<pcl::PointXYZ>(3);
  std::string kinds;
  for (const std::size_t receivers : {1u, 1u, 1u, 2u, 2u, 2u, 3u, 4u, 4u})
    kinds += isIFrame(encoded(sender, cloud, receivers)) ? 'I' : 'P';
  EXPECT_EQ(kinds, "IPPIPPIIP");
  // Requests, unlike these, never cause two in a row.
  kinds = "";
  for (int i = 0; i < 8; ++i) {
    sender.requestIFrame();
    kinds += isIFrame(encoded(sender, cloud, 4)) ? 'I' : 'P';
  }
  EXPECT_EQ(kinds, "IPIPIPIP");
  EXPECT_EQ(sender.health().i_frame_requests, 8u);
}

TEST(CloudTransport, ReceiversReportLossesAndWhatTheyLeaveOut)
{
  CloudSender sender;
  CloudReceiver receiver;
  VoxelFrame voxels;
  auto receive_next = [&, number = std::uint64_t{0}]() mutable {
    return receiver.receive(
        encoded(sender, wall<pcl::PointXYZ>(number++)), Time(0), voxels);
  };
  ASSERT_TRUE(receive_next().ok());
  encoded(sender, wall<pcl::PointXYZ>(1)); // is lost
  const ReceiverStatus status = receive_next();
  EXPECT_EQ(status.code(), CompressionCode::MissingReference);
  EXPECT_TRUE(status.wants_i_frame);
  EXPECT_EQ(voxels.size(), 0u);
  sender.requestIFrame();
  ASSERT_TRUE(receive_next().ok());
  EXPECT_GT(voxels.size(), 0u);
  receiver.countLeftOut();
  const ReceiverHealth health = receiver.health();
  EXPECT_EQ(health.left_out, 1u);
  EXPECT_EQ(health.stream.frames_failed, 1u);
  EXPECT_EQ(health.stream.frames_decoded, 2u);
  EXPECT_EQ(health.stream.frames_lost, 1u);
  EXPECT_TRUE(health.stream.in_sync);
}

TEST(CloudReceiver, RemovesVoxelsBelowAThresholdIfItHasOne)
{
  pcl::PointCloud<pcl::PointXYZI> points;
  for (int i = 0; i < 100; ++i)
    points.emplace_back(
        0.1f * static_cast<float>(i), 0.0f, 1.0f, static_cast<float>(i - 50));
  pcl::PCLPointCloud2 cloud;
  pcl::toPCLPointCloud2(points, cloud);
  CloudSender sender;
  ASSERT_EQ(sender.setParameters(
                {{"resolution", 0.05}, {"intensity", std::string("native")}}),
            "");
  const Frame frame = encoded(sender, cloud);
  for (const double least : {0.0, -10.0}) {
    CloudReceiver receiver;
    receiver.setNoise(readNoiseParameters({{"min_intensity", least}}));
    VoxelFrame voxels;
    ASSERT_TRUE(receiver.receive(frame, Time(0), voxels).ok());
    const std::size_t kept = least < 0.0 ? 60 : 100;
    EXPECT_EQ(voxels.size(), kept) << least;
    EXPECT_EQ(receiver.health().min_intensity, static_cast<float>(least));
    EXPECT_EQ(receiver.health().stream.kept_voxels, kept);
    EXPECT_EQ(receiver.health().stream.voxels, 100u);
  }
  // Nor does a central node remove any without a threshold.
  CentralNode node({});
  ASSERT_TRUE(node.addStream("a").ok());
  ASSERT_TRUE(node.receive("a", frame, Time(1)).ok());
  node.waitUntilDecoded();
  VoxelFrame voxels;
  ASSERT_TRUE(node.latestVoxels("a", voxels));
  EXPECT_EQ(voxels.size(), 100u);
}

pcl::PCLPointCloud2
organisedWall()
{
  pcl::PointCloud<pcl::PointXYZ> cloud(80, 60);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const float depth = 2.0f + 0.001f * static_cast<float>(i % 80 + i % 3);
    cloud[i].getVector3fMap() =
        Eigen::Vector3f{0.01f * (static_cast<float>(i % 80) - 40.0f) * depth,
                        0.01f * (static_cast<float>(i / 80) - 30.0f) * depth,
                        depth};
  }
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  return message;
}

struct CompressedMessage : pcl::PCLPointCloud2 {
  std::string format;
};

TEST(CloudTransport, MessagesHaveTheLayoutThatTheyHad)
{
  CloudSender sender;
  ASSERT_EQ(sender.setParameters({{"resolution", 0.001}, {"keep_order", true}}), "");
  pcl::PCLPointCloud2 cloud = organisedWall(); // points of 16 bytes, the last 4 unused
  cloud.fields[1].name = "z";                  // in another order than decoded ones
  cloud.fields[2].name = "y";
  CloudReceiver receiver;
  for (const bool is_packed : {false, true, false}) { // an I-frame, then P-frames
    NoiseSettings settings;
    settings.is_packed = is_packed;
    receiver.setNoise(settings);
    VoxelFrame voxels;
    ASSERT_TRUE(receiver.receive(encoded(sender, cloud), Time(0), voxels).ok());
    pcl::PCLPointCloud2 received;
    writeVoxels(voxels, received);
    ASSERT_EQ(received.fields.size(), is_packed ? 4u : 3u); // and intensities of 0
    EXPECT_EQ(received.fields[1].name, is_packed ? "y" : "z");
    EXPECT_EQ(received.fields[1].offset, 4u);
    EXPECT_EQ(received.point_step, 16u);
    EXPECT_EQ(received.height, 60u);
    CompressedMessage described;
    describeFrame(sender.health().node, sender.settings(), described);
    ASSERT_EQ(described.fields.size(), 3u);
    EXPECT_EQ(described.fields[1].name, "z");
    EXPECT_EQ(described.row_step, cloud.row_step);
  }
}

TEST(CloudTransport, SendersKnowHowManyPointsReceiversGet)
{
  CloudSender sender;
  CloudReceiver receiver;
  VoxelFrame voxels;
  for (const bool keep_points : {false, true}) {
    ASSERT_EQ(
        sender.setParameters({{"resolution", 0.04}, {"keep_points", keep_points}}), "");
    const Frame frame = encoded(sender, wall<pcl::PointXYZ>(5));
    ASSERT_TRUE(receiver.receive(frame, Time(0), voxels).ok());
    const std::size_t points = sender.health().node.decoded_width;
    EXPECT_EQ(points, voxels.pointCount());
    EXPECT_EQ(points, keep_points ? 2000 : voxels.size());
    EXPECT_LT(voxels.size(), 2000u);
  }
}

TEST(CloudTransport, PointsOfASensorNeedNoVoxelsUnlessNoiseIsRemoved)
{
  CloudSender sender;
  ASSERT_EQ(sender.setParameters({{"resolution", 0.005},
                                  {"keep_points", true},
                                  {"i_frame_rate", std::int64_t{1}}}),
            "");
  const pcl::PCLPointCloud2 cloud = organisedWall();
  CloudReceiver receiver;
  VoxelFrame points;
  ASSERT_TRUE(receiver.receive(encoded(sender, cloud), Time(0), points).ok());
  ASSERT_EQ(points.pointCount(), 4800u);
  EXPECT_EQ(points.cloudWidth(), 80u);
  EXPECT_EQ(points.cloudHeight(), 60u);
  EXPECT_EQ(points.size(), 0u);
  EXPECT_EQ(receiver.health().stream.kept_voxels, receiver.health().stream.voxels);
  EXPECT_EQ(sender.health().node.decoded_width, 80u);
  EXPECT_EQ(sender.health().node.decoded_height, 60u);

  NoiseSettings noise;
  noise.outlier_removal.emplace();
  noise.outlier_removal->min_log_odds = -100.0f;
  receiver.setNoise(noise);
  VoxelFrame kept;
  ASSERT_TRUE(receiver.receive(encoded(sender, cloud), Time(0), kept).ok());
  EXPECT_TRUE(pcl_ext::io::isConsistent(kept));
  EXPECT_GT(kept.size(), 1000u);
  EXPECT_EQ(kept.pointCount(), 4800u);
  EXPECT_EQ(receiver.health().stream.kept_voxels, kept.size());
}

TEST(CloudTransport, TheLastTransformIsThatOfTheSameFrame)
{
  SensorNodeSettings settings;
  settings.global_frame = "cell";
  CloudSender sender(settings);
  pcl::PCLPointCloud2 cloud = wall<pcl::PointXYZ>(1);
  Frame frame;
  SensorNodeStatus status = sender.encode(cloud, std::nullopt, 1, frame);
  EXPECT_EQ(status.code(), SensorNodeCode::NoTransform);
  EXPECT_EQ(status.message(),
            "there is no transform from 'camera' to 'cell'; the cloud was not encoded");
  EXPECT_TRUE(frame.empty());
  EXPECT_EQ(sender.encode(cloud, identity, 1, frame).code(), SensorNodeCode::Ok);
  EXPECT_EQ(sender.encode(cloud, std::nullopt, 1, frame).code(),
            SensorNodeCode::UsedLastTransform);
  cloud.header.frame_id = "other";
  EXPECT_EQ(sender.encode(cloud, std::nullopt, 1, frame).code(),
            SensorNodeCode::NoTransform);
  const SenderHealth health = sender.health();
  EXPECT_EQ(health.clouds, 4u);
  EXPECT_EQ(health.clouds_of_other_frame, 2u);
  EXPECT_EQ(health.node.frames, 2u);
}

TEST(CloudTransport, FieldsThatAreLeftOutAreNamedOnce)
{
  CloudSender sender;
  Frame frame;
  const pcl::PCLPointCloud2 known = wall<pcl::PointXYZI>(1);
  EXPECT_EQ(sender.encode(known, identity, 1, frame).message(), "");
  pcl::PCLPointCloud2 cloud = wall<pcl::PointXYZINormal>(2);
  EXPECT_EQ(sender.encode(cloud, identity, 1, frame).message(),
            "fields that are left out: normal_x, normal_y, normal_z, curvature");
  EXPECT_EQ(sender.encode(cloud, identity, 1, frame).message(), "");
  cloud.width /= 2;
  cloud.height = 2;
  cloud.row_step /= 2;
  EXPECT_EQ(sender.encode(cloud, identity, 1, frame).message(),
            "fields that are left out: normal_x, normal_y, normal_z, curvature; the "
            "rows and columns of the points are not kept");
}

} // namespace
