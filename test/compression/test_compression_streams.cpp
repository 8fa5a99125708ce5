/** \file
 * \brief Streams of many frames through OctreePointCloudIntensityCompression: order,
 * I-frames, figures, formats, instances side by side.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "support/cloud_streams.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::FrameStatistics;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::io::StreamFormat;
using pcl_ext::test::expectIntensities;
using pcl_ext::test::expectVoxelCentres;
using pcl_ext::test::NaiveVoxel;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::randomCloud;
using pcl_ext::test::settingsWith;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

constexpr double resolution = 0.04;

void
expectDecoded(const Cloud& decoded, const Cloud& original)
{
  const auto voxels = naiveVoxels(original, resolution);
  expectVoxelCentres(decoded, voxels, resolution);
  expectIntensities(
      decoded,
      voxels,
      resolution,
      [](const NaiveVoxel& voxel) { return voxel.mean(); },
      0.5 + 1e-6);
}

/** \brief A scene that moves a little from frame to frame. */
Cloud::Ptr
movingCloud(unsigned int frame)
{
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 600);
  for (pcl::PointXYZI& point : *cloud)
    point.x += 0.01f * static_cast<float>(frame);
  *cloud += *randomCloud<pcl::PointXYZI>(1000 + frame, 50);
  return cloud;
}

IntensityCompressionSettings
publishedSettings()
{
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.format = StreamFormat::Published;
  settings.bounding_box = BoundingBox{{-0.8, -0.8, -0.8}, {1.2, 0.8, 0.8}};
  return settings;
}

TEST(CompressionStreams, FramesOfOneStreamComeBackInOrder)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  for (unsigned int frame = 0; frame < 12; ++frame)
    ASSERT_TRUE(encoder.encodePointCloud(movingCloud(frame), stream).ok());
  for (unsigned int frame = 0; frame < 12; ++frame) {
    SCOPED_TRACE("frame " + std::to_string(frame));
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    expectDecoded(*decoded, *movingCloud(frame));
    EXPECT_EQ(decoder.getStatistics().coding.is_i_frame, frame == 0);
    EXPECT_EQ(decoder.getStatistics().coding.skipped_bytes, 0u);
  }
  EXPECT_EQ(stream.peek(), std::stringstream::traits_type::eof());
}

TEST(CompressionStreams, WritingAndReadingMayTakeTurnsOnOneStream)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  for (unsigned int frame = 0; frame < 6; ++frame) {
    ASSERT_TRUE(encoder.encodePointCloud(movingCloud(frame), stream).ok());
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    expectDecoded(*decoded, *movingCloud(frame));
    EXPECT_TRUE(stream.good());
  }
}

TEST(CompressionStreams, OneInstanceServesBothDirectionsAtOnce)
{
  // A node that sends its own stream and watches another's.
  Compression node(settingsWith(resolution));
  Compression alone(settingsWith(resolution));
  Compression other(settingsWith(0.1));
  std::stringstream from_node;
  std::stringstream from_alone;
  for (unsigned int frame = 0; frame < 8; ++frame) {
    const auto others_cloud = randomCloud<pcl::PointXYZI>(50 + frame, 200, {3, 4, 5});
    std::stringstream from_other;
    ASSERT_TRUE(other.encodePointCloud(others_cloud, from_other).ok());
    ASSERT_TRUE(node.encodePointCloud(movingCloud(frame), from_node).ok());
    ASSERT_TRUE(alone.encodePointCloud(movingCloud(frame), from_alone).ok());
    Cloud::Ptr decoded;
    ASSERT_TRUE(node.decodePointCloud(from_other, decoded).ok());
    expectVoxelCentres(*decoded, naiveVoxels(*others_cloud, 0.1), 0.1);
  }
  EXPECT_EQ(from_node.str(), from_alone.str());
}

TEST(CompressionStreams, BytesBetweenFramesAreSkippedAndCounted)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  Cloud::Ptr decoded;
  for (unsigned int frame = 0; frame < 4; ++frame) {
    stream << std::string(10 * frame, '#');
    ASSERT_TRUE(encoder.encodePointCloud(movingCloud(frame), stream).ok());
  }
  for (unsigned int frame = 0; frame < 4; ++frame) {
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoder.getStatistics().coding.skipped_bytes, 10u * frame);
  }
}

