#include "codec/history_use.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief Numbers of frames without the history from one with it to the next, where frames
 * take these bytes. */
std::vector<int>
pauses(std::size_t bytes_with, std::size_t bytes_without, int count)
{
  HistoryUse use;
  use.add(false, 1000, bytes_without);
  std::vector<int> found;
  int pause = 0;
  while (static_cast<int>(found.size()) < count) {
    const bool is_useful = use.isUseful();
    use.add(is_useful, 1000, is_useful ? bytes_with : bytes_without);
    if (is_useful)
      found.push_back(pause);
    pause = is_useful ? 0 : pause + 1;
  }
  return found;
}

TEST(HistoryUse, IsTriedAgainAfterEverMoreFrames)
{
  EXPECT_EQ(pauses(1063, 1000, 6), (std::vector<int>{0, 7, 15, 31, 63, 63}));
  EXPECT_EQ(pauses(1000, 1000, 4), (std::vector<int>{0, 0, 0, 0}));
}

TEST(HistoryUse, MayCostALittleAtFirst)
{
  // A sixteenth, for two frames, and not where it is tried again.
  EXPECT_EQ(pauses(1062, 1000, 6), (std::vector<int>{0, 0, 0, 7, 15, 31}));
}

TEST(HistoryUse, ComparesBytesOfAVoxel)
{
  const auto isUseful = [](std::size_t voxels, std::size_t bytes) {
    HistoryUse use;
    use.add(false, 1000, 700);
    for (int i = 0; i < 3; ++i)
      use.add(true, voxels, bytes);
    return use.isUseful();
  };
  EXPECT_TRUE(isUseful(2000, 1400));
  EXPECT_FALSE(isUseful(2000, 1401));
  EXPECT_TRUE(isUseful(255, 2000)); // of so few voxels it is mostly the header
  EXPECT_FALSE(isUseful(256, 2000));
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

} // namespace
