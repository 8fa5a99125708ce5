// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Streams of a SensorNode: grids that stay, I-frames, what frames carry.
 */
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;

TEST(SensorNodeStreams, GridOfTheCropBoxStaysWhenThePointsMove)
{
  for (const StreamFormat format : {StreamFormat::Version1, StreamFormat::Published})
    for (const bool has_box : {true, false}) {
      SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
      settings.compression.format = format;
      if (has_box)
        settings.crop_box = wide_box;
      SensorNode node(settings);
      const Cloud cloud = cloudSeenFrom(WorldPose::Identity(), 1);
      std::vector<pcl_ext::io::VoxelGrid> grids;
      FrameDecoder decoder;
      for (unsigned int frame = 0; frame < 4; ++frame) {
        // A few points far from the others, further out each time.
        Cloud moved = cloud;
        for (std::size_t i = 0; i < 9; ++i)
          moved[i].x = 0.3f + 0.24f * static_cast<float>(frame);
        grids.push_back(
            decodedWith(decoder, encoded(node, messageOf(moved), WorldPose::Identity()))
                .grid);
      }
      bool all_alike = true;
      for (const pcl_ext::io::VoxelGrid& grid : grids)
        all_alike &= grid == grids.front();
      EXPECT_EQ(all_alike, has_box);
      EXPECT_EQ(node.statistics().i_frames == 1, has_box);
    }
}
TEST(SensorNodeStreams, IFramesComeByStampsOrWithoutThemByTheClock)
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

TEST(SensorNodeStreams, AReceiverThatJoinsLateIsServedByARequest)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Quadratic);
  SensorNode node(settings);
  const pcl::PCLPointCloud2 message = messageOf(cloudSeenFrom(poseOf(0), 1));
  encoded(node, message, poseOf(0));
  FrameDecoder late;
  VoxelFrame frame;
  Bytes bytes = encoded(node, message, poseOf(0));
  EXPECT_FALSE(late.decode(bytes.data(), bytes.size(), frame).ok());
  node.requestIFrame();
  // A cloud that is left out does not use the request up.
  expectLeftOut(node, pcl::PCLPointCloud2(), poseOf(0), SensorNodeCode::InvalidCloud);
  decodedWith(late, encoded(node, message, poseOf(0)));
  decodedWith(late, encoded(node, message, poseOf(0)));
  EXPECT_FALSE(late.statistics().is_i_frame);
}

TEST(SensorNodeStreams, AMovedNodeGoesOnWithItsStream)
{
  SensorNode first(settingsOf(IntensityLaw::Count));
  FrameDecoder decoder;
  const Cloud cloud = cloudSeenFrom(poseOf(0), 1);
  decodedWith(decoder, encoded(first, messageOf(cloud), poseOf(0)));
  SensorNode second(std::move(first));
  decodedWith(decoder, encoded(second, messageOf(cloud), poseOf(0)));
  SensorNode third(settingsOf(IntensityLaw::Quadratic));
  third = std::move(second);
  Bytes bytes;
  expectCode(third.encode(messageOf(cloud), std::nullopt, bytes),
             SensorNodeCode::UsedLastTransform);
  decodedWith(decoder, bytes);
  EXPECT_FALSE(decoder.statistics().is_i_frame);
  EXPECT_EQ(third.statistics().frames, 3u);
}

} // namespace
