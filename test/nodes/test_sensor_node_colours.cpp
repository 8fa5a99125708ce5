// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A SensorNode sends the colours of clouds that have them.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/point_types.h>

#include "support/message_layouts.h"
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::PointXYZRGBI;

/** \brief The same points as cloudSeenFrom() with colours. */
pcl::PointCloud<PointXYZRGBI>
colouredCloudSeenFrom(const pcl_ext::WorldPose& pose, unsigned int seed)
{
  pcl::PointCloud<PointXYZRGBI> cloud;
  std::uint32_t colour = seed;
  for (const pcl::PointXYZI& point : cloudSeenFrom(pose, seed)) {
    PointXYZRGBI coloured;
    coloured.getVector3fMap() = point.getVector3fMap();
    coloured.intensity = point.intensity;
    coloured.rgba = 0xff000000u | (colour = colour * 1664525u + 1013904223u) >> 8;
    cloud.push_back(coloured);
  }
  return cloud;
}

TEST(SensorNodeColours, AreThoseOfTheClassForEachLaw)
{
  for (const IntensityLaw law : {IntensityLaw::Count, IntensityLaw::Native}) {
    SensorNodeSettings settings = settingsOf(law);
    settings.compression.colour_bits = 8;
    SensorNode node(settings);
    FrameDecoder decoder;
    for (unsigned int frame = 0; frame < 4; ++frame) {
      const auto pose = poseOf(frame);
      const auto cloud = colouredCloudSeenFrom(pose, frame);
      const VoxelFrame decoded =
          decodedWith(decoder, encoded(node, messageOf(cloud), pose));
      ASSERT_EQ(decoded.colour_bits, 8u);
      EXPECT_TRUE(node.statistics().preprocessing.has_colours);
      EXPECT_GT(node.statistics().frame.coding.attribute_bytes, 0u);
      // The class gets the points where the sensor saw them.
      pcl::PointCloud<PointXYZRGBI>::Ptr moved(new pcl::PointCloud<PointXYZRGBI>);
      for (PointXYZRGBI point : cloud) {
        point.getVector3fMap() =
            (pose * point.getVector3fMap().cast<double>()).cast<float>();
        moved->push_back(point);
      }
      pcl_ext::io::IntensityCompressionSettings codec;
      static_cast<pcl_ext::io::EncoderSettings&>(codec) = settings.compression;
      pcl_ext::io::OctreePointCloudIntensityCompression<PointXYZRGBI> compression(
          codec);
      std::ostringstream stream;
      ASSERT_TRUE(compression.encodePointCloud(moved, stream).ok());
      ASSERT_EQ(compression.voxelFrame().size(), decoded.size());
      for (std::size_t i = 0; i < decoded.size(); ++i)
        EXPECT_TRUE(compression.voxelFrame().fullColour(i) == decoded.fullColour(i))
            << i;
    }
  }
}

TEST(SensorNodeColours, CostNothingWhereThereAreNone)
{
  SensorNode node(settingsOf(IntensityLaw::Count));
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.compression.colour_bits = 0;
  SensorNode node_without(settings);
  SensorNode node_of_unreadable(settingsOf(IntensityLaw::Count));
  for (unsigned int frame = 0; frame < 4; ++frame) {
    const auto pose = poseOf(frame);
    auto coloured = messageOf(colouredCloudSeenFrom(pose, frame));
    // Colours that cannot be read are left out, whether they are sent or not.
    pcl_ext::test::fieldOf(coloured, "rgb").datatype = 2;
    const Bytes bytes = encoded(node, messageOf(cloudSeenFrom(pose, frame)), pose);
    EXPECT_EQ(node.statistics().frame.coding.attribute_bytes, 0u);
    EXPECT_EQ(bytes, encoded(node_without, coloured, pose));
    EXPECT_FALSE(node_without.statistics().preprocessing.has_colours);
    EXPECT_EQ(bytes, encoded(node_of_unreadable, coloured, pose));
  }
}

TEST(SensorNodeColours, AreNotPartOfThePublishedLayout)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.compression.format = StreamFormat::Published;
  SensorNode coloured(settings);
  SensorNode plain(settings);
  const auto pose = poseOf(1);
  EXPECT_EQ(encoded(coloured, messageOf(colouredCloudSeenFrom(pose, 1)), pose),
            encoded(plain, messageOf(cloudSeenFrom(pose, 1)), pose));
}

} // namespace
