// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief pcl_ext receive --replay of more than a connection may have waiting.
 */
#include <pcl_ext/link/frame_subscriber.h>

#include "stream/frame_encoder.h"
#include "tools/site_program.h"
#include "view/live_source.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <string>

namespace pcl_ext {
namespace tools {
namespace test {

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

} // namespace test
} // namespace tools
} // namespace pcl_ext
