// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/history_use.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::size_t voxels = 1000;

/** \brief What a P-frame does: U, K or R for the parts of the history, in lower case
 * where it was encoded with and without it. */
char
partOf(HistoryUse& use,
       std::size_t voxel_count,
       std::size_t bytes_with,
       std::size_t bytes_without)
{
  int encoded = 0;
  const auto encode = [&](HistoryPart part) {
    ++encoded;
    return part == HistoryPart::Used ? bytes_with : bytes_without;
  };
  const HistoryPart part = use.choose(voxel_count, encode);
  const std::string letters = encoded > 1 ? "ukr" : "UKR";
  return letters[static_cast<std::size_t>(part)];
}

/** \brief The same of frames that take 1000 bytes without the history.
 * \param[in] bytes_with of each frame with the history
 */
std::string
partsOf(HistoryUse& use, const std::vector<std::size_t>& bytes_with)
{
  std::string parts;
  for (const std::size_t bytes : bytes_with)
    parts += partOf(use, voxels, bytes, 1000);
  return parts;
}

std::string
partsOf(const std::vector<std::size_t>& bytes_with)
{
  HistoryUse use;
  use.addIFrame();
  use.measureIFrame(voxels, 1000);
  return partsOf(use, bytes_with);
}

std::vector<std::size_t>
repeated(std::size_t bytes, std::size_t frames)
{
  return std::vector<std::size_t>(frames, bytes);
}

std::string
times(char part, std::size_t frames)
{
  return std::string(frames, part);
}

TEST(HistoryUse, IsUsedComparedOrGivenUpByWhatItSaves)
{
  std::string given_up = "kKk"; // a loss that does not shrink by a quarter
  for (const std::size_t pause : {15, 31, 63, 63})
    given_up += times('R', pause) + "kKk";
  const std::pair<std::vector<std::size_t>, std::string> cases[] = {
      // A calm scene, at once.
      {repeated(700, 40), "u" + times('U', 31) + "u" + times('U', 7)},
      // Compared the more often the less it saves.
      {repeated(930, 20), "uUUUUUUUUUUUUUUUuUUU"},
      {repeated(960, 10), "uUUUUUUUuU"},
      {repeated(970, 6), "uUuUuU"},
      // A noisy scene: it learns until it pays.
      {{1050, 1020, 980, 950, 940}, "kKUUu"},
      {{1200, 1100, 1100, 1050, 1050, 1050, 1000, 1000}, "kKkKKKKU"},
      // Given up for ever more frames.
      {repeated(1100, given_up.size()), given_up},
      // A loss that shrinks, but is still there after eight frames.
      {{1200, 1200, 1100, 1100, 1100, 1100, 1100, 1050, 1100}, "kKkKKKKkR"},
      // One frame may be an exception.
      {{700, 1300, 700, 1300, 1200, 700}, "ukUkkU"}};
  for (const auto& [bytes_with, parts] : cases)
    EXPECT_EQ(partsOf(bytes_with), parts);
}

TEST(HistoryUse, PausesAreShortAgainOnceItPays)
{
  HistoryUse use;
  use.addIFrame();
  use.measureIFrame(voxels, 1000);
  EXPECT_EQ(partsOf(use, repeated(1100, 18 + 34)),
            "kKk" + times('R', 15) + "kKk" + times('R', 31));
  EXPECT_EQ(partsOf(use, repeated(700, 8)), "UUuUUUUU");
  EXPECT_EQ(partsOf(use, repeated(1100, 22)), "kkkKk" + times('R', 15) + "kK");
}

TEST(HistoryUse, IFramesCountAsFramesOfAPause)
{
  HistoryUse use;
  use.addIFrame();
  use.measureIFrame(voxels, 1000);
  EXPECT_EQ(partsOf(use, repeated(1100, 5)), "kKkRR");
  for (int i = 0; i < 12; ++i)
    use.addIFrame();
  EXPECT_EQ(partsOf(use, repeated(700, 2)), "RU");
}

TEST(HistoryUse, IsGivenUpWhereIFramesInterruptItTwiceInARow)
{
  HistoryUse use;
  const auto parts_after_i_frame = [&use](const std::vector<std::size_t>& bytes_with) {
    use.addIFrame();
    use.measureIFrame(voxels, 1000);
    return partsOf(use, bytes_with);
  };
  EXPECT_EQ(parts_after_i_frame({1050, 1050}), "kK");
  EXPECT_EQ(parts_after_i_frame({900, 900}), "UU"); // one was an exception
  EXPECT_EQ(parts_after_i_frame({1050, 1050}), "kK");
  EXPECT_EQ(parts_after_i_frame({1050, 1050}), "kK");
  EXPECT_EQ(parts_after_i_frame(repeated(1050, 17)), times('R', 15) + "kK");
}

TEST(HistoryUse, ComparesBytesOfAVoxel)
{
  HistoryUse use;
  EXPECT_EQ(partOf(use, 1000, 500, 700), 'u'); // no other comparison for 32 frames
  EXPECT_EQ(partOf(use, 2000, 1400, 0), 'U');
  EXPECT_EQ(partOf(use, 2000, 1401, 1401), 'u');
  EXPECT_EQ(partOf(use, 255, 2000, 0), 'U'); // of so few it is mostly the header
  EXPECT_EQ(partOf(use, 256, 2000, 2000), 'u');
  EXPECT_EQ(partOf(use, 256, 2001, 2000), 'k');
}

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

TEST(HistoryUse, PaysLaterWithNumbersOfPoints)
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
  for (const Effort effort : all_efforts)
    EXPECT_LT(100 * bytesOf(stream, effort, 1000), 97 * bytesOf(stream, effort, 1))
        << static_cast<int>(effort);
}

} // namespace
