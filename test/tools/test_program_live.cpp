// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_reader.h"
#include "recording/mcap_writer.h"
#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <set>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

namespace {

/** \brief Makes bag.mcap with so many clouds of each topic.
 * \param[in] is_divided each has a chunk of its own; else all have one
 * \return size of the file after each chunk that is complete */
std::vector<std::uintmax_t>
makeBag(const TestFolder& folder,
        std::size_t clouds,
        const std::vector<std::string>& topics = {"/room"},
        bool is_divided = false)
{
  recording::McapWriter writer;
  EXPECT_TRUE(writer.open(folder / "bag.mcap", "ros2").ok());
  const auto room = roomClouds(clouds);
  std::vector<std::uintmax_t> sizes;
  for (const std::string& topic : topics) {
    std::size_t channel = 0;
    EXPECT_TRUE(writer
                    .addChannel(recording::pointCloudChannel(topic),
                                recording::McapChunking::Shared,
                                channel)
                    .ok());
    for (std::size_t i = 0; i < clouds; ++i) {
      recording::McapMessage message = cloudMessage(room[i], i);
      message.channel = channel;
      message.log_time = stampOf(i);
      EXPECT_TRUE(writer.write(message).ok());
      if (!is_divided)
        continue;
      EXPECT_TRUE(writer.flush().ok());
      sizes.push_back(fs::file_size(folder / "bag.mcap.unfinished"));
    }
  }
  EXPECT_TRUE(writer.write(recording::McapMetadata{"name", {{"a", "b"}}}).ok());
  EXPECT_TRUE(writer.finish().ok());
  return sizes;
}

} // namespace

using ProgramLive = ProgramTest;

TEST_F(ProgramLive, ABagThatComesThroughAPipeIsEncodedAsItComes)
{
  const std::vector<std::uintmax_t> sizes = makeBag(folder, 6, {"/room"}, true);
  expectRun("encode bag.mcap -o whole.pcxi");
  for (const std::string extension : {"pcxi", "mcap"}) {
    // The rest of the bag waits for the first frames, at most a minute.
    const std::string first = std::to_string(sizes[1]);
    const std::string rest = std::to_string(sizes[1] + 1);
    const std::string output = "x." + extension;
    const ProgramRun result = runShell(
        "mkfifo pipe; \"$P\" encode pipe -o " + output + " & exec 3> pipe; head -c " +
        first + " bag.mcap >&3; for i in $(seq 600); do \"$P\" info " + output +
        ".unfinished --json 2> none | grep -q 'frames\": [1-9]' && touch early." +
        extension + " && break; sleep 0.1; done; tail -c +" + rest +
        " bag.mcap >&3; exec 3>&-; wait $!; status=$?; rm pipe; exit $status");
    EXPECT_EQ(result.status, 0) << result.errors;
    EXPECT_TRUE(fs::exists(folder / ("early." + extension)));
    EXPECT_EQ(decode(folder / output)[0].frames.size(), 6u);
  }
  EXPECT_EQ(bytesOf(folder / "x.pcxi"), bytesOf(folder / "whole.pcxi"));
  expectSameFrames(decode(folder / "whole.pcxi")[0], 0, decode(folder / "x.mcap")[0]);
  recording::BagReader reader;
  ASSERT_TRUE(reader.open(folder / "x.mcap").ok());
  std::vector<recording::McapMetadata> metadata;
  EXPECT_TRUE(reader.readMetadata(metadata).ok());
  ASSERT_EQ(metadata.size(), 1u);
  EXPECT_EQ(metadata[0].values.at("a"), "b");
  // It may end anywhere.
  const ProgramRun cut =
      runShell("head -c " + std::to_string(sizes[3] + 50) +
               " bag.mcap | \"$P\" encode - -o cut.pcxi --topics /room");
  EXPECT_EQ(cut.status, 1);
  EXPECT_TRUE(hasPart(cut.errors, "the file ends within a record"));
  EXPECT_EQ(decode(folder / "cut.pcxi")[0].frames.size(), 4u);
}

