// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_description.h>

#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

/** \brief Coordinates of what a camera of 32 rows and 48 columns sees of a wall, row by
 * row. */
std::vector<float>
organisedWall()
{
  std::vector<float> coordinates;
  for (std::uint32_t i = 0; i < 48 * 32; ++i) {
    const float depth = 2.0f + 0.001f * static_cast<float>(i % 48 + i % 3);
    coordinates.push_back(0.01f * (static_cast<float>(i % 48) - 24.0f) * depth);
    coordinates.push_back(0.01f * (static_cast<float>(i / 48) - 16.0f) * depth);
    coordinates.push_back(i % 10 == 4 ? std::numeric_limits<float>::quiet_NaN()
                                      : depth);
  }
  return coordinates;
}

io::test::Bytes
encodedWall(io::CloudEncoder& encoder, bool is_organised)
{
  const std::vector<float> coordinates = organisedWall();
  io::PointView view;
  view.count = coordinates.size() / 3;
  view.coordinates = coordinates.data();
  view.coordinate_stride = 3 * sizeof(float);
  if (is_organised)
    view.image = {48, 32};
  io::test::Bytes bytes;
  const io::CompressionStatus status = encoder.encode(view, {}, bytes);
  EXPECT_TRUE(status.ok()) << status;
  return bytes;
}

io::EncoderSettings
settingsWithPoints()
{
  io::EncoderSettings settings;
  settings.resolution = 0.002;
  settings.keep_points = true;
  settings.i_frame_rate = 2;
  return settings;
}

} // namespace

TEST(RecordedPoints, MessagesOfOrganisedCloudsHaveTheirRowsAndColumns)
{
  const TestFolder folder;
  KnownStream camera{"camera", {}};
  io::CloudEncoder encoder(settingsWithPoints(), IntensityUnit::None);
  io::FrameDecoder decoder;
  std::vector<std::pair<std::size_t, std::size_t>> sizes;
  for (int i = 0; i < 4; ++i) {
    const io::test::Bytes bytes = encodedWall(encoder, i < 2);
    camera.frames.push_back({{}, bytes, Time(i)});
    io::VoxelFrame decoded;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
    sizes.emplace_back(decoded.cloudWidth(), decoded.cloudHeight());
    const io::FrameDescription description =
        io::describeFrame(bytes.data(), bytes.size());
    EXPECT_EQ(description.points, decoded.pointCount());
  }
  EXPECT_EQ(sizes[1], std::make_pair(std::size_t{48}, std::size_t{32}));
  EXPECT_EQ(sizes[3].second, 1u);
  record({camera}, folder / "a.mcap");
  BagReader mcap;
  ASSERT_TRUE(mcap.open(folder / "a.mcap").ok());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    McapMessage message;
    PointCloudMessage cloud;
    ASSERT_TRUE(mcap.read(mcap.index()[i], message).ok());
    ASSERT_TRUE(
        readPointCloud(message.bytes.data(), message.bytes.size(), true, cloud).ok());
    EXPECT_EQ(std::make_pair(std::size_t{cloud.width}, std::size_t{cloud.height}),
              sizes[i]);
    EXPECT_EQ(cloud.is_dense, sizes[i].second == 1);
  }
}

TEST(RecordedPoints, PointsAreDecodedWithVoxelsOrWithoutWhateverTheOrder)
{
  const TestFolder folder;
  KnownStream camera{"camera", {}};
  io::CloudEncoder encoder(settingsWithPoints(), IntensityUnit::None);
  for (int i = 0; i < 6; ++i)
    camera.frames.push_back({{}, encodedWall(encoder, true), Time(i)});
  record({camera}, folder / "a.mcap");
  RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "a.mcap").ok());
  RecordedStreamDecoder decoder(reader, 0);
  io::VoxelFrame frame;
  for (const bool decodes_voxels : {true, false, true}) {
    decoder.setDecodesVoxels(decodes_voxels);
    for (const std::size_t number : {0u, 1u, 5u, 2u, 3u}) {
      ASSERT_TRUE(decoder.decode(number, frame).ok());
      EXPECT_EQ(frame.pointCount(), 48u * 32 - 154);
      EXPECT_EQ(frame.cloudHeight(), 32u);
      EXPECT_EQ(frame.keys.empty(), !decodes_voxels);
    }
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test
