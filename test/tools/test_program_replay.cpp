// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/link/frame_subscriber.h>
#include <pcl_ext/recording/recording_reader.h>

#include "stream/frame_encoder.h"
#include "support/world_voxels.h"
#include "tools/site_program.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext::tools::test {

using pcl_ext::test::worldVoxels;
using recording::Time;

namespace {

/** \brief An I-frame of about half a megabyte in few voxels, which have much noise. */
Bytes
largeFrame()
{
  std::mt19937_64 random(1);
  io::VoxelFrame voxels;
  voxels.grid.resolution = 0.05;
  voxels.grid.depth = 7;
  voxels.intensity_scale.bits = 16;
  for (std::uint64_t key = 0; key < (1u << 21); key += 1 + random() % 14) {
    voxels.keys.push_back(key);
    voxels.intensities.push_back(static_cast<std::uint16_t>(random()));
  }
  io::FrameEncoder encoder(io::StreamFormat::Version1, 1, io::Effort::Fast);
  Bytes bytes;
  EXPECT_TRUE(encoder.encode(voxels, std::nullopt, bytes).ok());
  EXPECT_GT(bytes.size(), 500'000u);
  return bytes;
}

/** \brief Publishes frames, 20 for each second of their times, and waits until the server
 * keeps them. */
void
keep(const NatsServer& server, std::size_t count)
{
  const link::LinkSettings settings = SitePublisher::settingsOf(server);
  link::KeptFrames kept;
  ASSERT_TRUE(link::keepFrames(settings, {}, kept).ok());
  SitePublisher publisher(server);
  const Bytes frame = largeFrame();
  for (std::size_t i = 0; i < count; ++i)
    publisher.publish(view::test::timeOfFrame(i), frame);
  EXPECT_TRUE(view::test::waitFor([&] {
    EXPECT_TRUE(link::keepFrames(settings, {}, kept).ok());
    return kept.messages == count;
  }));
  EXPECT_GT(kept.bytes, 66'000'000u);
}

} // namespace

using ProgramReplay = ProgramTest;

TEST_F(ProgramReplay, HasNoLimitAndEndsAtOnceWhenItIsTold)
{
  const NatsServer server("jetstream { store_dir: \"FOLDER\" }");
  constexpr std::size_t count = 132;
  keep(server, count);
  const ProgramRun all = expectRun("receive -q --replay all -o all.mcap --merge all "
                                   "--map all.ot" +
                                   at(server));
  EXPECT_TRUE(hasPart(all.output, "site cell: 132 frames of 1 stream"));
  EXPECT_TRUE(hasPart(all.output, "all.mcap: 132 frames"));
  // One for each second of the recorded 6.6.
  EXPECT_TRUE(hasPart(all.output, "nodes written to all.ot, after 7 updates\n"));
  BackgroundProgram told(folder,
                         "told",
                         "receive --replay all --map told.ot --remove-outliers" +
                             at(server));
  told.waitForError("voxels have the edge of those of");
  EXPECT_EQ(told.end(SIGTERM), 130) << told.errors();
  EXPECT_TRUE(hasPart(told.output(), "kept frames not replayed"));
}

TEST_F(ProgramReplay, MergesAStreamOfAnotherClockAsItArrived)
{
  const NatsServer server("jetstream { store_dir: \"FOLDER\" }");
  link::KeptFrames kept;
  ASSERT_TRUE(link::keepFrames(SitePublisher::settingsOf(server), {}, kept).ok());
  constexpr std::size_t count = 30;
  const KnownStream stream = knownStream(0, count, 1);
  const KnownStream other = knownStream(1, count, 1);
  SitePublisher sensor(server, "/sensor");
  SitePublisher behind(server, "/behind"); // by 10 s, and ends earlier
  constexpr Time begin = std::chrono::seconds(100);
  constexpr Time apart = std::chrono::seconds(10);
  constexpr std::size_t last = 20;
  for (std::size_t i = 0; i < count; ++i) {
    const Time time = begin + std::chrono::milliseconds(100 * i);
    if (i <= last)
      behind.publish(time - apart, other.frames[i].bytes);
    sensor.publish(time, stream.frames[i].bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  Receiving merged(folder, "merged", at(server, "cell-merged") + "-o merged.mcap");
  const ProgramRun replay =
      run("receive -q --replay all --merge all --merge-age 500ms" + at(server));
  EXPECT_EQ(replay.status, 0);
  EXPECT_TRUE(hasPart(replay.errors, "/behind: missing in ")); // since it ended
  EXPECT_EQ(merged.end(SIGINT), 0) << merged.errors();
  const DecodedStream all = decode(folder / "merged.mcap").at(0);
  ASSERT_EQ(all.frames.size(), 1 + count);
  EXPECT_EQ(all.frames[0].time, begin - apart); // before any other one was known
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(all.frames[1 + i].time, begin + std::chrono::milliseconds(100 * i));
    // Until it was too old; those in between depend on when the server got them.
    if (i > last && i < count - 3)
      continue;
    auto expected = worldVoxels(stream.frames[i].voxels);
    if (i <= last)
      for (const auto& [index, intensity] : worldVoxels(other.frames[i].voxels))
        expected[index] += intensity;
    EXPECT_EQ(worldVoxels(all.voxels[1 + i]), expected) << i;
  }
}

TEST_F(ProgramReplay, MergesAllThatIsThereAtTheEndAlsoLive)
{
  const NatsServer server("jetstream { store_dir: \"FOLDER\" }");
  link::KeptFrames kept;
  ASSERT_TRUE(link::keepFrames(SitePublisher::settingsOf(server), {}, kept).ok());
  const std::vector<std::string> options = {"--merge-period 1h", "--merge-wait 30s"};
  const auto centre = [](const std::string& number) {
    return "--merge all --map map" + number + ".ot ";
  };
  std::vector<std::unique_ptr<Receiving>> centres;
  for (std::size_t i = 0; i < options.size(); ++i) {
    const std::string number = std::to_string(i);
    centres.push_back(std::make_unique<Receiving>(
        folder, "live" + number, at(server) + centre(number) + options[i]));
  }
  constexpr std::size_t count = 10;
  constexpr Time begin = std::chrono::seconds(100);
  constexpr Time period = std::chrono::milliseconds(100);
  const KnownStream stream = knownStream(0, count, 1);
  const KnownStream other = knownStream(1, count, 1);
  SitePublisher sensor(server, "/sensor");
  SitePublisher ended(server, "/ended");
  for (std::size_t i = 0; i < count; ++i) {
    if (i < count / 2)
      ended.publish(Time(begin + i * period), other.frames[i].bytes);
    sensor.publish(Time(begin + i * period), stream.frames[i].bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  for (std::size_t i = 0; i < options.size(); ++i) {
    EXPECT_EQ(centres[i]->end(SIGINT), 0) << centres[i]->errors();
    const std::string number = std::to_string(2 + i);
    const ProgramRun replay = expectRun("receive -q --replay all " + centre(number) +
                                        options[i] + at(server));
    for (const std::string& output : {centres[i]->output(), replay.output})
      EXPECT_TRUE(
          hasPart(output, i == 0 ? "; 1 merged frame\n" : "; 10 merged frames\n"));
  }
}

TEST_F(ProgramReplay, HasTheMetadataOfASenderThatBeganAnew)
{
  const NatsServer server("jetstream { store_dir: \"FOLDER\" }");
  link::KeptFrames kept;
  ASSERT_TRUE(link::keepFrames(SitePublisher::settingsOf(server), {}, kept).ok());
  constexpr std::size_t count = 20; // of each sender
  const KnownStream known = knownStream(0, 1, 1);
  const std::string first_pose = "0,0,0,0,0,0,1";
  const std::string second_pose = "0.5,1,1.5,0,0,0,1";
  const auto send =
      [&](const std::string& stream, const std::string& pose, std::size_t first) {
        SitePublisher sender(server, stream, {{"sensor_pose", pose}});
        for (std::size_t i = first; i < first + count; ++i)
          sender.publish(std::chrono::milliseconds(100 * i), known.frames[0].bytes);
      };
  send("/stays", first_pose, 0);
  send("/stays", first_pose, count);
  send("/moves", first_pose, 0);
  send("/moves", second_pose, count);

  const auto nodes_of_map = [&](const std::string& stream) {
    const ProgramRun replay =
        expectRun("receive -q --replay all --map map.ot --overwrite"
                  " --streams " +
                  stream + at(server));
    return std::stoul(replay.output);
  };
  // Rays from a further place are through further voxels.
  EXPECT_GT(nodes_of_map("/moves"), nodes_of_map("/stays"));

  const std::string streams = " --streams /moves" + at(server);
  const ProgramRun one = run("receive -q --replay all -o one.mcap" + streams);
  EXPECT_EQ(one.status, 1);
  EXPECT_TRUE(hasPart(one.errors,
                      "/moves: its sender began anew with other metadata, as where its "
                      "sensor was moved: one.mcap keeps the first ones"));
  EXPECT_EQ(decode(folder / "one.mcap").at(0).frames.size(), 2 * count);
  expectRun("receive -q --replay all -o part.mcap --rotate-every 1h" + streams);
  std::map<std::string, std::size_t> frames; // by the pose of their file
  for (const auto& entry : std::filesystem::directory_iterator(folder / "")) {
    const std::string path = entry.path().string();
    if (entry.path().filename().string().rfind("part_", 0) != 0)
      continue;
    recording::RecordingReader reader;
    ASSERT_TRUE(reader.open(path).ok());
    frames[reader.streams().at(0).metadata.at("sensor_pose")] +=
        decode(path).at(0).frames.size();
  }
  EXPECT_EQ(
      frames,
      (std::map<std::string, std::size_t>{{first_pose, count}, {second_pose, count}}));
}

} // namespace pcl_ext::tools::test