TEST_F(ProgramLive, FramesThatComeTogetherShareAChunk)
{
  makeBag(folder, 6);
  ASSERT_EQ(runShell("cat bag.mcap | \"$P\" encode - -o x.mcap").status, 0);
  recording::BagReader reader;
  ASSERT_TRUE(reader.open(folder / "x.mcap").ok());
  ASSERT_EQ(reader.index().size(), 6u);
  std::set<std::uint64_t> chunks;
  for (const recording::BagEntry& entry : reader.index())
    chunks.insert(reader.fileOffset(entry));
  EXPECT_EQ(chunks.size(), 1u);
}

TEST_F(ProgramLive, ItEndsBehindTheFramesThatAreWanted)
{
  makeBag(folder, 5);
  // The pipe stays open; timeout would end the program.
  const ProgramRun result =
      runShell("mkfifo pipe; timeout 60 $P encode pipe -o x.mcap --frames 1:3 & "
               "exec 3> pipe; cat bag.mcap >&3; wait $!");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(decode(folder / "x.mcap")[0].frames.size(), 2u);
}

TEST_F(ProgramLive, ASocketIsReadAsItComes)
{
  makeBag(folder, 3);
  const Bytes bag = bytesOf(folder / "bag.mcap");
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  const std::string output = folder / "x.pcxi";
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDIN_FILENO);
    ::close(ends[0]);
    ::close(ends[1]);
    // If it waits for the end of the socket, this ends it.
    ::alarm(60);
    ::execl(testedProgram().c_str(),
            "pcl_ext",
            "encode",
            "-",
            "-q",
            "-o",
            output.c_str(),
            "--frames",
            "0:2",
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(ends[1]);
  for (std::size_t at = 0; at < bag.size();) {
    const ssize_t count = ::send(ends[0], &bag[at], bag.size() - at, MSG_NOSIGNAL);
    if (count <= 0)
      break; // It has what it wants.
    at += static_cast<std::size_t>(count);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ::close(ends[0]);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(decode(output)[0].frames.size(), 2u);
}

TEST_F(ProgramLive, AStreamThatTheOutputDoesNotTakeIsLeftOut)
{
  makeBag(folder, 3, {"/front", "/rear"}, true);
  const ProgramRun result = runShell("cat bag.mcap | \"$P\" encode - -o x.pcxi");
  ASSERT_EQ(result.status, 1) << result.errors;
  EXPECT_TRUE(hasPart(result.errors,
                      "/rear: its clouds are left out: 'x.pcxi' takes one stream"));
  EXPECT_TRUE(hasPart(result.output, "3 failed"));
  EXPECT_EQ(decode(folder / "x.pcxi")[0].frames.size(), 3u);
  EXPECT_FALSE(fs::exists(folder / "x.pcxi.unfinished"));
}

TEST_F(ProgramLive, AFileThatAppearsMeanwhileIsNotReplaced)
{
  makeBag(folder, 2);
  for (const std::string output : {"x.pcxi", "x.mcap"}) {
    const ProgramRun result = runShell(
        "mkfifo pipe; \"$P\" encode pipe -o " + output +
        " & exec 3> pipe; head -c -50 bag.mcap >&3; for i in $(seq 600); do [ "
        "-e " +
        output + ".unfinished ] && break; sleep 0.1; done; echo earlier > " + output +
        "; tail -c 50 bag.mcap >&3; exec 3>&-; wait $!; status=$?; rm pipe; "
        "exit "
        "$status");
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(hasPart(result.errors,
                        "File exists; what was written until then is in '" + output +
                            ".unfinished'"));
    EXPECT_EQ(textOf(folder / output), "earlier\n");
    expectRun("verify " + output + ".unfinished");
  }
}

} // namespace pcl_ext::tools::test
