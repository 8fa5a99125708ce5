/** \file
 * \brief Lost, damaged and late frames through OctreePointCloudIntensityCompression: a
 * receiver never shows a wrong cloud and is right again from the next I-frame on.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using pcl_ext::io::BoundingBox;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::CompressionStatus;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::io::StreamFormat;
using pcl_ext::test::decodeBytes;
using pcl_ext::test::encodeFrame;
using pcl_ext::test::expectCode;
using pcl_ext::test::randomCloud;
using pcl_ext::test::settingsWith;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

constexpr double resolution = 0.04;

bool
sameCloud(const Cloud& first, const Cloud& second)
{
  if (first.size() != second.size())
    return false;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (first[i].getVector3fMap() != second[i].getVector3fMap() ||
        first[i].intensity != second[i].intensity)
      return false;
  return true;
}

/** \brief Frames of one stream, and what a receiver that lost none makes of each. */
struct RecordedStream {
  std::vector<std::string> frames;
  std::vector<bool> is_i_frame;
  std::vector<Cloud> decoded;
};

RecordedStream
recordStream(std::size_t size, unsigned int i_frame_rate, StreamFormat format)
{
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.i_frame_rate = i_frame_rate;
  settings.format = format;
  settings.bounding_box = BoundingBox{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  Compression encoder(settings);
  Compression decoder;
  RecordedStream stream;
  // A scene that stays, so that frames depend on each other, and something in it that
  // moves.
  const auto scene = randomCloud<pcl::PointXYZI>(99, 160);
  for (std::size_t i = 0; i < size; ++i) {
    const auto cloud =
        randomCloud<pcl::PointXYZI>(100 + static_cast<unsigned int>(i), 40);
    *cloud += *scene;
    stream.frames.push_back(encodeFrame(encoder, cloud));
    stream.is_i_frame.push_back(encoder.getStatistics().coding.is_i_frame);
    EXPECT_EQ(stream.is_i_frame.back(), i % i_frame_rate == 0);
    Cloud::Ptr decoded;
    EXPECT_TRUE(decodeBytes(decoder, stream.frames.back(), decoded).ok());
    stream.decoded.push_back(*decoded);
  }
  return stream;
}

class LossyStreams : public ::testing::TestWithParam<StreamFormat> {};

INSTANTIATE_TEST_SUITE_P(BothFormats,
                         LossyStreams,
                         ::testing::Values(StreamFormat::Version1,
                                           StreamFormat::Published));

TEST_P(LossyStreams, AreRightAgainFromTheNextIFrameOn)
{
  const RecordedStream stream = recordStream(30, 6, GetParam());
  for (const std::set<std::size_t>& lost : std::vector<std::set<std::size_t>>{
           {0}, {1}, {5}, {6}, {3, 4}, {2, 9, 13}, {6, 12, 18}, {0, 1, 2, 3, 4, 5}}) {
    Compression decoder;
    bool is_broken = true; // as long as no I-frame has arrived
    for (std::size_t i = 0; i < stream.frames.size(); ++i) {
      SCOPED_TRACE("frame " + std::to_string(i));
      if (lost.count(i) != 0) {
        is_broken = true;
        continue;
      }
      is_broken = is_broken && !stream.is_i_frame[i];
      Cloud::Ptr decoded;
      const CompressionStatus status = decodeBytes(decoder, stream.frames[i], decoded);
      expectCode(status,
                 is_broken ? CompressionCode::MissingReference : CompressionCode::Ok);
      EXPECT_TRUE(is_broken || sameCloud(*decoded, stream.decoded[i]));
    }
    EXPECT_FALSE(is_broken);
  }
}

TEST_P(LossyStreams, LossInAByteStreamIsTheSame)
{
  const RecordedStream stream = recordStream(12, 4, GetParam());
  std::string bytes;
  for (std::size_t i = 0; i < stream.frames.size(); ++i)
    if (i != 5)
      bytes += stream.frames[i];
  std::istringstream input(bytes);
  Compression decoder;
  std::vector<std::size_t> right;
  for (int round = 0; input && round < 1000; ++round) {
    Cloud::Ptr decoded;
    if (!decoder.decodePointCloud(input, decoded).ok())
      continue;
    for (std::size_t i = 0; i < stream.decoded.size(); ++i)
      if (sameCloud(*decoded, stream.decoded[i]))
        right.push_back(i);
  }
  EXPECT_FALSE(input);
  EXPECT_EQ(right, (std::vector<std::size_t>{0, 1, 2, 3, 4, 8, 9, 10, 11}));
}

TEST(LossyStreamsOfVersion1, NoFlippedBitGivesAWrongCloud)
{
  const RecordedStream stream = recordStream(3, 30, StreamFormat::Version1);
  for (std::size_t byte = 0; byte < stream.frames[1].size(); ++byte) {
    Compression decoder;
    Cloud::Ptr decoded;
    ASSERT_TRUE(decodeBytes(decoder, stream.frames[0], decoded).ok());
    std::string damaged = stream.frames[1];
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << (byte % 8)));
    EXPECT_FALSE(decodeBytes(decoder, damaged, decoded).ok()) << "byte " << byte;
    // The history is untouched: the frame as it was sent still decodes.
    ASSERT_TRUE(decodeBytes(decoder, stream.frames[1], decoded).ok());
    EXPECT_TRUE(sameCloud(*decoded, stream.decoded[1]));
  }
}

TEST(LossyStreamsOfVersion1, ReceiverJoinsLateAfterARequestedIFrame)
{
  Compression encoder(settingsWith(resolution));
  Compression late;
  const auto cloud = randomCloud<pcl::PointXYZI>(20, 200);
  Cloud::Ptr decoded;
  encodeFrame(encoder, cloud);
  expectCode(decodeBytes(late, encodeFrame(encoder, cloud), decoded),
             CompressionCode::MissingReference);
  encoder.requestIFrame();
  EXPECT_TRUE(decodeBytes(late, encodeFrame(encoder, cloud), decoded).ok());
  EXPECT_TRUE(decodeBytes(late, encodeFrame(encoder, cloud), decoded).ok());
  EXPECT_FALSE(late.getStatistics().coding.is_i_frame);
}

} // namespace