TEST(CompressionStreams, IFramesComeAtTheirRate)
{
  for (const unsigned int rate : {0u, 1u, 2u, 5u}) {
    IntensityCompressionSettings settings = settingsWith(resolution);
    settings.i_frame_rate = rate;
    for (const StreamFormat format :
         {StreamFormat::Version1, StreamFormat::Published}) {
      settings.format = format;
      settings.bounding_box = publishedSettings().bounding_box;
      Compression encoder(settings);
      for (unsigned int frame = 0; frame < 12; ++frame) {
        std::ostringstream stream;
        ASSERT_TRUE(encoder.encodePointCloud(movingCloud(frame), stream).ok());
        EXPECT_EQ(encoder.getStatistics().coding.is_i_frame,
                  frame % std::max(rate, 1u) == 0)
            << "rate " << rate << ", frame " << frame;
      }
    }
  }
}

TEST(CompressionStreams, ARequestedIFrameRestartsTheCount)
{
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.i_frame_rate = 4;
  Compression encoder(settings);
  std::string frame_types;
  for (unsigned int frame = 0; frame < 10; ++frame) {
    if (frame == 2)
      encoder.requestIFrame();
    std::ostringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(movingCloud(0), stream).ok());
    frame_types += encoder.getStatistics().coding.is_i_frame ? 'I' : 'P';
  }
  EXPECT_EQ(frame_types, "IPIPPPIPPP");
}

TEST(CompressionStreams, PFramesOfAStillSceneAreSmaller)
{
  Compression encoder(settingsWith(resolution));
  std::vector<std::size_t> occupancy_bytes;
  for (int frame = 0; frame < 2; ++frame) {
    std::ostringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(movingCloud(0), stream).ok());
    occupancy_bytes.push_back(encoder.getStatistics().coding.occupancy_bytes);
  }
  EXPECT_LT(2 * occupancy_bytes[1], occupancy_bytes[0]);
}

TEST(CompressionStreams, TheSameCloudsGiveTheSameBytes)
{
  std::vector<std::string> streams;
  for (int run = 0; run < 2; ++run) {
    Compression encoder(settingsWith(resolution));
    std::ostringstream stream;
    for (unsigned int frame = 0; frame < 5; ++frame)
      ASSERT_TRUE(encoder.encodePointCloud(movingCloud(frame), stream).ok());
    streams.push_back(stream.str());
  }
  EXPECT_EQ(streams[0], streams[1]);
}

TEST(CompressionStreams, ThreadsWithAnInstanceEachGiveTheBytesOfOneAfterTheOther)
{
  constexpr unsigned int thread_count = 4;
  const auto encode_stream = [](unsigned int seed) {
    IntensityCompressionSettings settings = settingsWith(0.02 + 0.01 * seed);
    settings.i_frame_rate = 3;
    settings.retain_octree = seed % 2 == 0;
    Compression encoder(settings);
    Compression decoder;
    std::string bytes;
    for (unsigned int frame = 0; frame < 10; ++frame) {
      std::stringstream stream;
      encoder.encodePointCloud(randomCloud<pcl::PointXYZI>(seed * 100 + frame, 500),
                               stream);
      bytes += stream.str();
      Cloud::Ptr decoded;
      if (!decoder.decodePointCloud(stream, decoded).ok())
        return std::string("a frame did not decode");
      bytes += std::to_string(decoded->size());
    }
    return bytes;
  };
  std::vector<std::string> serially(thread_count);
  std::vector<std::string> in_threads(thread_count);
  for (unsigned int i = 0; i < thread_count; ++i)
    serially[i] = encode_stream(i);
  std::vector<std::thread> threads;
  for (unsigned int i = 0; i < thread_count; ++i)
    threads.emplace_back([&, i] { in_threads[i] = encode_stream(i); });
  for (std::thread& thread : threads)
    thread.join();
  for (unsigned int i = 0; i < thread_count; ++i) {
    EXPECT_GT(serially[i].size(), 1000u);
    EXPECT_EQ(serially[i], in_threads[i]);
  }
}

