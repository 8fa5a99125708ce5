// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "support/changing_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"
#include "support/world_voxels.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::test::failing_memory {

using namespace io;
using namespace io::test;
using Frames = std::vector<VoxelFrame>;

// Too long for a string's own memory.
inline const std::string long_name = "a frame whose name has a length";

struct Shown {
  bool is_i_frame = false;
  WorldVoxels voxels;
  std::uint64_t stamp = 0;
  std::string frame_id;
};

inline void
expectSame(const Shown& shown, const Shown& expected)
{
  EXPECT_EQ(shown.voxels, expected.voxels);
  EXPECT_EQ(shown.stamp, expected.stamp);
  EXPECT_EQ(shown.frame_id, expected.frame_id);
}

class Sender {
public:
  virtual ~Sender() = default;

  /** \return false if memory ran out; there are no bytes then */
  virtual bool
  send(std::size_t input, Bytes& bytes) = 0;
};

class Receiver {
public:
  virtual ~Receiver() = default;

  /** \return false if memory ran out or the frame lacks its reference */
  virtual bool
  receive(const Bytes& bytes, Shown& shown) = 0;
};

template <typename StatusT, typename CodeT>
bool
isSent(const StatusT& status, CodeT out_of_memory, const Bytes& bytes)
{
  const Exemption exemption;
  EXPECT_EQ(status.ok(), !bytes.empty());
  EXPECT_TRUE(status.ok() || status.code() == out_of_memory) << status.message();
  return status.ok();
}

class FrameReceiver : public Receiver {
public:
  bool
  receive(const Bytes& bytes, Shown& shown) override
  {
    VoxelFrame frame;
    const CompressionStatus status = decoder_.decode(bytes.data(), bytes.size(), frame);
    const Exemption exemption;
    if (!status.ok()) {
      EXPECT_TRUE(frame.keys.empty() && frame.intensities.empty());
      EXPECT_TRUE(status.code() == CompressionCode::OutOfMemory ||
                  status.code() == CompressionCode::MissingReference)
          << status.message();
      return false;
    }
    shown = {decoder_.statistics().is_i_frame, worldVoxels(frame), 0, {}};
    if (decoder_.stamp()) {
      shown.stamp = decoder_.stamp()->stamp;
      shown.frame_id = decoder_.stamp()->frame_id;
    }
    return true;
  }

private:
  FrameDecoder decoder_;
};

// Coders of frames.

struct Coder {
  StreamFormat format;
  Effort effort;
  bool has_depth_model;
  bool has_frames_of_changes = false;
};

constexpr std::size_t frame_count = 9;

/** \brief Frames, one without voxels among them. */
inline Frames
framesOf(const Coder& kind)
{
  Frames frames;
  ChangingFrames changing(8);
  RoomStream room(roomSettings(5, 8, kind.has_depth_model));
  for (std::size_t i = 0; i < frame_count; ++i)
    frames.push_back(kind.has_frames_of_changes ? changing.next(i == 5 ? 3000 : 30)
                                                : room.next());
  if (!kind.has_frames_of_changes)
    clearVoxels(frames[2]);
  return frames;
}

class FrameSender : public Sender {
public:
  FrameSender(const Coder& kind, const Frames& frames)
  : frames_(frames)
  , has_stamps_(kind.format == StreamFormat::Version1)
  , encoder_(kind.format, 4, kind.effort)
  {}

  bool
  send(std::size_t input, Bytes& bytes) override
  {
    std::optional<FrameStamp> stamp;
    if (has_stamps_) {
      const Exemption exemption;
      stamp = FrameStamp{1000 + input, long_name + std::to_string(input / 3)};
    }
    const CompressionStatus status = encoder_.encode(frames_[input], stamp, bytes);
    EXPECT_TRUE(status.ok() || encoder_.isIFrameDue());
    return isSent(status, CompressionCode::OutOfMemory, bytes);
  }

private:
  const Frames& frames_;
  const bool has_stamps_;
  FrameEncoder encoder_;
};

/** \brief A temporal filter before an encoder; it throws where memory runs out. */
class FilterSender : public Sender {
public:
  explicit FilterSender(const Frames& frames) : frames_(frames) {}

  bool
  send(std::size_t input, Bytes& bytes) override
  {
    std::optional<VoxelFrame> frame;
    {
      const Exemption exemption;
      frame = frames_[input];
    }
    try {
      EXPECT_TRUE(filter_.filter(*frame).ok());
    }
    catch (const std::bad_alloc&) {
      encoder_.requestIFrame();
      return false;
    }
    const Exemption exemption;
    bytes = encoded(encoder_, *frame);
    return true;
  }

private:
  const Frames& frames_;
  TemporalVoxelFilter filter_;
  FrameEncoder encoder_{StreamFormat::Version1, 30, Effort::Fast};
};

} // namespace pcl_ext::test::failing_memory
