#include "tools/program.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

namespace pcl_ext {
namespace tools {
namespace test {

namespace fs = std::filesystem;

TEST(ProgramPipe, EncodeAndDecodeInAPipe)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(3));
  const ProgramRun result =
      runShell(folder,
               "cat room/000.pcd | \"$P\" encode - -o - -q | \"$P\" "
               "decode - -o out -q && \"$P\" encode room -o - -q | "
               "\"$P\" cut - -o part.pcxi --frames 0:2");
  EXPECT_EQ(result.status, 0) << result.errors;
  expectFailure(folder,
                "info - < room/000.pcd",
                1,
                "pcl_ext info: 'standard input' is not a recording: ");
  expectRun(folder, "encode room/000.pcd -o one.pcxi");
  expectVoxels(decode(folder / "one.pcxi")[0].voxels[0],
               readCloud(folder / "out/000000.pcd"));
  expectRun(folder, "encode room -o all.pcxi");
  EXPECT_EQ(decode(folder / "part.pcxi")[0].frames.size(), 2u);
  expectSameFrames(decode(folder / "all.pcxi")[0], 0, decode(folder / "part.pcxi")[0]);
}

TEST(ProgramInfo, JsonHasTheFiguresOfTheStreams)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = recordTwoStreams(folder / "x.mcap");
  const ProgramRun result = expectRun(folder, "info x.mcap --json");
  const nlohmann::json json = nlohmann::json::parse(result.output);
  EXPECT_EQ(json["frames"], 71);
  EXPECT_EQ(json["file_bytes"], fs::file_size(folder / "x.mcap"));
  EXPECT_EQ(json["is_unfinished"], false);
  EXPECT_EQ(json["duration_s"], 1.95);
  ASSERT_EQ(json["streams"].size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& stream = json["streams"][i];
    std::size_t bytes = 0;
    std::size_t voxels = 0;
    for (const auto& frame : streams[i].frames) {
      bytes += frame.bytes.size();
      voxels += frame.voxels.size();
    }
    const double frames = static_cast<double>(streams[i].frames.size());
    EXPECT_EQ(stream["name"], streams[i].name);
    EXPECT_EQ(stream["frames"], streams[i].frames.size());
    EXPECT_EQ(stream["i_frames"], i == 0 ? 4 : 5);
    EXPECT_EQ(stream["missing_frames"], 0);
    EXPECT_EQ(stream["bytes"], bytes);
    EXPECT_DOUBLE_EQ(stream["mean_frame_voxels"], static_cast<double>(voxels) / frames);
    EXPECT_DOUBLE_EQ(stream["bytes_per_voxel"],
                     static_cast<double>(bytes) / static_cast<double>(voxels));
    EXPECT_DOUBLE_EQ(stream["rate_hz"], 20.0);
    EXPECT_DOUBLE_EQ(stream["resolution_m"],
                     streams[i].frames[0].voxels.grid.resolution);
    EXPECT_EQ(stream["effort"], "balanced");
    EXPECT_EQ(stream["frame_id"], "world");
  }
  const ProgramRun table = expectRun(folder, "info x.mcap");
  EXPECT_NE(table.output.find("| /sensor_1 | 31     | 5        | 0    | 20.0    |"),
            std::string::npos)
      << table.output;
}

TEST(ProgramVerify, EachLossHasALine)
{
  const TestFolder folder;
  const KnownStream stream = knownStream(0, 20, 5);
  record({stream}, folder / "good.pcxi");
  const ProgramRun good = expectRun(folder, "verify good.pcxi");
  EXPECT_EQ(good.output, "20 frames decoded, 0 lost\n");
  // Without frame 7 the next two cannot be decoded; frame 13 has a wrong bit.
  Bytes bytes;
  std::size_t at_8 = 0;
  std::size_t at_13 = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    if (i == 7)
      continue;
    at_8 = i == 8 ? bytes.size() : at_8;
    at_13 = i == 13 ? bytes.size() : at_13;
    bytes.insert(
        bytes.end(), stream.frames[i].bytes.begin(), stream.frames[i].bytes.end());
  }
  bytes[at_13 + stream.frames[13].bytes.size() - 6] ^= 1;
  writeBytes(folder / "bad.pcxi", bytes);
  const ProgramRun bad = run(folder, "verify bad.pcxi");
  EXPECT_EQ(bad.status, 1);
  const std::string& text = bad.output;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << text;
  const auto expectLine = [&text](const std::string& line) {
    EXPECT_NE(text.find(line), std::string::npos) << line << '\n' << text;
  };
  expectLine("frame 7 at byte " + std::to_string(at_8) +
             ": 1 frame before it is not in the recording");
  expectLine("frame 7 at byte " + std::to_string(at_8) +
             ": it needs a frame before it");
  // Frames are counted in one way, also where the decoder tells their own numbers.
  expectLine("frame 12 at byte " + std::to_string(at_13) +
             ": corrupt frame: checksum mismatch: ");
  expectLine("bad, frames 8 to 13: 2 more failures like that of frame 7");
  expectLine("15 frames decoded, 5 lost");
  const ProgramRun info = expectRun(folder, "info bad.pcxi --json");
  EXPECT_EQ(nlohmann::json::parse(info.output)["streams"][0]["missing_frames"], 1);
}

