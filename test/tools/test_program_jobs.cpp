// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace pcl_ext::tools::test {

namespace {

class ProgramJobs : public ProgramTest {
protected:
  /** \brief Expects that what encode leaves and prints is the same for 1, 2 and 5 jobs,
   * without remarks, as one is on jobs. */
  void
  expectSameForAllJobs(const std::string& arguments) const
  {
    const std::string encode = "encode " + arguments + " -q -o made.mcap --overwrite";
    const ProgramRun one = run(encode);
    EXPECT_EQ(one.status, 1) << one.errors;
    const Bytes bytes = bytesOf(folder / "made.mcap");
    EXPECT_GT(bytes.size(), 10'000u);
    for (const std::string jobs : {"2", "5"}) {
      const ProgramRun several = run(encode + " --jobs " + jobs);
      EXPECT_EQ(several.status, 1) << arguments;
      EXPECT_EQ(several.output, one.output) << arguments;
      EXPECT_EQ(several.errors, one.errors) << arguments;
      EXPECT_TRUE(bytesOf(folder / "made.mcap") == bytes) << arguments << ' ' << jobs;
    }
  }
};

} // namespace

TEST_F(ProgramJobs, BytesAndMessagesAreTheSameForEachNumber)
{
  writeUnevenBag(folder / "bag.mcap", 290);
  // Both topics, with fewer jobs than topics and with more; one; and those that are not
  // divided.
  for (const std::string options : {"",
                                    "--topics /fast",
                                    "--topics /slow",
                                    "--frames 17:270",
                                    "--max-rate 200kbit/s",
                                    "--temporal-filter --law none"})
    expectSameForAllJobs("bag.mcap -r 0.05 " + options);
  Bytes bytes = bytesOf(folder / "bag.mcap");
  bytes.resize(bytes.size() * 3 / 4);
  writeBytes(folder / "cut_off.mcap", bytes);
  expectSameForAllJobs("cut_off.mcap -r 0.05");
  bytes = bytesOf(folder / "bag.mcap");
  bytes[bytes.size() / 2] ^= 1u; // in a chunk, whose checksum tells
  writeBytes(folder / "damaged.mcap", bytes);
  expectSameForAllJobs("damaged.mcap -r 0.05");
}

TEST_F(ProgramJobs, PartsBeginWithAnIFrameAndGoOnWithTheNumbers)
{
  writeClouds("room", roomClouds(155));
  expectRun("encode room -o whole.pcxi -r 0.1 --i-frame-rate 50 -q -j 3");
  const DecodedStream whole = decode(folder / "whole.pcxi")[0];
  ASSERT_EQ(whole.frames.size(), 155u);
  for (std::size_t i = 0; i < whole.frames.size(); ++i) {
    EXPECT_EQ(whole.frames[i].description.frame_number, i + 1);
    // A part has three times 50 clouds, as 120 are too few.
    EXPECT_EQ(whole.frames[i].description.is_i_frame, i % 50 == 0) << i;
  }
}

TEST_F(ProgramJobs, IFramesComeByTimes)
{
  writeClouds("room", roomClouds(40));
  const std::string command =
      "encode room -o whole.mcap --rate 10 -r 0.1 --i-frame-rate 1000 -q --overwrite ";
  for (const auto& [option, clouds] :
       std::vector<std::pair<std::string, std::size_t>>{{"--i-frame-every=500ms", 5},
                                                        {"--i-frame-every 0.25", 3},
                                                        {"--i-frame-every 0", 1000}}) {
    expectRun(command + option);
    const DecodedStream whole = decode(folder / "whole.mcap")[0];
    ASSERT_EQ(whole.frames.size(), 40u);
    for (std::size_t i = 0; i < whole.frames.size(); ++i)
      EXPECT_EQ(whole.frames[i].description.is_i_frame, i % clouds == 0)
          << option << ' ' << i;
  }
}

TEST_F(ProgramJobs, AnInterruptionLeavesNoGapBetweenParts)
{
  writeBag(folder / "bag.mcap", 360);
  const ProgramRun result =
      runShell("\"$P\" encode bag.mcap --topics /front/points -j 3 -o x.mcap -e small "
               "& p=$!; i=0; "
               "until [ $(stat -c %s x.mcap.unfinished || echo 0) -gt 500000 ] || [ $i "
               "= 2000 ]; "
               "do i=$((i+1)); sleep 0.002; done 2> /dev/null; kill -INT $p; wait $p");
  EXPECT_EQ(result.status, 130) << result.output;
  expectRun("encode bag.mcap --topics /front/points -o whole.mcap -e small -j 3");
  const DecodedStream whole = decode(folder / "whole.mcap")[0];
  const DecodedStream part = decode(folder / "x.mcap")[0];
  ASSERT_LT(part.frames.size(), whole.frames.size());
  for (std::size_t i = 0; i < part.frames.size(); ++i)
    EXPECT_TRUE(part.frames[i].bytes == whole.frames[i].bytes) << i;
  EXPECT_EQ(
      result.output.find("x.mcap: " + std::to_string(part.frames.size()) + " frame"),
      0u)
      << result.output;
}

TEST_F(ProgramJobs, StreamsWithoutFramesAndOptionsThatPreventSharingAreTold)
{
  writeUnevenBag(folder / "bag.mcap", 10); // with two clouds of /slow
  EXPECT_TRUE(hasPart(run("encode bag.mcap --frames 3:6 -o x.mcap").output,
                      "x.mcap: 3 frames, "));
  const std::string options = "--topics /fast --max-rate 1Mbit/s -j 2 -o y.mcap";
  EXPECT_TRUE(hasPart(run("encode bag.mcap " + options).errors,
                      "--jobs 2 is more than there are streams: with --max-rate"));
}

TEST_F(ProgramJobs, JsonHasWhatTheSummaryHas)
{
  writeUnevenBag(folder / "bag.mcap", 60);
  const ProgramRun result = run("encode bag.mcap -o x.mcap -j 2 --json");
  EXPECT_EQ(result.status, 1);
  const auto json = nlohmann::json::parse(result.output);
  ASSERT_EQ(json["bags"].size(), 1u);
  const auto& bag = json["bags"][0];
  EXPECT_EQ(bag["inputs"][0], "bag.mcap");
  EXPECT_EQ(bag["output"], "x.mcap");
  EXPECT_EQ(bag["status"], "incomplete");
  EXPECT_EQ(bag["frames"], 66); // of 60 and 9, less 1 and 2
  EXPECT_EQ(bag["failures"], 3);
  EXPECT_EQ(bag["streams"][1]["name"], "/slow");
  EXPECT_EQ(bag["streams"][1]["frames"], 7);
  EXPECT_EQ(bag["streams"][1]["failures"], 2);
  EXPECT_FALSE(bag["errors"].empty());
}

} // namespace pcl_ext::tools::test
