/** \file
 * \brief OctreePointCloudIntensityCompression when something is missing, broken or
 * lost: a status says so, nothing throws, and the stream goes on.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cfloat>
#include <functional>
#include <ios>
#include <istream>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <streambuf>
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
using pcl_ext::test::expectIntensities;
using pcl_ext::test::expectVoxelCentres;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::randomCloud;
using pcl_ext::test::settingsWith;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
using LocalPoint = pcl::PointXYZINormal;
using LocalCompression = OctreePointCloudIntensityCompression<LocalPoint>;

constexpr double resolution = 0.04;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/** \brief A sink that takes so many bytes and then fails in a way of the test's choice.
 */
class FailingSink : public std::streambuf {
public:
  explicit FailingSink(
      std::size_t capacity, std::function<void()> on_failure = [] {})
  : capacity_(capacity), on_failure_(std::move(on_failure))
  {}

protected:
  int_type
  overflow(int_type byte) override
  {
    if (taken_ == capacity_) {
      on_failure_();
      return traits_type::eof();
    }
    ++taken_;
    return traits_type::not_eof(byte);
  }

private:
  std::size_t capacity_;
  std::size_t taken_ = 0;
  std::function<void()> on_failure_;
};

/** \brief A sink that takes everything and loses it when flushed. */
class SinkThatCannotFlush : public std::stringbuf {
protected:
  int
  sync() override
  {
    return -1;
  }
};

/** \brief A source that breaks down after so many bytes. */
class ThrowingSource : public std::streambuf {
public:
  explicit ThrowingSource(std::string bytes) : bytes_(std::move(bytes))
  {
    setg(&bytes_[0], &bytes_[0], &bytes_[0] + bytes_.size());
  }

protected:
  int_type
  underflow() override
  {
    throw std::runtime_error("the cable is out");
  }

private:
  std::string bytes_;
};

TEST(CompressionInput, ANullCloudIsReportedAndCostsNothing)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 100);
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  const std::string before = stream.str();
  expectCode(encoder.encodePointCloud(Cloud::ConstPtr(), stream),
             CompressionCode::InvalidInput);
  EXPECT_EQ(stream.str(), before);
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  EXPECT_FALSE(encoder.getStatistics().coding.is_i_frame);
  Cloud::Ptr decoded;
  EXPECT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
  EXPECT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
}

TEST(CompressionInput, ANullOutputPointerGetsACloud)
{
  Compression compression(settingsWith(resolution));
  std::stringstream stream(
      encodeFrame(compression, randomCloud<pcl::PointXYZI>(2, 100)));
  Cloud::Ptr decoded;
  EXPECT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  ASSERT_NE(decoded, nullptr);
  EXPECT_FALSE(decoded->empty());
  EXPECT_EQ(compression.getOutputCloud(), decoded);

  std::stringstream nothing;
  Cloud::Ptr empty;
  expectCode(compression.decodePointCloud(nothing, empty),
             CompressionCode::EndOfStream);
  ASSERT_NE(empty, nullptr);
  EXPECT_TRUE(empty->empty());
}

TEST(CompressionInput, EmptyCloudsAreFramesLikeOthers)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  std::stringstream stream;
  const Cloud::Ptr empty(new Cloud);
  const Cloud::Ptr nothing_finite(
      new Cloud(5, 1, pcl::PointXYZI(not_a_number, 0.0f, infinity, 1.0f)));
  const auto cloud = randomCloud<pcl::PointXYZI>(3, 300);
  const std::vector<Cloud::Ptr> frames = {
      empty, empty, cloud, nothing_finite, cloud, empty, cloud, cloud};
  std::size_t end = 0;
  for (const Cloud::Ptr& frame : frames) {
    ASSERT_TRUE(encoder.encodePointCloud(frame, stream).ok());
    const std::size_t bytes = stream.str().size() - end;
    EXPECT_GT(bytes, 0u);
    EXPECT_EQ(encoder.getStatistics().coding.bytes, bytes);
    end += bytes;
  }
  for (const Cloud::Ptr& frame : frames) {
    Cloud::Ptr decoded(new Cloud(17, 2));
    const CompressionStatus status = decoder.decodePointCloud(stream, decoded);
    ASSERT_TRUE(status.ok()) << status.message();
    expectVoxelCentres(*decoded, naiveVoxels(*frame, resolution), resolution);
  }
  Cloud::Ptr decoded;
  expectCode(decoder.decodePointCloud(stream, decoded), CompressionCode::EndOfStream);
}

