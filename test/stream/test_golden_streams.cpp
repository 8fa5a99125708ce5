// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The streams in test/data/golden decode to the voxels of their checksums, and
 * are written the same today. See write_test_streams.cpp for how they were made.
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

/** \brief The lines of checksums.txt by stream, without its name. */
std::map<std::string, std::vector<std::string>>
expectedLines()
{
  std::map<std::string, std::vector<std::string>> lines;
  std::ifstream file(golden + "checksums.txt");
  EXPECT_TRUE(file.good());
  for (std::string name, line; file >> name && std::getline(file, line);)
    lines[name].push_back(line);
  EXPECT_TRUE(file.eof());
  return lines;
}

TEST(GoldenStreams, DecodeToTheVoxelsOfTheirChecksums)
{
  const auto expected = expectedLines();
  std::map<std::string, bool> is_in_order; // all that comes is its frames, each once
  for (const GoldenStream& stream : goldenStreams())
    is_in_order[stream.name] = stream.sendings.empty();
  EXPECT_EQ(expected.size(), is_in_order.size());
  for (const auto& [name, lines] : expected) {
    SCOPED_TRACE(name);
    std::stringbuf stream(bytesOf(name));
    FrameDecoder decoder;
    decoder.setDecodesVoxels(false);
    GoldenFrame decoded;
    std::vector<std::string> found;
    std::size_t disorder = 0; // skipped bytes, and frames that are not decoded
    for (;;) {
      const CompressionCode code = decoder.decode(stream, decoded.frame).code();
      if (code == CompressionCode::EndOfStream)
        break;
      disorder += decoder.statistics().skipped_bytes;
      if (code != CompressionCode::Ok) {
        ++disorder;
        continue;
      }
      decoded.stamp = decoder.stamp();
      found.push_back((decoder.statistics().is_i_frame ? " I " : " P ") +
                      lineOf(decoded));
    }
    EXPECT_EQ(found, lines);
    EXPECT_EQ(disorder == 0, is_in_order.at(name));
  }
}

TEST(GoldenStreams, AreWrittenTheSameToday)
{
  for (const GoldenStream& stream : goldenStreams()) {
    const Bytes bytes = sent(stream).bytes;
    EXPECT_TRUE(bytesOf(stream.name) == std::string(bytes.begin(), bytes.end()))
        << stream.name;
  }
}

} // namespace
