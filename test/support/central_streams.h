// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/central_node.h>

#include "stream/frame_encoder.h"
#include "support/fake_clock.h"
#include "support/status_codes.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

using io::CompressionCode;
using io::VoxelFrame;
using io::test::Bytes;
using pcl_ext::test::expectCode;

inline Bytes
coded(const VoxelFrame& frame)
{
  io::FrameEncoder encoder(io::StreamFormat::Version1, 1, io::Effort::Balanced);
  return io::test::encoded(encoder, frame);
}

/** \brief Frames of one sender, and what FrameDecoder makes of each. */
struct CodedStream {
  struct Settings {
    std::uint64_t seed = 1;
    std::size_t frames = 8;
    io::Effort effort = io::Effort::Balanced;
    io::StreamFormat format = io::StreamFormat::Version1;
    unsigned int i_frame_rate = 30;
    double resolution = 0.04;
    std::array<double, 3> origin{}; ///< Published only
    unsigned int bits = 8;
    std::optional<io::DepthModel> depth_model; ///< of the room's voxels
    std::optional<std::uint64_t> first_stamp;  ///< carried, microseconds; 1000 a frame
  };

  explicit CodedStream(const Settings& settings)
  {
    io::test::RoomStream::Settings room_settings =
        io::test::roomSettings(6, 14, false, settings.bits);
    room_settings.seed = settings.seed;
    room_settings.depth_model = settings.depth_model;
    io::test::RoomStream room(room_settings);
    io::FrameEncoder encoder(settings.format, settings.i_frame_rate, settings.effort);
    io::FrameDecoder decoder;
    for (std::size_t i = 0; i < settings.frames; ++i) {
      VoxelFrame frame = room.next();
      frame.grid.resolution = settings.resolution;
      frame.grid.origin = settings.origin;
      std::optional<io::FrameStamp> stamp;
      if (settings.first_stamp)
        stamp = io::FrameStamp{*settings.first_stamp + 1000 * i, "world"};
      frames.push_back(io::test::encoded(encoder, frame, stamp));
      // The tests say which frames can be decoded without which.
      EXPECT_EQ(encoder.statistics().is_i_frame, i % settings.i_frame_rate == 0);
      VoxelFrame voxels;
      EXPECT_EQ(io::test::decoded(decoder, frames.back(), voxels), CompressionCode::Ok);
      EXPECT_GT(voxels.size(), 100u);
      decoded.push_back(voxels);
    }
  }

  std::vector<Bytes> frames;
  std::vector<VoxelFrame> decoded;
};

/** \brief A stream of P-frames after one I-frame, or of another I-frame rate. */
inline CodedStream
streamOf(std::size_t frames, unsigned int i_frame_rate = 30, std::uint64_t seed = 1)
{
  CodedStream::Settings settings;
  settings.frames = frames;
  settings.i_frame_rate = i_frame_rate;
  settings.seed = seed;
  return CodedStream(settings);
}

/** \brief A stream whose frames carry stamps, which are 1000 apart. */
inline CodedStream
stampedStream(std::size_t frames, std::uint64_t first_stamp)
{
  CodedStream::Settings settings;
  settings.frames = frames;
  settings.first_stamp = first_stamp;
  return CodedStream(settings);
}

struct RecordedFrame {
  Time stamp;
  CompressionCode code;
  VoxelFrame voxels;
  io::CodedFrameStatistics statistics;
  bool wants_i_frame;
};

/** \brief Records the frames that a listener is given, in any thread. */
class FrameRecorder {
public:
  FrameListener
  listener()
  {
    return [this](const ReceivedFrame& frame) {
      const std::lock_guard<std::mutex> lock(mutex_);
      frames_[frame.stream].push_back({frame.stamp,
                                       frame.status.code(),
                                       frame.voxels(),
                                       frame.statistics,
                                       frame.wants_i_frame});
    };
  }