TEST(CompressionStatistics, MatchTheBytesWritten)
{
  for (const StreamFormat format : {StreamFormat::Version1, StreamFormat::Published}) {
    IntensityCompressionSettings settings = publishedSettings();
    settings.format = format;
    Compression encoder(settings);
    Compression decoder;
    for (unsigned int frame = 0; frame < 4; ++frame) {
      const auto cloud = movingCloud(frame);
      cloud->at(3).z = 50.0f; // outside the box
      cloud->at(4).x = std::numeric_limits<float>::quiet_NaN();
      std::stringstream stream;
      ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
      const FrameStatistics encoded = encoder.getStatistics();
      EXPECT_EQ(encoded.coding.bytes, stream.str().size());
      EXPECT_EQ(encoded.coding.header_bytes + encoded.coding.occupancy_bytes +
                    encoded.coding.intensity_bytes,
                encoded.coding.bytes);
      EXPECT_EQ(encoded.coding.frame_number, frame + 1);
      EXPECT_EQ(encoded.coding.is_i_frame, frame == 0);
      EXPECT_EQ(encoded.coding.voxels, encoded.voxelization.voxels);
      EXPECT_EQ(encoded.voxelization.points, cloud->size());
      EXPECT_EQ(encoded.voxelization.points_used, cloud->size() - 2);
      EXPECT_EQ(encoded.voxelization.points_not_finite, 1u);
      EXPECT_EQ(encoded.voxelization.points_outside_box, 1u);
      EXPECT_EQ(encoded.voxelization.points_outside_grid, 0u);
      EXPECT_DOUBLE_EQ(encoded.bytesPerVoxel(),
                       static_cast<double>(encoded.coding.bytes) /
                           static_cast<double>(encoded.coding.voxels));
      EXPECT_DOUBLE_EQ(encoded.compressionRatio(),
                       16.0 * static_cast<double>(cloud->size()) /
                           static_cast<double>(stream.str().size()));

      Cloud::Ptr decoded;
      ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
      const FrameStatistics seen = decoder.getStatistics();
      EXPECT_EQ(seen.coding.bytes, encoded.coding.bytes);
      EXPECT_EQ(seen.coding.header_bytes, encoded.coding.header_bytes);
      EXPECT_EQ(seen.coding.occupancy_bytes, encoded.coding.occupancy_bytes);
      EXPECT_EQ(seen.coding.intensity_bytes, encoded.coding.intensity_bytes);
      EXPECT_EQ(seen.coding.frame_number, encoded.coding.frame_number);
      EXPECT_EQ(seen.coding.is_i_frame, encoded.coding.is_i_frame);
      EXPECT_EQ(seen.coding.voxels, decoded->size());
      EXPECT_EQ(seen.voxelization.points, 0u);
    }
  }
}

TEST(CompressionStatistics, OfAnEmptyFrameDivideByNothing)
{
  Compression encoder(settingsWith(resolution));
  EXPECT_EQ(encoder.getStatistics().bytesPerVoxel(), 0.0);
  EXPECT_EQ(encoder.getStatistics().compressionRatio(), 0.0);
  std::ostringstream stream;
  ASSERT_TRUE(encoder.encodePointCloud(Cloud::Ptr(new Cloud), stream).ok());
  EXPECT_EQ(encoder.getStatistics().bytesPerVoxel(), 0.0);
  EXPECT_EQ(encoder.getStatistics().compressionRatio(), 0.0);
  EXPECT_EQ(encoder.getStatistics().coding.bytes, stream.str().size());
}

/** \brief What a frame prints, at a verbosity of PCL's console. */
struct PrintedFrame {
  std::string encoding;
  std::string decoding;
  FrameStatistics encoded;
};

PrintedFrame
printFrame(bool show_statistics, pcl::console::VERBOSITY_LEVEL verbosity)
{
  const auto verbosity_before = pcl::console::getVerbosityLevel();
  pcl::console::setVerbosityLevel(verbosity);
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.show_statistics = show_statistics;
  Compression compression(settings);
  std::stringstream stream;
  Cloud::Ptr decoded;
  PrintedFrame printed;
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(compression.encodePointCloud(movingCloud(0), stream).ok());
  printed.encoding = ::testing::internal::GetCapturedStdout();
  printed.encoded = compression.getStatistics();
  ::testing::internal::CaptureStdout();
  EXPECT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  printed.decoding = ::testing::internal::GetCapturedStdout();
  pcl::console::setVerbosityLevel(verbosity_before);
  return printed;
}