TEST(CompressionInput, OneAbsurdIntensityDoesNotStopTheStream)
{
  for (const float fraction : {0.0f, 0.25f})
    for (const float absurd :
         {FLT_MAX, -FLT_MAX, FLT_MIN, infinity, -infinity, not_a_number}) {
      SCOPED_TRACE("intensity " + std::to_string(absurd) + " among fractions of " +
                   std::to_string(fraction));
      Compression encoder(settingsWith(resolution));
      Compression decoder;
      const auto cloud = randomCloud<pcl::PointXYZI>(4, 100);
      for (pcl::PointXYZI& point : *cloud)
        point.intensity += fraction;
      const Cloud::Ptr spoilt(new Cloud(*cloud));
      spoilt->at(50).intensity = absurd;
      for (const Cloud::Ptr& frame : {cloud, spoilt, cloud, cloud}) {
        std::stringstream stream;
        const CompressionStatus encoded = encoder.encodePointCloud(frame, stream);
        EXPECT_TRUE(encoded.ok()) << encoded.message();
        Cloud::Ptr decoded;
        ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
        expectVoxelCentres(*decoded, naiveVoxels(*frame, resolution), resolution);
        for (const pcl::PointXYZI& point : *decoded)
          EXPECT_TRUE(std::isfinite(point.intensity));
      }
    }
}

TEST(CompressionInput, OneAbsurdIntensityIsForgottenByTheNextIFrame)
{
  // FLT_MAX and -FLT_MAX are what some drivers write for "no reading".
  for (const float absurd : {FLT_MAX, -FLT_MAX, 1e9f}) {
    SCOPED_TRACE("intensity " + std::to_string(absurd));
    Compression compression(settingsWith(resolution));
    const auto cloud = randomCloud<pcl::PointXYZI>(4, 100);
    const Cloud::Ptr spoilt(new Cloud(*cloud));
    spoilt->at(50).intensity = absurd;
    encodeFrame(compression, spoilt);
    encodeFrame(compression, cloud);
    compression.requestIFrame();
    Cloud::Ptr decoded;
    ASSERT_TRUE(
        decodeBytes(compression, encodeFrame(compression, cloud), decoded).ok());
    expectIntensities(
        *decoded,
        naiveVoxels(*cloud, resolution),
        resolution,
        [](const auto& voxel) { return voxel.mean(); },
        0.5 + 1e-6);
  }
}

/** \brief Encodes three frames, the second into a stream that does not take it. */
void
expectOutputFailure(std::ostream& broken)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  const auto cloud = randomCloud<pcl::PointXYZI>(6, 300);
  Cloud::Ptr decoded;
  ASSERT_TRUE(decodeBytes(decoder, encodeFrame(encoder, cloud), decoded).ok());

  CompressionStatus status;
  ASSERT_NO_THROW(status = encoder.encodePointCloud(cloud, broken));
  expectCode(status, CompressionCode::OutputFailed);

  const std::string next = encodeFrame(encoder, cloud);
  EXPECT_TRUE(encoder.getStatistics().coding.is_i_frame);
  ASSERT_TRUE(decodeBytes(decoder, next, decoded).ok());
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, resolution), resolution);
  encodeFrame(encoder, cloud);
  EXPECT_FALSE(encoder.getStatistics().coding.is_i_frame);
}

TEST(CompressionOutput, AStreamThatTakesNothingIsReported)
{
  FailingSink sink(0);
  std::ostream stream(&sink);
  expectOutputFailure(stream);
}

TEST(CompressionOutput, AStreamThatTakesAFewBytesIsReported)
{
  FailingSink sink(10);
  std::ostream stream(&sink);
  expectOutputFailure(stream);
}

TEST(CompressionOutput, AStreamSetToThrowIsReported)
{
  FailingSink sink(10);
  std::ostream stream(&sink);
  stream.exceptions(std::ios_base::badbit | std::ios_base::failbit);
  expectOutputFailure(stream);
}

TEST(CompressionOutput, ABufferThatThrowsIsReported)
{
  for (const bool is_set_to_throw : {false, true}) {
    FailingSink sink(10, [] { throw std::runtime_error("disk full"); });
    std::ostream stream(&sink);
    if (is_set_to_throw)
      stream.exceptions(std::ios_base::badbit);
    expectOutputFailure(stream);
  }
}

TEST(CompressionOutput, AStreamThatCannotFlushIsReported)
{
  SinkThatCannotFlush sink;
  std::ostream stream(&sink);
  expectOutputFailure(stream);
}

