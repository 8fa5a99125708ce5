// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <system_error>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

namespace {

std::uintmax_t
sizeOf(const fs::path& path)
{
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    const std::uintmax_t size = fs::file_size(path, error);
    return error ? 0 : size;
  }
  std::uintmax_t sum = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    const std::uintmax_t size = entry.file_size(error);
    sum += error ? 0 : size;
  }
  return sum;
}

class ProgramInterruption : public ProgramTest {
protected:
  /** \brief Runs the program and interrupts it as soon as a part of its output is there
   * that has more bytes than the header and the descriptions of all streams, so that it
   * holds frames. */
  ProgramRun
  interrupted(const std::string& arguments, int signal, const fs::path& output) const
  {
    const fs::path number = folder / "process";
    fs::remove(number);
    auto run = std::async(std::launch::async, [&] {
      return runShell("\"$P\" " + arguments + " & echo $! > process; wait $!");
    });
    constexpr std::uintmax_t headers = std::uintmax_t{1} << 16;
    pid_t process = 0;
    // Not by a shell's loop, as the programs that it starts take longer than this one.
    while ((sizeOf(output) <= headers || !(std::ifstream(number) >> process)) &&
           run.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready)
      ;
    if (process != 0)
      ::kill(process, signal);
    return run.get();
  }
};

} // namespace

TEST_F(ProgramInterruption, LeavesARecordingThatIsComplete)
{
  // More bytes than a pipe holds, so that the program waits for its reader.
  writeClouds("room", roomClouds(60));
  const ProgramRun result = runShell(
      "mkfifo pipe; \"$P\" encode room -o - -r 0.01 --i-frame-rate 1 > pipe & "
      "exec 3< pipe; head -c 4096 <&3 > x.pcxi; kill -INT $!; cat <&3 >> x.pcxi; "
      "wait $!");
  EXPECT_EQ(result.status, 130) << result.errors;
  const std::vector<DecodedStream> streams = decode(folder / "x.pcxi");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_GT(streams[0].frames.size(), 0u);
  EXPECT_LT(streams[0].frames.size(), 60u);
}

TEST_F(ProgramInterruption, KeepsAnEarlierOutput)
{
  writeClouds("room", roomClouds(2));
  expectRun("encode room -o x.mcap -r 0.1");
  expectRun("decode x.mcap -o out");
  expectRun("decode x.mcap -o bag.mcap");
  std::vector<KnownStream> streams = {knownStream(0, 20000, 1000)};
  record(streams, folder / "long.mcap");
  fs::create_directories(folder / "many");
  for (int i = 0; i < 20000; ++i)
    fs::create_symlink("../room/000.pcd",
                       folder / ("many/" + std::to_string(i) + ".pcd"));
  // So many frames that it does not end before the signal.
  std::string merge = "merge";
  std::string prefixes = " --prefix 0";
  for (int i = 0; i < 20; ++i) {
    merge += " long.mcap";
    prefixes += i == 0 ? "" : "," + std::to_string(i);
  }
  merge += prefixes;
  expectRun(merge + " -o longer.mcap -q");
  const std::vector<std::string> commands = {"encode many -o x.mcap -r 0.1",
                                             merge + " -o x.mcap",
                                             "cut longer.mcap -o x.mcap",
                                             "decode long.mcap -o bag.mcap",
                                             "decode long.mcap -o out"};
  int signal = SIGTERM; // each in turn
  for (const std::string& command : commands) {
    SCOPED_TRACE(command);
    signal = signal == SIGTERM ? SIGINT : SIGTERM;
    const std::string name = command.find("bag") != std::string::npos   ? "bag.mcap"
                             : command.find("out") != std::string::npos ? "out"
                                                                        : "x.mcap";
    const std::string file = folder / (name == "out" ? "out/000000.pcd" : name);
    const Bytes earlier = bytesOf(file);
    const ProgramRun result =
        interrupted(command + " --overwrite", signal, folder / (name + ".unfinished"));
    EXPECT_EQ(result.status, 130) << result.errors;
    EXPECT_TRUE(hasPart(result.output, "still the earlier"));
    EXPECT_EQ(bytesOf(file), earlier);
    EXPECT_TRUE(fs::exists(folder / (name + ".unfinished")));
    fs::remove_all(folder / (name + ".unfinished"));
  }
}

TEST_F(ProgramInterruption, OfTheDemoIsToldOnce)
{
  const ProgramRun result =
      interrupted("demo --sensors 1 -n 100000 -o demo", SIGINT, folder / "demo");
  EXPECT_EQ(result.status, 130) << result.errors;
  const std::string ending = "; interrupted, and complete up to there";
  EXPECT_TRUE(hasPart(result.errors, "cell.mcap" + ending));
  EXPECT_FALSE(hasPart(result.errors, ending + ending));
}

} // namespace pcl_ext::tools::test
