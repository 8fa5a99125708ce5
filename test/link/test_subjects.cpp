// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "link/frame_headers.h"
#include "link/subjects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace {

using namespace pcl_ext::link;

TEST(Subjects, HaveAnyNameInOneWord)
{
  std::string all;
  for (int byte = 0; byte < 256; ++byte)
    all += static_cast<char>(byte);
  const std::string subject = framesSubject("cell", all);
  EXPECT_EQ(std::count(subject.begin(), subject.end(), '.'), 2);
  EXPECT_EQ(subject.find_first_of(" \t\r\n*>$"), std::string::npos);
  const auto parsed = parseFramesSubject("cell", subject);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->stream, all);
  EXPECT_FALSE(parsed->partition);
  EXPECT_EQ(framesSubject("cell", "/a b.c"), "cell./a%20b%2Ec.frames");
  EXPECT_EQ(requestsSubject("cell", "/a b.c"), "cell./a%20b%2Ec.requests");
}

TEST(Subjects, MayHaveAPartition)
{
  const auto parsed = parseFramesSubject("cell", "cell./sensor_1.frames.12");
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->stream, "/sensor_1");
  EXPECT_EQ(parsed->partition, 12u);
}

TEST(Subjects, OfAnotherKindAreNone)
{
  for (const char* const subject : {"",
                                    "cell",
                                    "cell.",
                                    "cell..frames",
                                    "cell.a",
                                    "cell.a.frame",
                                    "cell.a.requests",
                                    "cell.a.frames.",
                                    "cell.a.frames.x",
                                    "cell.a.frames.1.2",
                                    "cell.a.frames.-1",
                                    "cell.a.frames.99999999999",
                                    "cell.a.framesx",
                                    "cell.%.frames",
                                    "cell.%2.frames",
                                    "cell.%2g.frames",
                                    "cell.%2e.frames", // one name, one subject
                                    "cell.%61.frames",
                                    "cell.a b.frames",
                                    "cells.a.frames",
                                    "other.a.frames"})
    EXPECT_FALSE(parseFramesSubject("cell", subject)) << subject;
  const std::string longest(longest_stream_name, '.');
  EXPECT_TRUE(parseFramesSubject("cell", framesSubject("cell", longest)));
  EXPECT_FALSE(parseFramesSubject("cell", framesSubject("cell", longest + "a")));
}

TEST(FrameHeaders, ComeBack)
{
  const FrameHeader header{0xfedcba9876543210u, 18446744073709551615u, Time(-5)};
  const std::string text = writeFrameHeader(header);
  EXPECT_EQ(text, "1 fedcba9876543210 18446744073709551615 -5");
  const auto parsed = parseFrameHeader(text);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->publisher, header.publisher);
  EXPECT_EQ(parsed->number, header.number);
  EXPECT_EQ(parsed->time, header.time);
  EXPECT_EQ(writeMetadata("a=b", "x\r\ny"), "a%3Db=x%0D%0Ay");
  EXPECT_EQ(parseMetadata("a%3Db=x%0D%0Ay"),
            std::pair(std::string("a=b"), std::string("x\r\ny")));
}

TEST(FrameHeaders, OfAnotherFormAreNone)
{
  for (const char* const text : {"",
                                 "1",
                                 "1 a 1",
                                 "1 a 0 5",
                                 "2 a 1 5",
                                 "1 a 1 5 ",
                                 "1 a 1 5 6",
                                 "1  a 1 5",
                                 "1 g 1 5",
                                 "1 a -1 5",
                                 "1 a 1 x",
                                 "1 a 18446744073709551616 5",
                                 "1 a 1 9223372036854775808",
                                 "1 a 1 4611686018427387905",
                                 "1 a 1 -9223372036854775808"})
    EXPECT_FALSE(parseFrameHeader(text)) << text;
  for (const char* const text : {"", "a", "a b=c", "a=%", "a=b=c"})
    EXPECT_FALSE(parseMetadata(text)) << text;
}

} // namespace
