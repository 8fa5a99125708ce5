#include "codec/history_use.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::size_t voxels = 1000;

/** \brief Numbers of frames without the history from one with it, or that tried it, to
 * the next, where frames take these bytes. */
std::vector<int>
pauses(std::size_t bytes_with, std::size_t bytes_without, int count)
{
  HistoryUse use;
  use.measure(voxels, bytes_without);
  std::vector<int> found;
  int pause = 0;
  while (static_cast<int>(found.size()) < count) {
    if (!use.isUseful()) {
      use.addWithout(false);
      ++pause;
      continue;
    }
    found.push_back(pause);
    pause = 0;
    if (use.isDoubtful(voxels, bytes_with) && !use.isWorth(bytes_with, bytes_without))
      use.addWithout(true);
    else
      use.addWith();
  }
  return found;
}

TEST(HistoryUse, IsTriedAgainAfterEverMoreFrames)
{
  EXPECT_EQ(pauses(1032, 1000, 6), (std::vector<int>{0, 7, 15, 31, 63, 63}));
  EXPECT_EQ(pauses(1000, 1000, 4), (std::vector<int>{0, 0, 0, 0}));
}

TEST(HistoryUse, MayCostALittleAtFirst)
{
  // A 32nd, for two frames.
  EXPECT_EQ(pauses(1031, 1000, 7), (std::vector<int>{0, 0, 0, 7, 0, 0, 15}));
}

TEST(HistoryUse, PausesAreShortAgainOnceItPays)
{
  HistoryUse use;
  use.measure(voxels, 1000);
  const auto framesUntilUseful = [&] {
    use.addWithout(true);
    int frames = 0;
    for (; !use.isUseful(); ++frames)
      use.addWithout(false);
    return frames;
  };
  EXPECT_EQ(framesUntilUseful(), 7);
  EXPECT_EQ(framesUntilUseful(), 15);
  for (int i = 0; i < 2; ++i)
    use.addWith();
  EXPECT_EQ(framesUntilUseful(), 31);
  for (int i = 0; i < 3; ++i)
    use.addWith();
  EXPECT_EQ(framesUntilUseful(), 7);
}

TEST(HistoryUse, ComparesBytesOfAVoxel)
{
  HistoryUse use;
  use.measure(1000, 700);
  for (int i = 0; i < 2; ++i)
    use.addWith();
  EXPECT_FALSE(use.isDoubtful(2000, 1400));
  EXPECT_TRUE(use.isDoubtful(2000, 1401));
  EXPECT_FALSE(use.isDoubtful(255, 2000)); // of so few voxels it is mostly the header
  EXPECT_TRUE(use.isDoubtful(256, 2000));
  EXPECT_TRUE(use.isWorth(700, 700));
  EXPECT_FALSE(use.isWorth(701, 700));
}

/** \brief Sheets of voxels, a different one in each frame. */
std::vector<VoxelFrame>
jumpingSheets(int frames)
{
  std::mt19937_64 random(5);
  std::vector<VoxelFrame> stream;
  for (int i = 0; i < frames; ++i) {
    VoxelFrame frame = emptyFrame(8);
    const std::uint64_t place = below(random, 90);
    std::set<std::uint64_t> keys;
    for (std::uint32_t y = 0; y < 60; ++y)
      for (std::uint32_t z = 0; z < 60; ++z)
        keys.insert(mortonKey(
            {static_cast<std::uint32_t>(place + (3 * y + 2 * z) / 10), 9 + y, 40 + z}));
    setVoxels(random, keys, frame);
    stream.push_back(frame);
  }
  return stream;
}

std::size_t
bytesOf(const std::vector<VoxelFrame>& stream, Effort effort, unsigned int i_frame_rate)
{
  FrameEncoder encoder(StreamFormat::Version1, i_frame_rate, effort);
  FrameDecoder decoder;
  VoxelFrame back;
  std::size_t bytes = 0;
  for (const VoxelFrame& frame : stream) {
    const Bytes coded = encoded(encoder, frame);
    bytes += coded.size();
    EXPECT_EQ(decoded(decoder, coded, back), CompressionCode::Ok);
    EXPECT_EQ(back.keys, frame.keys);
    EXPECT_EQ(back.intensities, frame.intensities);
  }
  return bytes;
}

TEST(HistoryUse, CostsLittleWhereNothingStays)
{
  const std::vector<VoxelFrame> stream = jumpingSheets(60);
  for (const Effort effort : all_efforts)
    EXPECT_LE(200 * bytesOf(stream, effort, 1000), 201 * bytesOf(stream, effort, 1))
        << static_cast<int>(effort);
}

/** \brief Voxels with numbers of points at one of six depths, half of them in each
 * frame: the first P-frame takes 4 % more bytes than an I-frame, the tenth 13 %
 * fewer. */
std::vector<VoxelFrame>
noisyNumbers(int frames)
{
  std::mt19937_64 random(5);
  std::vector<VoxelFrame> stream;
  for (int i = 0; i < frames; ++i) {
    VoxelFrame frame = emptyFrame(8);
    frame.intensity_scale.bits = 0;
    frame.has_point_counts = true;
    std::set<std::uint64_t> keys;
    for (std::uint32_t y = 0; y < 60; ++y)
      for (std::uint32_t z = 0; z < 60; ++z)
        if (below(random, 2) == 0)
          keys.insert(mortonKey(
              {20 + static_cast<std::uint32_t>(below(random, 6)), 9 + y, 40 + z}));
    frame.keys.assign(keys.begin(), keys.end());
    for (std::size_t voxel = 0; voxel < keys.size(); ++voxel)
      frame.point_counts.push_back(1 + static_cast<std::uint32_t>(below(random, 3)));
    stream.push_back(frame);
  }
  return stream;
}

TEST(HistoryUse, MayCostMoreAtFirstWithNumbersOfPoints)
{
  const std::vector<VoxelFrame> stream = noisyNumbers(40);
  EXPECT_LT(10 * bytesOf(stream, Effort::Fast, 1000),
            9 * bytesOf(stream, Effort::Fast, 1));
}

/** \brief A rough surface, of which each frame sees a third: the history of one frame
 * has a third of a frame's voxels, that of ten nearly all. */
std::vector<VoxelFrame>
flickeringSurface(int frames)
{
  std::mt19937_64 random(6);
  std::vector<std::uint64_t> surface;
  for (std::uint32_t y = 0; y < 120; ++y)
    for (std::uint32_t z = 0; z < 120; ++z)
      surface.push_back(mortonKey(
          {static_cast<std::uint32_t>(60 + below(random, 8)), 20 + y, 30 + z}));
  std::vector<VoxelFrame> stream;
  for (int i = 0; i < frames; ++i) {
    std::set<std::uint64_t> keys;
    for (const std::uint64_t key : surface)
      if (below(random, 3) == 0)
        keys.insert(key);
    VoxelFrame frame = emptyFrame(8);
    setVoxels(random, keys, frame);
    stream.push_back(frame);
  }
  return stream;
}

TEST(HistoryUse, PaysWhereOneFrameKnowsFewVoxels)
{
  const std::vector<VoxelFrame> stream = flickeringSurface(30);
  for (const Effort effort : {Effort::Balanced, Effort::Small})
    EXPECT_LT(100 * bytesOf(stream, effort, 1000), 97 * bytesOf(stream, effort, 1))
        << static_cast<int>(effort);
}

} // namespace
