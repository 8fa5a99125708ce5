/** \file
 * \brief The streams in test/data/golden decode to the voxels of their checksums, and are
 * written the same today. See write_test_streams.cpp for how they were made.
 */
#include "support/golden_streams.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

const std::string golden = PCL_EXT_TEST_DATA "/golden/";

std::string
bytesOf(const std::string& name)
{
  std::ifstream file(golden + name + ".pcxi", std::ios::binary);
  EXPECT_TRUE(file.good()) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

/** \brief A frame in checksums.txt. */
struct ExpectedFrame {
  bool is_i_frame;
  std::size_t voxels;
  std::uint64_t checksum;
  std::string stamp; ///< "-" if there is none
};

std::map<std::string, std::vector<ExpectedFrame>>
expectedFrames()
{
  std::map<std::string, std::vector<ExpectedFrame>> frames;
  std::ifstream file(golden + "checksums.txt");
  EXPECT_TRUE(file.good());
  std::string name;
  char kind = 0;
  ExpectedFrame frame{};
  while (file >> name >> kind >> frame.voxels >> std::hex >> frame.checksum >>
         std::dec >> frame.stamp) {
    frame.is_i_frame = kind == 'I';
    frames[name].push_back(frame);
  }
  EXPECT_TRUE(file.eof());
  return frames;
}

TEST(GoldenStreams, DecodeToTheVoxelsOfTheirChecksums)
{
  const auto expected = expectedFrames();
  EXPECT_EQ(expected.size(), goldenStreams().size());
  for (const auto& [name, frames] : expected) {
    SCOPED_TRACE(name);
    std::stringbuf stream(bytesOf(name));
    FrameDecoder decoder;
    VoxelFrame frame;
    for (const ExpectedFrame& expected_frame : frames) {
      const CompressionStatus status = decoder.decode(stream, frame);
      EXPECT_TRUE(status.ok()) << status.message();
      EXPECT_EQ(decoder.statistics().is_i_frame, expected_frame.is_i_frame);
      EXPECT_EQ(decoder.statistics().skipped_bytes, 0u);
      EXPECT_EQ(frame.size(), expected_frame.voxels);
      EXPECT_EQ(VoxelChecksum(frame).value(), expected_frame.checksum);
      EXPECT_EQ(decoder.stamp() ? std::to_string(decoder.stamp()->stamp) : "-",
                expected_frame.stamp);
    }
    EXPECT_EQ(decoder.decode(stream, frame).code(), CompressionCode::EndOfStream);
  }
}

TEST(GoldenStreams, AreWrittenTheSameToday)
{
  for (const GoldenStream& stream : goldenStreams()) {
    FrameEncoder encoder(StreamFormat::Version1, stream.i_frame_rate, stream.effort);
    Bytes bytes;
    for (const GoldenFrame& frame : stream.frames)
      append(encoded(encoder, frame.frame, frame.stamp), bytes);
    EXPECT_TRUE(bytesOf(stream.name) == std::string(bytes.begin(), bytes.end()))
        << stream.name;
  }
}

} // namespace