TEST(CompressionStatistics, ArePrintedThroughPclsConsole)
{
  const PrintedFrame printed = printFrame(true, pcl::console::L_INFO);
  const std::string voxels = std::to_string(printed.encoded.coding.voxels);
  const std::string bytes = std::to_string(printed.encoded.coding.bytes);
  for (const std::string* text : {&printed.encoding, &printed.decoding}) {
    EXPECT_NE(text->find("Intra frame"), std::string::npos) << *text;
    EXPECT_NE(text->find(voxels), std::string::npos) << *text;
    EXPECT_NE(text->find(bytes + " bytes"), std::string::npos) << *text;
  }
  EXPECT_NE(printed.encoding.find("POINTCLOUD ENCODING"), std::string::npos);
  EXPECT_NE(printed.encoding.find("points: 650"), std::string::npos);
  EXPECT_NE(printed.decoding.find("POINTCLOUD DECODING"), std::string::npos);
  EXPECT_EQ(printed.decoding.find("points:"), std::string::npos);
}

TEST(CompressionStatistics, AreSilentUnlessAskedForAndHeard)
{
  const PrintedFrame not_asked = printFrame(false, pcl::console::L_VERBOSE);
  EXPECT_EQ(not_asked.encoding, "");
  EXPECT_EQ(not_asked.decoding, "");
  const PrintedFrame not_heard = printFrame(true, pcl::console::L_WARN);
  EXPECT_EQ(not_heard.encoding, "");
  EXPECT_EQ(not_heard.decoding, "");
}

TEST(PublishedStreams, GoThroughTheClassAndAreToldApart)
{
  using Counting = OctreePointCloudIntensityCompression<pcl::PointXYZI, CountIntensity>;
  Counting encoder(publishedSettings());
  Compression decoder; // knows of no format, box or resolution
  for (unsigned int frame = 0; frame < 6; ++frame) {
    const auto cloud = movingCloud(frame);
    std::stringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
    EXPECT_EQ(stream.str().substr(0, 6), "<HEAD>");
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());

    // The grid is PCL's, a cube of 64 voxels about the box's middle.
    const std::array<double, 3> lower = {
        0.2 - 32 * resolution, -32 * resolution, -32 * resolution};
    std::map<std::array<std::int64_t, 3>, double> counts;
    const auto voxel_of = [&](const pcl::PointXYZI& point) {
      const float* const coordinates = &point.x;
      std::array<std::int64_t, 3> index{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        index[axis] = static_cast<std::int64_t>(std::floor(
            (static_cast<double>(coordinates[axis]) - lower[axis]) / resolution));
      return index;
    };
    for (const pcl::PointXYZI& point : *cloud)
      ++counts[voxel_of(point)];
    ASSERT_EQ(decoded->size(), counts.size());
    for (const pcl::PointXYZI& point : *decoded) {
      const auto index = voxel_of(point);
      ASSERT_EQ(counts.count(index), 1u) << point;
      EXPECT_EQ(static_cast<double>(point.intensity), counts.at(index));
      EXPECT_NEAR(static_cast<double>(point.x),
                  lower[0] + (static_cast<double>(index[0]) + 0.5) * resolution,
                  1e-6);
    }
  }
}

TEST(PublishedStreams, MayBeMixedWithVersion1InOneStream)
{
  Compression published(publishedSettings());
  Compression version1(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  for (unsigned int frame = 0; frame < 4; ++frame) {
    ASSERT_TRUE(published.encodePointCloud(movingCloud(frame), stream).ok());
    ASSERT_TRUE(version1.encodePointCloud(movingCloud(frame), stream).ok());
  }
  for (unsigned int frame = 0; frame < 4; ++frame) {
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoder.getStatistics().coding.is_i_frame, frame == 0);
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoder.getStatistics().coding.is_i_frame, frame == 0);
    expectDecoded(*decoded, *movingCloud(frame));
  }
}

TEST(PublishedStreams, AnEmptyFrameIsAFrame)
{
  Compression encoder(publishedSettings());
  Compression decoder;
  std::stringstream stream;
  for (const bool is_empty : {true, false, true, true, false, false}) {
    const Cloud::Ptr cloud = is_empty ? Cloud::Ptr(new Cloud) : movingCloud(0);
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
    Cloud::Ptr decoded;
    const auto status = decoder.decodePointCloud(stream, decoded);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(decoded->empty(), is_empty);
  }
}

} // namespace