TEST(ProgramVerify, FileThatWasCutOffIsReadUpToThere)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  Bytes bytes = bytesOf(folder / "x.mcap");
  bytes.resize(bytes.size() * 2 / 3);
  writeBytes(folder / "cut.mcap", bytes);
  const ProgramRun result = run(folder, "verify cut.mcap");
  EXPECT_NE(result.output.find("was not finished"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(" 0 lost"), std::string::npos) << result.output;
  const ProgramRun info = run(folder, "info cut.mcap");
  EXPECT_EQ(info.status, 0);
  EXPECT_NE(info.output.find("unfinished"), std::string::npos) << info.output;
}

TEST(ProgramCut, BeginsAtAnIFrameAndKeepsTheBytes)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  const std::vector<DecodedStream> all = decode(folder / "x.mcap");
  const ProgramRun result =
      run(folder, "cut --streams /sensor_0 x.mcap -o part.pcxi --frames 23:27 -q");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.errors, "");
  EXPECT_EQ(result.output,
            "part.pcxi: 7 frames of 1 stream, 3 frames of these before the first ones "
            "asked for, from I-frames on, without which those cannot be decoded\n");
  const std::vector<DecodedStream> part = decode(folder / "part.pcxi");
  ASSERT_EQ(part.size(), 1u);
  EXPECT_EQ(part[0].frames.size(), 7u);
  expectSameFrames(all[0], 20, part[0]);
  expectFailure(folder, "cut x.mcap -o y.pcxi", 2, "choose one with --streams");
  expectFailure(folder, "cut x.mcap -o y.mcap --from 9", 2, "takes 1.950 s");
  expectFailure(folder, "cut x.mcap -o y.mcap --streams /a", 2, "there is no '/a'");
  expectFailure(folder, "cut x.mcap -o x.mcap", 2, "is an input");
}

TEST(ProgramCut, FramesStayInOrderIfTheClockWasSetBack)
{
  const TestFolder folder;
  std::vector<KnownStream> streams = {knownStream(0, 20, 10)};
  for (std::size_t i = 13; i < 20; ++i)
    streams[0].frames[i].time -= std::chrono::milliseconds(350);
  record(streams, folder / "x.mcap");
  expectRun(folder, "cut x.mcap -o part.mcap --frames 10:20");
  const std::vector<DecodedStream> part = decode(folder / "part.mcap");
  ASSERT_EQ(part.size(), 1u);
  ASSERT_EQ(part[0].frames.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(part[0].frames[i].bytes, streams[0].frames[10 + i].bytes) << i;
    EXPECT_EQ(part[0].frames[i].time, streams[0].frames[10 + i].time) << i;
  }
}

TEST(ProgramMerge, PartsBecomeOneStreamAgain)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  expectRun(folder, "cut x.mcap -o a.mcap --to 0.999");
  expectRun(folder, "cut x.mcap -o b.mcap --streams /sensor_0 --from 1");
  expectRun(folder, "cut x.mcap -o c.pcxi --streams /sensor_1 --frames 21:");
  expectRun(folder, "merge b.mcap a.mcap -o ab.mcap");
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
  expectRun(folder, "cut x.mcap -o d.pcxi --streams /sensor_1 --frames :21");
  expectRun(folder, "merge d.pcxi c.pcxi -o dc.pcxi");
  const std::vector<DecodedStream> of_files = decode(folder / "dc.pcxi");
  EXPECT_EQ(of_files[0].frames.size(), 31u);
  expectSameFrames(all[1], 0, of_files[0]);
}

