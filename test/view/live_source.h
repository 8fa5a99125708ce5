// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/frame_decoder.h>

#include "stream/frame_encoder.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view::test {

using Bytes = std::vector<std::uint8_t>;

/** \brief Waits until a condition holds; a test fails that waits so long.
 * \return false if it does not hold in time
 */
template <typename ConditionT>
bool
waitFor(const ConditionT& condition)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end)
      return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

class LiveSource {
public:
  /** \param[in] noise voxels anywhere in each frame, about 2 bytes each */
  explicit LiveSource(unsigned int i_frame_rate,
                      std::uint64_t noise = 2,
                      std::uint64_t seed = 1)
  : room_(settingsOf(noise, seed))
  , encoder_(io::StreamFormat::Version1, i_frame_rate, io::Effort::Fast)
  {}

  Bytes
  next()
  {
    Bytes bytes;
    voxels_ = room_.next();
    EXPECT_TRUE(encoder_.encode(voxels_, std::nullopt, bytes).ok());
    return bytes;
  }

  const io::VoxelFrame&
  voxels() const
  {
    return voxels_;
  }

  void
  requestIFrame()
  {
    encoder_.requestIFrame();
  }

private:
  static io::test::RoomStream::Settings
  settingsOf(std::uint64_t noise, std::uint64_t seed)
  {
    io::test::RoomStream::Settings settings;
    settings.seed = seed;
    settings.depth = 8;
    settings.width = 6;
    settings.noise = noise;
    return settings;
  }

  io::test::RoomStream room_;
  io::FrameEncoder encoder_;
  io::VoxelFrame voxels_;
};

inline std::chrono::nanoseconds
timeOfFrame(std::size_t number)
{
  return std::chrono::milliseconds(1'000'000 + 50 * number);
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test