  std::vector<RecordedFrame>
  frames(const std::string& stream) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = frames_.find(stream);
    return found == frames_.end() ? std::vector<RecordedFrame>() : found->second;
  }

  /** \brief One letter for each frame: '.' decoded; 'i' failed and wants an I-frame;
   * 'x' failed; 'D' dropped and wants an I-frame; 'd' dropped. */
  std::string
  outcomes(const std::string& stream) const
  {
    std::string outcomes;
    for (const RecordedFrame& frame : frames(stream)) {
      if (frame.code == CompressionCode::Ok) {
        EXPECT_FALSE(frame.wants_i_frame);
        outcomes += '.';
      }
      else if (frame.code == CompressionCode::OldFrame)
        outcomes += frame.wants_i_frame ? 'D' : 'd';
      else
        outcomes += frame.wants_i_frame ? 'i' : 'x';
    }
    return outcomes;
  }

private:
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<RecordedFrame>> frames_;
};

class Gate {
public:
  void
  pass()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    ++arrived_;
    changed_.notify_all();
    changed_.wait(lock, [this] { return is_open_; });
  }

  /** \brief Returns when so many calls of pass() have begun. */
  void
  waitForArrivals(std::size_t arrivals)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return arrived_ >= arrivals; });
  }

  void
  open()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t arrived_ = 0;
  bool is_open_ = false;
};

/** \brief Few threads; merges on the grid of the coded streams. */
inline CentralNodeSettings
centralSettings()
{
  CentralNodeSettings settings;
  settings.resolution = 0.04;
  settings.threads = 2;
  return settings;
}

/** \brief The same with a clock that the test sets. */
inline CentralNodeSettings
settingsWith(const FakeClock& clock)
{
  CentralNodeSettings settings = centralSettings();
  settings.clock = clock.clock();
  return settings;
}

/** \brief Hands over a frame that must be accepted. */
inline void
send(CentralNode& node,
     const std::string& stream,
     const Bytes& bytes,
     std::optional<Time> stamp = std::nullopt)
{
  expectCode(node.receive(stream, bytes, stamp), CentralNodeCode::Ok);
}

/** \brief Hands over a frame and waits until it is decoded, or has failed. */
inline void
sendAndWait(CentralNode& node,
            const std::string& stream,
            const Bytes& bytes,
            std::optional<Time> stamp = std::nullopt)
{
  send(node, stream, bytes, stamp);
  node.waitUntilDecoded();
}

inline VoxelFrame
latestVoxels(const CentralNode& node, const std::string& stream = "a")
{
  VoxelFrame voxels;
  node.latestVoxels(stream, voxels);
  return voxels;
}

inline StreamHealth
onlyHealth(const CentralNode& node)
{
  const std::vector<StreamHealth> health = node.health();
  EXPECT_EQ(health.size(), 1u);
  return health.empty() ? StreamHealth() : health.front();
}

/** \brief A node with one stream "a" and a clock that stands at 0. */
class OneStream : public ::testing::Test {
protected:
  OneStream() { node.addStream("a"); }

  void
  sendFrames(const CodedStream& stream, const std::vector<std::size_t>& indices)
  {
    for (const std::size_t index : indices)
      sendAndWait(node, "a", stream.frames.at(index));
  }

  /** \brief Expects outcomes, as of FrameRecorder, and their counts in the health; no
   * frame waits. */
  void
  expectCounts(const std::string& outcomes, std::size_t frames_lost)
  {
    EXPECT_EQ(recorder.outcomes("a"), outcomes);
    const auto countOf = [&](char letter) {
      return static_cast<std::size_t>(
          std::count(outcomes.begin(), outcomes.end(), letter));
    };
    const StreamHealth health = onlyHealth(node);
    EXPECT_EQ(health.frames_received, outcomes.size());
    EXPECT_EQ(health.frames_decoded, countOf('.'));
    EXPECT_EQ(health.frames_failed, countOf('i') + countOf('x'));
    EXPECT_EQ(health.frames_dropped, countOf('d') + countOf('D'));
    EXPECT_EQ(health.frames_refused, 0u);
    EXPECT_EQ(health.i_frame_requests, countOf('i') + countOf('D'));
    EXPECT_EQ(health.frames_lost, frames_lost);
  }

  FakeClock clock;
  FrameRecorder recorder;
  CentralNode node{settingsWith(clock), recorder.listener()};
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test
