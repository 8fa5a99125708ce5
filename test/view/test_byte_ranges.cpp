// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/byte_ranges.h"

#include <gtest/gtest.h>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

/** \brief The ranges of a header for a file of 1000 bytes, such as "0-9 5-5"; "whole"
 * if it is ignored. */
std::string
rangesOf(const std::string& header)
{
  const auto ranges = parseByteRanges(header, 1000);
  if (!ranges)
    return "whole";
  std::string text;
  for (const ByteRange& range : *ranges)
    text += (text.empty() ? "" : " ") + std::to_string(range.first) + "-" +
            std::to_string(range.last);
  return text;
}

} // namespace

TEST(ByteRanges, AreThoseOfTheHeaderInTheFile)
{
  EXPECT_EQ(rangesOf("bytes=0-0"), "0-0");
  EXPECT_EQ(rangesOf("bytes=10-19"), "10-19");
  EXPECT_EQ(rangesOf("bytes=999-999"), "999-999");
  EXPECT_EQ(rangesOf("bytes=990-"), "990-999");
  EXPECT_EQ(rangesOf("bytes=990-5000"), "990-999");
  EXPECT_EQ(rangesOf("bytes=-1"), "999-999");
  EXPECT_EQ(rangesOf("bytes=-1000"), "0-999");
  EXPECT_EQ(rangesOf("bytes=-99999999"), "0-999");
  EXPECT_EQ(rangesOf("bytes=0-0, 5-9 ,-2"), "0-0 5-9 998-999");
  EXPECT_EQ(rangesOf("bytes=,0-0,,1-1,"), "0-0 1-1");
  EXPECT_EQ(rangesOf("bytes=2000-3000,1-2"), "1-2");
}

TEST(ByteRanges, OutsideOfTheFileCannotBeSatisfied)
{
  EXPECT_EQ(rangesOf("bytes=1000-"), "");
  EXPECT_EQ(rangesOf("bytes=1000-1001,5000-"), "");
  EXPECT_EQ(rangesOf("bytes=-0"), "");
  EXPECT_TRUE(parseByteRanges("bytes=-5", 0)->empty());
  EXPECT_TRUE(parseByteRanges("bytes=0-", 0)->empty());
}

TEST(ByteRanges, WrongHeadersAreIgnored)
{
  for (const char* header : {"",
                             "bytes",
                             "bytes=",
                             "bytes=,",
                             "bytes=-",
                             "bytes=5",
                             "bytes=9-5",
                             "bytes=a-b",
                             "bytes=0x1-2",
                             "bytes=+1-2",
                             "bytes=1--2",
                             "bytes=--2",
                             "bytes= 1 - 2",
                             "bytes=0-99999999999999999999999",
                             "lines=0-1",
                             "0-1"})
    EXPECT_EQ(rangesOf(header), "whole") << header;
}

TEST(ByteRanges, TooManyAreIgnored)
{
  std::string header = "bytes=0-0";
  for (std::size_t i = 1; i < max_byte_ranges; ++i)
    header += ",0-0";
  EXPECT_EQ(parseByteRanges(header, 1000)->size(), max_byte_ranges);
  EXPECT_EQ(rangesOf(header + ",0-0"), "whole");
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test