TEST(CompressionOutput, AStreamWithoutABufferIsReported)
{
  std::ostream stream(nullptr);
  expectOutputFailure(stream);
}

TEST(CompressionOutput, AStreamThatFailedBeforeIsReported)
{
  std::ostringstream stream;
  stream.setstate(std::ios_base::failbit);
  expectOutputFailure(stream);
  EXPECT_TRUE(stream.str().empty());
}

TEST(CompressionSource, TheEndSetsTheBitsThatEndALoop)
{
  Compression compression(settingsWith(resolution));
  std::stringstream stream;
  for (unsigned int frame = 0; frame < 3; ++frame)
    ASSERT_TRUE(
        compression.encodePointCloud(randomCloud<pcl::PointXYZI>(frame, 50), stream)
            .ok());
  int decoded_frames = 0;
  Cloud::Ptr decoded;
  for (int round = 0; stream && round < 10; ++round)
    decoded_frames += compression.decodePointCloud(stream, decoded).ok() ? 1 : 0;
  EXPECT_EQ(decoded_frames, 3);
  EXPECT_TRUE(stream.eof());
  EXPECT_TRUE(stream.fail());
  EXPECT_FALSE(stream.bad());
}

TEST(CompressionSource, AStreamSetToThrowDoesNot)
{
  Compression compression(settingsWith(resolution));
  const std::string frame =
      encodeFrame(compression, randomCloud<pcl::PointXYZI>(7, 100));
  struct Case {
    std::string bytes;
    CompressionCode code;
  };
  for (const Case& test_case :
       {Case{"", CompressionCode::EndOfStream},
        Case{"neither here nor there", CompressionCode::NoFrame},
        Case{frame.substr(0, frame.size() - 1), CompressionCode::Truncated},
        Case{frame, CompressionCode::Ok}}) {
    std::istringstream stream(test_case.bytes);
    stream.exceptions(std::ios_base::badbit | std::ios_base::failbit |
                      std::ios_base::eofbit);
    Cloud::Ptr decoded(new Cloud(3, 1));
    CompressionStatus status;
    ASSERT_NO_THROW(status = compression.decodePointCloud(stream, decoded));
    expectCode(status, test_case.code);
    EXPECT_EQ(decoded->empty(), !status.ok());
  }
}

TEST(CompressionSource, ABufferThatThrowsIsReported)
{
  Compression encoder(settingsWith(resolution));
  const std::string frame = encodeFrame(encoder, randomCloud<pcl::PointXYZI>(8, 100));
  for (const std::size_t size : {std::size_t{1}, std::size_t{20}, frame.size() - 1}) {
    Compression decoder;
    ThrowingSource source(frame.substr(0, size));
    std::istream stream(&source);
    Cloud::Ptr decoded(new Cloud(3, 1));
    CompressionStatus status;
    ASSERT_NO_THROW(status = decoder.decodePointCloud(stream, decoded));
    expectCode(status, CompressionCode::InputFailed);
    EXPECT_NE(status.message().find("the cable is out"), std::string::npos);
    EXPECT_TRUE(decoded->empty());
    EXPECT_TRUE(decodeBytes(decoder, frame, decoded).ok());
  }
}

TEST(CompressionSource, AStreamWithoutABufferIsReported)
{
  Compression decoder;
  std::istream stream(nullptr);
  Cloud::Ptr decoded(new Cloud(3, 1));
  expectCode(decoder.decodePointCloud(stream, decoded), CompressionCode::InputFailed);
  EXPECT_TRUE(decoded->empty());
}

TEST(CompressionSource, EveryPrefixOfAFrameIsReportedAndTheFrameStillDecodes)
{
  Compression encoder(settingsWith(resolution));
  Compression decoder;
  const std::string frame = encodeFrame(encoder, randomCloud<pcl::PointXYZI>(9, 40));
  Cloud::Ptr decoded;
  for (std::size_t size = 0; size < frame.size(); ++size) {
    const CompressionStatus status =
        decodeBytes(decoder, frame.substr(0, size), decoded);
    const CompressionCode code = size == 0  ? CompressionCode::EndOfStream
                                 : size < 4 ? CompressionCode::NoFrame
                                            : CompressionCode::Truncated;
    expectCode(status, code);
  }
  EXPECT_TRUE(decodeBytes(decoder, frame, decoded).ok());
}

