// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"
#include "support/text_parts.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <ios>
#include <istream>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <utility>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

/** \brief A sink that takes some bytes and then fails as a function says. */
class FailingSink : public std::streambuf {
public:
  FailingSink(std::size_t capacity, std::function<void()> on_failure)
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

TEST(CompressionInput, ANullCloudIsReportedAndCostsNothing)
{
  Compression encoder(settingsWith(usual_resolution));
  Compression decoder;
  std::stringstream stream;
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 100);
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  const std::string before = stream.str();
  expectCode(encoder.encodePointCloud(Cloud::ConstPtr(), stream),
             CompressionCode::InvalidInput);
  EXPECT_EQ(stream.str(), before);
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  EXPECT_FALSE(encoder.statistics().coding.is_i_frame);
  Cloud::Ptr decoded;
  EXPECT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
  EXPECT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
}

TEST(CompressionInput, ANullOutputPointerGetsACloud)
{
  Compression compression(settingsWith(usual_resolution));
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

/** \brief Encodes three frames, the second into a stream that does not take it. */
void
expectOutputFailure(std::ostream& broken, const std::string& words)
{
  Compression encoder(settingsWith(usual_resolution));
  Compression decoder;
  const auto cloud = randomCloud<pcl::PointXYZI>(6, 300);
  Cloud::Ptr decoded;
  ASSERT_TRUE(decodeBytes(decoder, encodeFrame(encoder, cloud), decoded).ok());

  CompressionStatus status;
  ASSERT_NO_THROW(status = encoder.encodePointCloud(cloud, broken));
  expectCode(status, CompressionCode::OutputFailed);
  EXPECT_TRUE(hasPart(status.message(), words));

  const std::string next = encodeFrame(encoder, cloud);
  EXPECT_TRUE(encoder.statistics().coding.is_i_frame);
  ASSERT_TRUE(decodeBytes(decoder, next, decoded).ok());
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, usual_resolution), usual_resolution);
  encodeFrame(encoder, cloud);
  EXPECT_FALSE(encoder.statistics().coding.is_i_frame);
}

TEST(CompressionOutput, FailuresAreReported)
{
  for (const std::size_t capacity : {0u, 10u})
    for (const bool is_set_to_throw : {false, true})
      for (const bool throws : {false, true}) {
        SCOPED_TRACE(std::to_string(capacity) +
                     (is_set_to_throw ? ", exceptions" : "") +
                     (throws ? ", throws" : ""));
        FailingSink sink(capacity, [throws] {
          if (throws)
            throw std::runtime_error("disk full");
        });
        std::ostream stream(&sink);
        if (is_set_to_throw)
          stream.exceptions(std::ios_base::badbit | std::ios_base::failbit);
        expectOutputFailure(stream, "writing a frame of ");
      }
  SinkThatCannotFlush cannot_flush;
  std::ostream unflushed(&cannot_flush);
  expectOutputFailure(unflushed, "writing a frame of ");
  std::ostream without_buffer(nullptr);
  expectOutputFailure(without_buffer, "failed state");
  std::ostringstream failed_before;
  failed_before.setstate(std::ios_base::failbit);
  expectOutputFailure(failed_before, "failed state");
  EXPECT_TRUE(failed_before.str().empty());
  std::ofstream wrong_path("/no/such/folder/frames.pcxi", std::ios::binary);
  wrong_path.clear(); // does not open it
  expectOutputFailure(wrong_path, "not open");
  std::ofstream never_opened;
  expectOutputFailure(never_opened, "not open");
}

TEST(CompressionSource, TheEndSetsTheBitsThatEndALoop)
{
  Compression compression(settingsWith(usual_resolution));
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

TEST(CompressionSource, ThatCannotBeReadIsBadAsForAnyRead)
{
  std::ifstream folder("."); // opens, as a file does
  Compression compression(settingsWith(usual_resolution));
  Cloud::Ptr decoded;
  expectCode(compression.decodePointCloud(folder, decoded),
             CompressionCode::InputFailed);
  EXPECT_TRUE(folder.bad());
  EXPECT_TRUE(decoded->empty());
}

TEST(CompressionSource, AStreamSetToThrowDoesNot)
{
  Compression compression(settingsWith(usual_resolution));
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

TEST(CompressionSource, ThatIsNotOpenOrHasFailedIsReported)
{
  std::ifstream wrong_path("/no/such/folder/frames.pcxi", std::ios::binary);
  std::ifstream never_opened;
  std::istream without_buffer(nullptr);
  std::istringstream failed("1 x");
  int number = 0;
  failed >> number >> number;
  const std::pair<std::istream*, const char*> inputs[] = {
      {&wrong_path, "not open"},
      {&never_opened, "not open"},
      {&without_buffer, "no buffer"},
      {&failed, "had failed before the call"}};
  for (const auto& [stream, words] : inputs) {
    Compression decoder(settingsWith(usual_resolution));
    Cloud::Ptr decoded(new Cloud(3, 1));
    const CompressionStatus status = decoder.decodePointCloud(*stream, decoded);
    expectCode(status, CompressionCode::InputFailed);
    EXPECT_TRUE(hasPart(status.message(), words));
    EXPECT_TRUE(decoded->empty());
  }
}

TEST(CompressionSource, AnIncompleteFrameStaysInTheStreamIfToldTo)
{
  Compression encoder(settingsWith(usual_resolution));
  const std::string frame = encodeFrame(encoder, randomCloud<pcl::PointXYZI>(1, 100));
  IntensityCompressionSettings settings;
  settings.incomplete_frame = IncompleteFrame::Keep;
  Compression decoder(settings);
  std::stringstream stream;
  Cloud::Ptr decoded;
  stream << frame.substr(0, frame.size() / 2);
  expectCode(decoder.decodePointCloud(stream, decoded), CompressionCode::Truncated);
  EXPECT_TRUE(stream.good());
  stream << frame.substr(frame.size() / 2);
  expectCode(decoder.decodePointCloud(stream, decoded), CompressionCode::Ok);
}

} // namespace
