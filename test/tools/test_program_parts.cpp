// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>

namespace pcl_ext::tools::test {

namespace {

/** \brief Records three frames of /sensor_0 with metadata. */
void
recordWith(const std::string& path,
           std::chrono::seconds later,
           const std::map<std::string, std::string>& metadata)
{
  recording::RecordingWriter writer;
  std::size_t number = 0;
  ASSERT_TRUE(writer.open(path).ok());
  ASSERT_TRUE(writer.addStream({"/sensor_0", "world", metadata}, number).ok());
  for (const auto& frame : knownStream(0, 3, 1).frames)
    ASSERT_TRUE(
        writer
            .append(number, frame.time + later, frame.bytes.data(), frame.bytes.size())
            .ok());
  ASSERT_TRUE(writer.finish().ok());
}

} // namespace

using ProgramCut = ProgramTest;
using ProgramMerge = ProgramTest;

TEST_F(ProgramCut, BeginsAtAnIFrameAndKeepsTheBytes)
{
  recordTwoStreams(folder / "x.mcap");
  const std::vector<DecodedStream> all = decode(folder / "x.mcap");
  const ProgramRun result =
      run("cut --streams /sensor_0 x.mcap -o part.pcxi --frames 23:27 -q");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output,
            "part.pcxi: 7 frames of 1 stream, 3 frames of these before the first ones "
            "asked for, from I-frames on, without which those cannot be decoded\n");
  const std::vector<DecodedStream> part = decode(folder / "part.pcxi");
  ASSERT_EQ(part.size(), 1u);
  EXPECT_EQ(part[0].frames.size(), 7u);
  expectSameFrames(all[0], 20, part[0]);
}

TEST_F(ProgramCut, FramesStayInOrderIfTheClockWasSetBack)
{
  std::vector<KnownStream> streams = {knownStream(0, 20, 10)};
  for (std::size_t i = 13; i < 20; ++i)
    streams[0].frames[i].time -= std::chrono::milliseconds(350);
  record(streams, folder / "x.mcap");
  expectRun("cut x.mcap -o part.mcap --frames 10:20");
  const std::vector<DecodedStream> part = decode(folder / "part.mcap");
  ASSERT_EQ(part.size(), 1u);
  ASSERT_EQ(part[0].frames.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(part[0].frames[i].bytes, streams[0].frames[10 + i].bytes) << i;
    EXPECT_EQ(part[0].frames[i].time, streams[0].frames[10 + i].time) << i;
  }
}

TEST_F(ProgramMerge, PartsBecomeOneStreamAgain)
{
  recordTwoStreams(folder / "x.mcap");
  expectRun("cut x.mcap -o a.mcap --to 0.999");
  expectRun("cut x.mcap -o b.mcap --streams /sensor_0 --from 1");
  expectRun("cut x.mcap -o c.pcxi --streams /sensor_1 --frames 21:");
  expectRun("merge b.mcap a.mcap -o ab.mcap");
  const std::vector<DecodedStream> all = decode(folder / "x.mcap");
  const std::vector<DecodedStream> merged = decode(folder / "ab.mcap");
  ASSERT_EQ(merged.size(), 2u);
  for (const DecodedStream& stream : merged) {
    const DecodedStream& original = all[stream.name == all[0].name ? 0 : 1];
    EXPECT_EQ(stream.frames.size(), stream.name == "/sensor_0" ? 40u : 20u);
    expectSameFrames(original, 0, stream);
    for (std::size_t i = 0; i < stream.frames.size(); ++i)
      EXPECT_EQ(stream.frames[i].time, original.frames[i].time);
  }
  expectRun("cut x.mcap -o d.pcxi --streams /sensor_1 --frames :21");
  expectRun("merge d.pcxi c.pcxi -o dc.pcxi");
  const std::vector<DecodedStream> of_files = decode(folder / "dc.pcxi");
  EXPECT_EQ(of_files[0].frames.size(), 31u);
  expectSameFrames(all[1], 0, of_files[0]);
}