TEST(CompressionSource, DecoderLimitsHoldAndSmallerFramesGoOn)
{
  Compression encoder(settingsWith(resolution));
  const auto small = randomCloud<pcl::PointXYZI>(10, 100);
  const auto large = randomCloud<pcl::PointXYZI>(11, 5000);
  const std::string large_frame = encodeFrame(encoder, large);
  encoder.requestIFrame();
  const std::string small_frame = encodeFrame(encoder, small);

  IntensityCompressionSettings few_voxels = settingsWith(resolution);
  few_voxels.decoder_limits.max_voxels = 100;
  IntensityCompressionSettings few_bytes = settingsWith(resolution);
  few_bytes.decoder_limits.max_frame_bytes = small_frame.size();
  for (const auto& settings : {few_voxels, few_bytes}) {
    Compression decoder(settings);
    Cloud::Ptr decoded;
    expectCode(decodeBytes(decoder, large_frame, decoded),
               CompressionCode::LimitExceeded);
    EXPECT_TRUE(decodeBytes(decoder, small_frame, decoded).ok());
    EXPECT_EQ(decoded->size(), naiveVoxels(*small, resolution).size());
  }
}

/** \brief Settings that cannot be used, and a word that their message must hold. */
struct InvalidSettings {
  std::string field;
  std::function<void(IntensityCompressionSettings&)> spoil;
};

template <typename CompressionT, typename PointT>
void
expectEveryCallToRefuse(const InvalidSettings& invalid)
{
  SCOPED_TRACE(invalid.field);
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.retain_octree = true;
  invalid.spoil(settings);
  CompressionT compression(settings);
  const auto expect_refusal = [&](const CompressionStatus& status) {
    expectCode(status, CompressionCode::InvalidSettings);
    EXPECT_NE(status.message().find(invalid.field), std::string::npos)
        << status.message();
  };
  for (int round = 0; round < 2; ++round) {
    std::stringstream stream;
    expect_refusal(compression.encodePointCloud(randomCloud<PointT>(12, 50), stream));
    EXPECT_TRUE(stream.str().empty());
    expect_refusal(compression.encodePointCloud(nullptr, stream));
    typename pcl::PointCloud<PointT>::Ptr decoded(new pcl::PointCloud<PointT>(4, 1));
    expect_refusal(compression.decodePointCloud(stream, decoded));
    EXPECT_TRUE(decoded->empty());
    EXPECT_EQ(compression.getOutputCloud(), decoded);
    compression.requestIFrame();
  }
  EXPECT_EQ(compression.getLeafCount(), 0u);
  EXPECT_FALSE(compression.isVoxelOccupiedAtPoint(PointT()));
  EXPECT_EQ(compression.getVoxelIntensityAtPoint(PointT()), 0.0f);
  EXPECT_GT(compression.getResolution(), 0.0);
  EXPECT_EQ(compression.getStatistics().coding.bytes, 0u);
}

TEST(InvalidCompressionSettings, EveryCallReportsThem)
{
  const std::vector<InvalidSettings> all = {
      {"resolution", [](auto& settings) { settings.resolution = 0.0; }},
      {"resolution", [](auto& settings) { settings.resolution = -0.04; }},
      {"resolution",
       [](auto& settings) {
         settings.resolution = std::numeric_limits<double>::quiet_NaN();
       }},
      {"resolution",
       [](auto& settings) {
         settings.resolution = std::numeric_limits<double>::infinity();
       }},
      {"intensity_range", [](auto& settings) { settings.intensity_range = -1.0f; }},
      {"intensity_bits", [](auto& settings) { settings.intensity_bits = 17; }},
      {"bounding_box",
       [](auto& settings) {
         settings.bounding_box = BoundingBox{{1.0, 0.0, 0.0}, {0.0, 1.0, 1.0}};
       }},
      {"sensor_pose",
       [](auto& settings) {
         settings.sensor_pose = Eigen::Isometry3f::Identity();
         settings.sensor_pose->translation().x() = not_a_number;
       }},
      {"limit", [](auto& settings) { settings.decoder_limits.max_voxels = 0; }},
      {"carry_header", [](auto& settings) {
         settings.format = StreamFormat::Published;
         settings.carry_header = true;
       }}};
  for (const InvalidSettings& invalid : all) {
    expectEveryCallToRefuse<Compression, pcl::PointXYZI>(invalid);
    expectEveryCallToRefuse<LocalCompression, LocalPoint>(invalid);
    expectEveryCallToRefuse<LocalCompression::SinglePointCloudCompressionLowMemory,
                            LocalPoint>(invalid);
  }
}

} // namespace