TEST(ProgramMerge, StreamsOfOneNameAtTheSameTimeAreToldApartByPrefixes)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  KnownStream other = knownStream(3, 20, 5);
  other.name = "/sensor_0";
  record({other}, folder / "z.mcap");
  expectFailure(
      folder,
      "merge x.mcap z.mcap -o y.mcap",
      2,
      "the stream /sensor_0 has other frames of the same time in 'x.mcap' and "
      "in 'z.mcap'");
  expectFailure(
      folder, "merge x.mcap x.mcap -o y.mcap --prefix a", 2, "--prefix needs");
  expectRun(folder, "cut x.mcap -o one.mcap --streams /sensor_0");
  expectFailure(folder,
                "merge one.mcap z.mcap -o y.pcxi",
                2,
                "'y.pcxi' has one stream, and there are other frames of the same time");
  expectRun(folder, "merge x.mcap x.mcap -o y.mcap --prefix left,right");
  const std::vector<DecodedStream> streams = decode(folder / "y.mcap");
  ASSERT_EQ(streams.size(), 4u);
  EXPECT_EQ(streams[0].name, "/left/sensor_0");
  EXPECT_EQ(streams[3].name, "/right/sensor_1");
  expectSameFrames(decode(folder / "x.mcap")[1], 0, streams[3]);
}

TEST(ProgramMerge, FramesThatTwoPartsHaveAreCopiedOnce)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  const std::vector<DecodedStream> all = decode(folder / "x.mcap");
  // The second part begins with an I-frame that the first one has, too.
  expectRun(folder, "cut x.mcap -o a.mcap --frames :15 -q");
  expectRun(folder, "cut x.mcap -o b.mcap --frames 15: -q");
  const ProgramRun merged = run(folder, "merge b.mcap a.mcap -o ab.mcap");
  EXPECT_EQ(merged.status, 0) << merged.errors;
  EXPECT_EQ(
      merged.errors,
      "pcl_ext merge: 'a.mcap' and 'b.mcap' have 5 frames of /sensor_0 in common, "
      "copied once\n"
      "pcl_ext merge: 'a.mcap' and 'b.mcap' have 1 frame of /sensor_1 in common, "
      "copied once\n");
  const std::vector<DecodedStream> joined = decode(folder / "ab.mcap");
  ASSERT_EQ(joined.size(), 2u);
  for (const DecodedStream& stream : joined) {
    const DecodedStream& original = all[stream.name == all[0].name ? 0 : 1];
    EXPECT_EQ(stream.frames.size(), original.frames.size());
    expectSameFrames(original, 0, stream);
  }
  // A part that is within another one, and files of frames.
  expectRun(folder, "merge a.mcap x.mcap -o ax.mcap -q");
  EXPECT_EQ(decode(folder / "ax.mcap")[0].frames.size(), 40u);
  expectRun(folder, "cut x.mcap --streams /sensor_0 -o c.pcxi --frames :15 -q");
  expectRun(folder, "cut x.mcap --streams /sensor_0 -o d.pcxi --frames 15: -q");
  expectRun(folder, "merge c.pcxi d.pcxi -o cd.pcxi -q");
  const DecodedStream of_files = decode(folder / "cd.pcxi")[0];
  EXPECT_EQ(of_files.frames.size(), 40u);
  expectSameFrames(all[0], 0, of_files);
}

TEST(ProgramVerify, FrameThatCannotBeReadIsCountedOnce)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  Bytes bytes = bytesOf(folder / "x.mcap");
  bytes[bytes.size() / 2] ^= 1; // within a chunk of frames
  writeBytes(folder / "x.mcap", bytes);
  const nlohmann::json json =
      nlohmann::json::parse(run(folder, "info x.mcap --json").output);
  std::size_t frames = 0;
  std::size_t unreadable = 0;
  for (const nlohmann::json& stream : json["streams"]) {
    EXPECT_EQ(stream["missing_frames"], 0);
    frames += stream["frames"].get<std::size_t>();
    unreadable += stream["unreadable_frames"].get<std::size_t>();
  }
  EXPECT_EQ(frames, 71u);
  EXPECT_GT(unreadable, 1u);
  const ProgramRun result = run(folder, "verify x.mcap");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.output.find(std::to_string(frames - unreadable) +
                               " frames decoded, " + std::to_string(unreadable) +
                               " lost"),
            std::string::npos)
      << result.output;
}