TEST_F(ProgramMerge, StreamsOfOneNameAtTheSameTimeAreToldApartByPrefixes)
{
  recordTwoStreams(folder / "x.mcap");
  KnownStream other = knownStream(3, 20, 5);
  other.name = "/sensor_0";
  record({other}, folder / "z.mcap");
  expectFailure(
      "merge x.mcap z.mcap -o y.mcap",
      2,
      "the stream /sensor_0 has other frames of the same time in 'x.mcap' and "
      "in 'z.mcap'");
  expectRun("cut x.mcap -o one.mcap --streams /sensor_0");
  expectFailure("merge one.mcap z.mcap -o y.pcxi",
                2,
                "'y.pcxi' has one stream, and there are other frames of the same time");
  expectRun("merge x.mcap x.mcap -o y.mcap --prefix left,right");
  const std::vector<DecodedStream> streams = decode(folder / "y.mcap");
  ASSERT_EQ(streams.size(), 4u);
  EXPECT_EQ(streams[0].name, "/left/sensor_0");
  EXPECT_EQ(streams[3].name, "/right/sensor_1");
  expectSameFrames(decode(folder / "x.mcap")[1], 0, streams[3]);
}

TEST_F(ProgramMerge, PartsThatTellDifferentThingsOfTheCloudsAreRefused)
{
  using std::chrono::seconds;
  recordWith(folder / "a.mcap",
             seconds(0),
             {{"intensity_law", "count"}, {"sensor_pose", "0,0,0,0,0,0,1"}});
  recordWith(folder / "law.mcap",
             seconds(9),
             {{"intensity_law", "quadratic"}, {"sensor_pose", "0,0,0,0,0,0,1"}});
  recordWith(folder / "pose.mcap",
             seconds(9),
             {{"intensity_law", "count"}, {"sensor_pose", "2,0,0,0,0,0,1"}});
  recordWith(folder / "nothing.mcap", seconds(9), {});
  const std::string remedy = ": tell them apart with --prefix, such as --prefix a,b";
  expectRefusals(
      2,
      {{"merge a.mcap law.mcap -o y.mcap",
        "the stream /sensor_0 has another intensity_law in 'law.mcap' (quadratic) than "
        "in 'a.mcap' (count)" +
            remedy},
       {"merge a.mcap pose.mcap -o y.mcap",
        "the stream /sensor_0 has another sensor_pose in 'pose.mcap' (2,0,0,0,0,0,1) "
        "than in 'a.mcap' (0,0,0,0,0,0,1)" +
            remedy},
       {"merge nothing.mcap a.mcap -o y.mcap",
        "than in 'nothing.mcap' (not told)" + remedy},
       {"merge a.mcap law.mcap -o y.pcxi",
        ": name x.mcap as the output and tell them apart with --prefix"}});
  expectRun("merge a.mcap law.mcap -o y.mcap --prefix a,b");
  recording::RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "y.mcap").ok());
  ASSERT_EQ(reader.streams().size(), 2u);
  EXPECT_EQ(reader.streams()[1].metadata.at("intensity_law"), "quadratic");
  // What says nothing of the clouds may differ.
  recordWith(folder / "c.mcap", seconds(0), {{"recorded_by", "robot 1"}});
  recordWith(folder / "d.mcap", seconds(9), {{"recorded_by", "robot 2"}});
  expectRun("merge c.mcap d.mcap -o cd.mcap");
  EXPECT_EQ(decode(folder / "cd.mcap")[0].frames.size(), 6u);
}

