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

} // namespace

/** \brief A test with a server that keeps the frames of the site. */
class ProgramReplay : public ProgramTest {
protected:
  ProgramReplay() { keepFrames(); }

  void
  keepFrames()
  {
    EXPECT_TRUE(link::keepFrames(SitePublisher::settingsOf(server), {}, kept).ok());
  }

  const NatsServer server{"jetstream { store_dir: \"FOLDER\" }"};
  link::KeptFrames kept;
};

TEST_F(ProgramReplay, HasNoLimitAndEndsAtOnceWhenItIsTold)
{
  constexpr std::size_t count = 132;
  SitePublisher publisher(server);
  const Bytes frame = largeFrame();
  for (std::size_t i = 0; i < count; ++i)
    publisher.publish(view::test::timeOfFrame(i), frame);
  EXPECT_TRUE(view::test::waitFor([&] {
    keepFrames();
    return kept.messages == count;
  }));
  EXPECT_GT(kept.bytes, 66'000'000u);
  const ProgramRun all = expectRun("receive -q --replay all -o all.mcap --merge all "
                                   "--map all.ot" +
                                   at(server));
  EXPECT_TRUE(hasPart(all.output, "site cell: 132 frames of 1 stream"));
  EXPECT_TRUE(hasPart(all.output, "all.mcap: 132 frames"));
  // One for each second of the recorded 6.6.
  EXPECT_TRUE(hasPart(all.output, "nodes written to all.ot, after 7 updates\n"));
  BackgroundProgram told(
      folder,
      "exec $P receive --replay all --map told.ot --remove-outliers" + at(server));
  told.waitForError("voxels have the edge of those of");
  EXPECT_EQ(told.end(SIGTERM), 130) << told.errors();
  EXPECT_TRUE(hasPart(told.output(), "kept frames not replayed"));
}

TEST_F(ProgramReplay, MergesAStreamOfAnotherClockAsItArrived)
{
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
  Receiving merged(folder, at(server, "cell-merged") + "-o merged.mcap");
  expectRemark("receive -q --replay all --merge all --merge-age 500ms" + at(server),
               "/behind: missing in "); // since it ended
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
  const std::string merge = "--merge all --merge-wait 30s";
  Receiving live(folder, at(server) + merge);
  constexpr std::size_t count = 10;
  const KnownStream stream = knownStream(0, count, 1);
  const KnownStream other = knownStream(1, count, 1);
  SitePublisher sensor(server, "/sensor");
  SitePublisher ended(server, "/ended");
  for (std::size_t i = 0; i < count; ++i) {
    const Time time = std::chrono::seconds(100) + std::chrono::milliseconds(100 * i);
    if (i < count / 2)
      ended.publish(time, other.frames[i].bytes);
    sensor.publish(time, stream.frames[i].bytes);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(live.end(SIGINT), 0) << live.errors();
  const ProgramRun replay = expectRun("receive -q --replay all " + merge + at(server));
  for (const std::string& output : {live.output(), replay.output})
    EXPECT_TRUE(hasPart(output, "; 10 merged frames\n"));
}

TEST_F(ProgramReplay, HasTheMetadataOfASenderThatBeganAnew)
{
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
  const ProgramRun one =
      expectRemark("receive --replay all -o one.mcap" + streams,
                   "/moves: its sender began anew with other metadata, as where its "
                   "sensor was moved: one.mcap keeps the first ones",
                   1);
  EXPECT_TRUE(hasPart(one.errors, "/moves: its publisher began anew 1 time,"));
  EXPECT_EQ(decode(folder / "one.mcap").at(0).frames.size(), 2 * count);
  expectRun("receive -q --replay all -o part.mcap --rotate-every 1h" + streams);
  std::map<std::string, std::size_t> frames; // by the pose of their file
  for (const auto& part : partsIn(folder)) {
    recording::RecordingReader reader;
    ASSERT_TRUE(reader.open(part.string()).ok());
    frames[reader.streams().at(0).metadata.at("sensor_pose")] +=
        decode(part.string()).at(0).frames.size();
  }
  EXPECT_EQ(
      frames,
      (std::map<std::string, std::size_t>{{first_pose, count}, {second_pose, count}}));
}

} // namespace pcl_ext::tools::test