TEST(ProgramNames, ControlCharactersAreNotPrinted)
{
  const TestFolder folder;
  const std::string name = "/a\x1b[31m\nb\xc2\x9b\xff\xc3\xa9\xe2\x80\xae";
  const std::string shown = "/a\\x1b[31m\\x0ab\\xc2\\x9b\\xff\xc3\xa9\\xe2\\x80\\xae";
  KnownStream stream = knownStream(0, 10, 5);
  stream.name = name;
  stream.frames.erase(stream.frames.begin() + 7);
  record({stream}, folder / "x.mcap");
  writeBytes(folder / "\x1b[31m.pcd", {});
  for (const char* const arguments : {"info x.mcap",
                                      "verify x.mcap",
                                      "decode x.mcap -o out",
                                      "cut x.mcap --streams y "
                                      "-o y.mcap",
                                      "encode *.pcd -o z.pcxi",
                                      "'\x1b[31m'"}) {
    const ProgramRun result = run(folder, arguments);
    const std::string printed = result.output + result.errors;
    EXPECT_EQ(printed.find('\x1b'), std::string::npos) << arguments;
    EXPECT_EQ(printed.find('\xff'), std::string::npos) << arguments;
    EXPECT_NE(printed.find("\\x1b[31m"), std::string::npos) << arguments << printed;
    const bool has_stream = std::string(arguments).find("x.mcap") != std::string::npos;
    EXPECT_EQ(printed.find(shown) != std::string::npos, has_stream) << printed;
  }
}

TEST(ProgramOutput, LimitOnFileSizesIsAnError)
{
  const TestFolder folder;
  recordTwoStreams(folder / "x.mcap");
  const ProgramRun result =
      runShell(folder, "ulimit -f 1; \"$P\" merge x.mcap -o y.mcap");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.errors.find("File too large"), std::string::npos) << result.errors;
}

TEST(ProgramInterruption, LeavesARecordingThatIsComplete)
{
  const TestFolder folder;
  // More bytes than a pipe holds, so that the program waits for this test.
  writeClouds(folder, "room", roomClouds(60));
  const std::string input = folder / "room";
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::close(ends[1]);
    ::close(STDERR_FILENO);
    ::open("/dev/null", O_WRONLY);
    ::execl(PCL_EXT_PROGRAM,
            "pcl_ext",
            "encode",
            input.c_str(),
            "-o",
            "-",
            "-r",
            "0.01",
            "--i-frame-rate",
            "1",
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  ::close(ends[1]);
  Bytes bytes;
  std::uint8_t part[4096];
  bool is_interrupted = false;
  for (ssize_t count; (count = ::read(ends[0], part, sizeof(part))) > 0;) {
    bytes.insert(bytes.end(), part, part + count);
    if (!is_interrupted)
      ::kill(child, SIGINT);
    is_interrupted = true;
  }
  ::close(ends[0]);
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  writeBytes(folder / "x.pcxi", bytes);
  const std::vector<DecodedStream> streams = decode(folder / "x.pcxi");
  ASSERT_EQ(streams.size(), 1u);
  EXPECT_GT(streams[0].frames.size(), 0u);
  EXPECT_LT(streams[0].frames.size(), 60u);
}

TEST(ProgramInterruption, KeepsAnEarlierOutput)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(2));
  expectRun(folder, "encode room -o x.mcap -r 0.1");
  expectRun(folder, "decode x.mcap -o out");
  expectRun(folder, "decode x.mcap -o bag.mcap");
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
  const std::vector<std::string> commands = {"encode many -o x.mcap -r 0.1",
                                             merge + " -o x.mcap",
                                             "decode long.mcap -o bag.mcap",
                                             "decode long.mcap -o out"};
  for (const std::string signal : {"INT", "TERM"})
    for (const std::string& command : commands) {
      SCOPED_TRACE(command);
      const std::string name = command.find("bag") != std::string::npos   ? "bag.mcap"
                               : command.find("out") != std::string::npos ? "out"
                                                                          : "x.mcap";
      const std::string file = folder / (name == "out" ? "out/000000.pcd" : name);
      const Bytes earlier = bytesOf(file);
      // It is interrupted as soon as there is something of the new output.
      const ProgramRun result = runShell(
          folder,
          "\"$P\" " + command + " --overwrite & while kill -0 $! && [ -z \"$(find " +
              name +
              ".unfinished -type f -size +0 2> none)\" ]; do sleep 0.01; done; "
              "kill -" +
              signal + " $!; wait $!");
      EXPECT_EQ(result.status, 130) << result.errors;
      EXPECT_NE(result.output.find("still the earlier"), std::string::npos)
          << result.output;
      EXPECT_EQ(bytesOf(file), earlier);
      EXPECT_TRUE(fs::exists(folder / (name + ".unfinished")));
      fs::remove_all(folder / (name + ".unfinished"));
    }
}