TEST_F(ProgramMerge, FramesThatTwoPartsHaveAreCopiedOnce)
{
  recordTwoStreams(folder / "x.mcap");
  const std::vector<DecodedStream> all = decode(folder / "x.mcap");
  // The second part begins with an I-frame that the first one has, too.
  expectRun("cut x.mcap -o a.mcap --frames :15 -q");
  expectRun("cut x.mcap -o b.mcap --frames 15: -q");
  const ProgramRun merged = run("merge b.mcap a.mcap -o ab.mcap");
  EXPECT_EQ(merged.status, 0) << merged.errors;
  const std::string common = "pcl_ext merge: 'a.mcap' and 'b.mcap' have ";
  EXPECT_EQ(merged.errors,
            common + "5 frames of /sensor_0 in common, copied once\n" + common +
                "1 frame of /sensor_1 in common, copied once\n");
  const std::vector<DecodedStream> joined = decode(folder / "ab.mcap");
  ASSERT_EQ(joined.size(), 2u);
  for (const DecodedStream& stream : joined) {
    const DecodedStream& original = all[stream.name == all[0].name ? 0 : 1];
    EXPECT_EQ(stream.frames.size(), original.frames.size());
    expectSameFrames(original, 0, stream);
  }
  // A part that is within another one, files of frames, and frames of one time.
  expectRun("merge a.mcap x.mcap -o ax.mcap -q");
  EXPECT_EQ(decode(folder / "ax.mcap")[0].frames.size(), 40u);
  expectRun("cut x.mcap --streams /sensor_0 -o c.pcxi --frames :15 -q");
  expectRun("cut x.mcap --streams /sensor_0 -o d.pcxi --frames 15: -q");
  expectRun("merge c.pcxi d.pcxi -o cd.pcxi -q");
  EXPECT_EQ(decode(folder / "cd.pcxi")[0].frames.size(), 40u);
  expectSameFrames(all[0], 0, decode(folder / "cd.pcxi")[0]);
  KnownStream stream = knownStream(0, 40, 10);
  for (auto& frame : stream.frames)
    frame.time = stream.frames[0].time;
  record({stream}, folder / "y.mcap");
  expectRun("cut y.mcap -o e.mcap --frames :15 -q");
  expectRun("cut y.mcap -o f.mcap --frames 15: -q");
  EXPECT_EQ(run("merge e.mcap f.mcap -o ef.mcap -q").status, 0);
  EXPECT_EQ(decode(folder / "ef.mcap")[0].frames.size(), 40u);
}

TEST_F(ProgramMerge, PartsOfOneStreamThatBecomeTwoAreNamed)
{
  recordTwoStreams(folder / "x.mcap");
  expectRun("cut x.mcap -o a.pcxi --streams /sensor_0 --frames :23");
  expectRun("cut x.mcap -o b.pcxi --streams /sensor_0 --frames 23:");
  expectRun("cut x.mcap -o c.pcxi --streams /sensor_1 --frames :23");
  const ProgramRun result = run("merge b.pcxi c.pcxi a.pcxi -o abc.mcap");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors,
            "pcl_ext merge: 'a.pcxi' ends with frames that 'b.pcxi' begins with, and "
            "both become streams: name x.pcxi as the output to join them\n");
  EXPECT_EQ(decode(folder / "abc.mcap").size(), 3u);
}

TEST_F(ProgramMerge, FramesWithoutTimesThatMayBeOthersAreCopied)
{
  writeClouds("room", roomClouds(4));
  const auto cloud = roomClouds(1)[0];
  writeClouds("still", {cloud, cloud, cloud});
  for (const auto& [scene, frames] : {std::pair<std::string, std::size_t>{"still", 3},
                                      {"still --i-frame-rate 1", 3},
                                      {"room --i-frame-rate 1", 4}}) {
    expectRun("encode " + scene + " -o a.pcxi --no-header --overwrite");
    expectRun("encode " + scene + " -o b.pcxi --no-header --overwrite");
    for (const std::string second : {"a.pcxi", "b.pcxi"}) {
      const ProgramRun merged =
          run("merge a.pcxi " + second + " -o ab.pcxi --overwrite");
      EXPECT_EQ(merged.status, 0);
      EXPECT_EQ(merged.errors,
                "pcl_ext merge: 'a.pcxi' and '" + second + "' begin with the same " +
                    std::to_string(frames) +
                    " frames of /stream, which have no times to tell whether they are "
                    "the same ones: all are copied\n");
      EXPECT_EQ(decode(folder / "ab.pcxi")[0].frames.size(), 2 * frames);
    }
  }
}

} // namespace pcl_ext::tools::test