TEST(ProgramDemo, MakesARecordingAndClouds)
{
  const TestFolder folder;
  const ProgramRun result =
      run(folder,
          "demo --sensors 2 --frames 3 -o out -q && \"$P\" demo --sensors 2 "
          "--frames 2 -o out -q -l quadratic --threshold 30");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_NE(result.output.find("| cell_sensor_2 | count     | 3      |"),
            std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("outlier filter (denoised clouds)"), std::string::npos);
  EXPECT_NE(result.output.find("threshold 30 (denoised clouds)"), std::string::npos);
  EXPECT_NE(result.output.find("pcl_ext info out/cell.mcap"), std::string::npos);
  const std::vector<DecodedStream> streams = decode(folder / "out/cell.mcap");
  ASSERT_EQ(streams.size(), 2u);
  EXPECT_EQ(streams[1].name, "/cell_sensor_2");
  ASSERT_EQ(streams[1].voxels.size(), 2u);
  EXPECT_TRUE(streams[1].voxels[0].depth_model);
  // The clouds of the first run are gone.
  EXPECT_EQ(filesIn(folder / "out/cell_sensor_2/decoded"), 2u);
  EXPECT_EQ(filesIn(folder / "out/cell_sensor_2/denoised"), 2u);
  expectVoxels(streams[1].voxels[1],
               readCloud(folder / "out/cell_sensor_2/decoded/000001.pcd"));
}

TEST(ProgramHelp, FitsAScreenAndTheManPageHasAllOfIt)
{
  const TestFolder folder;
  expectRun(folder, "documentation man pcl_ext.1");
  const Bytes page = bytesOf(folder / "pcl_ext.1");
  const std::string man(page.begin(), page.end());
  for (const std::string command :
       {"encode", "decode", "info", "verify", "cut", "merge", "view", "demo"}) {
    const ProgramRun help = expectRun(folder, command + " --help");
    EXPECT_LE(std::count(help.output.begin(), help.output.end(), '\n'), 45) << command;
    std::size_t longest = 0;
    for (std::size_t begin = 0; begin < help.output.size();) {
      const std::size_t end = help.output.find('\n', begin);
      longest = std::max(longest, end - begin);
      begin = end + 1;
    }
    EXPECT_LE(longest, 100u) << command;
    EXPECT_NE(man.find("\n.SS " + command + "\n"), std::string::npos);
  }
  EXPECT_NE(man.find("\\fB\\-\\-i\\-frame\\-rate\\fR \\fIN\\fR"), std::string::npos);
  EXPECT_EQ(man.find("documentation"), std::string::npos);
}

TEST(ProgramHelp, CompletionKnowsCommandsOptionsAndValues)
{
  const TestFolder folder;
  expectRun(folder, "documentation bash completion");
  writeBytes(folder / "x.mcap", {});
  const auto complete = [&folder](const std::string& words) {
    const ProgramRun result = runShell(folder,
                                       "bash -c '. ./completion; COMP_WORDS=(" + words +
                                           "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); "
                                           "_pcl_ext; echo ${COMPREPLY[*]}'");
    EXPECT_EQ(result.errors, "") << words;
    return result.output;
  };
  EXPECT_EQ(complete("pcl_ext e"), "encode\n");
  EXPECT_EQ(complete("pcl_ext encode --eff"), "--effort\n");
  EXPECT_EQ(complete("pcl_ext encode --effort \"\""), "fast balanced small\n");
  EXPECT_EQ(complete("pcl_ext decode --pcd a"), "ascii\n");
  EXPECT_EQ(complete("pcl_ext decode --from \"\""), "\n");
  EXPECT_EQ(complete("pcl_ext info x.m"), "x.mcap\n");
  EXPECT_EQ(complete("pcl_ext v"), "verify view\n");
  EXPECT_EQ(complete("pcl_ext view --no"), "--no-browser --no-header\n");
}

} // namespace test
} // namespace tools
} // namespace pcl_ext
