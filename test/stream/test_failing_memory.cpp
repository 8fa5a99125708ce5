/** \file
 * \brief Memory that runs out at any point of encoding and decoding: a status says so,
 * and nothing wrong follows.
 */
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "support/changing_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <new>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::expectFailuresHandled;
using pcl_ext::test::FailingAllocation;

constexpr unsigned int short_i_frame_rate = 4;
constexpr std::size_t few_frames = 9;

struct Coder {
  StreamFormat format;
  Effort effort;
  bool has_depth_model;
  bool has_frames_of_changes = false;
};

std::string
coderName(const Coder& kind)
{
  if (kind.format == StreamFormat::Published)
    return nameOf(kind.format);
  return nameOf(kind.effort) + (kind.has_depth_model ? "WithDepths" : "") +
         (kind.has_frames_of_changes ? "WithFramesOfChanges" : "");
}

/** \brief Frames, one without voxels among them. */
std::vector<VoxelFrame>
framesOf(const Coder& kind)
{
  if (kind.has_frames_of_changes) {
    ChangingFrames changing(8);
    std::vector<VoxelFrame> frames;
    for (std::size_t i = 0; i < few_frames; ++i)
      frames.push_back(changing.next(i == 5 ? 3000 : 30));
    return frames;
  }
  RoomStream room(roomSettings(5, 8, kind.has_depth_model));
  std::vector<VoxelFrame> frames;
  for (std::size_t i = 0; i < few_frames; ++i)
    frames.push_back(room.next());
  clearVoxels(frames[2]);
  return frames;
}

/** \brief What frames carry of a cloud's header; names change, and are too long for a
 * string's own memory. */
std::optional<FrameStamp>
stampOf(const Coder& kind, std::size_t frame)
{
  if (kind.format == StreamFormat::Published)
    return std::nullopt;
  return FrameStamp{1000 + frame,
                    "the frame that a sensor is in, " + std::to_string(frame / 3)};
}

FrameEncoder
encoderOf(const Coder& kind)
{
  return {kind.format, short_i_frame_rate, kind.effort};
}

class FailingMemory : public testing::TestWithParam<Coder> {};

INSTANTIATE_TEST_SUITE_P(
    Coders,
    FailingMemory,
    testing::Values(Coder{StreamFormat::Version1, Effort::Fast, false},
                    Coder{StreamFormat::Version1, Effort::Fast, true},
                    Coder{StreamFormat::Version1, Effort::Fast, false, true},
                    Coder{StreamFormat::Version1, Effort::Balanced, false},
                    Coder{StreamFormat::Version1, Effort::Balanced, true},
                    Coder{StreamFormat::Version1, Effort::Small, false},
                    Coder{StreamFormat::Version1, Effort::Small, true},
                    Coder{StreamFormat::Published, Effort::Fast, false}),
    [](const auto& kind) { return coderName(kind.param); });

/** \brief A receiver whose memory fails while it decodes one frame. */
class Receiver {
public:
  Receiver(const Coder& kind,
           const std::vector<VoxelFrame>& frames,
           const std::vector<Bytes>& bytes)
  : kind_(kind), frames_(frames), bytes_(bytes)
  {}

  /** \brief Decodes a frame whose n-th allocation fails, and all frames after it.
   * \return false if the frame has no n-th allocation
   */
  bool
  runWithFailure(std::size_t frame, std::size_t n, bool do_later_ones_fail)
  {
    FrameDecoder decoder;
    VoxelFrame back;
    for (std::size_t i = 0; i < frame; ++i)
      EXPECT_EQ(decoded(decoder, bytes_[i], back), CompressionCode::Ok);
    bool has_failed = false;
    CompressionStatus status;
    {
      const FailingAllocation failing(n, do_later_ones_fail);
      status = decoder.decode(bytes_[frame].data(), bytes_[frame].size(), back);
      has_failed = failing.hasFailed();
    }
    if (status.ok())
      expectFrame(back, decoder, frame);
    else {
      EXPECT_EQ(status.code(), CompressionCode::OutOfMemory) << status.message();
      EXPECT_TRUE(back.keys.empty() && back.intensities.empty());
    }
    // A sender may send the frame again.
    bool is_known = status.ok();
    if (!is_known)
      is_known = next(decoder, frame);
    for (std::size_t i = frame + 1; i < bytes_.size(); ++i) {
      const bool must_be_known = is_known || i % short_i_frame_rate == 0;
      is_known = next(decoder, i);
      EXPECT_TRUE(is_known || !must_be_known) << i;
    }
    return has_failed;
  }

private:
  bool
  next(FrameDecoder& decoder, std::size_t frame) const
  {
    VoxelFrame back;
    const CompressionCode code = decoded(decoder, bytes_[frame], back);
    if (code == CompressionCode::Ok)
      expectFrame(back, decoder, frame);
    return code == CompressionCode::Ok;
  }

  void
  expectFrame(const VoxelFrame& back,
              const FrameDecoder& decoder,
              std::size_t frame) const
  {
    expectSameVoxels(back, frames_[frame]);
    const std::optional<FrameStamp> stamp = stampOf(kind_, frame);
    ASSERT_EQ(decoder.stamp().has_value(), stamp.has_value());
    if (!stamp)
      return;
    EXPECT_EQ(decoder.stamp()->stamp, stamp->stamp);
    EXPECT_EQ(decoder.stamp()->frame_id, stamp->frame_id);
  }

  const Coder kind_;
  const std::vector<VoxelFrame>& frames_;
  const std::vector<Bytes>& bytes_;
};

TEST_P(FailingMemory, DecodersNeverGiveAWrongFrame)
{
  const std::vector<VoxelFrame> frames = framesOf(GetParam());
  FrameEncoder encoder = encoderOf(GetParam());
  std::vector<Bytes> bytes;
  for (std::size_t i = 0; i < frames.size(); ++i)
    bytes.push_back(encoded(encoder, frames[i], stampOf(GetParam(), i)));
  Receiver receiver(GetParam(), frames, bytes);
  expectFailuresHandled(
      frames.size(), 1, [&](std::size_t frame, std::size_t n, bool do_later_ones_fail) {
        return receiver.runWithFailure(frame, n, do_later_ones_fail);
      });
}

/** \brief Encodes the frames while the memory fails at one of them.
 * \return false if that frame has no n-th allocation
 */
bool
sendWithFailure(const Coder& kind,
                const std::vector<VoxelFrame>& frames,
                std::size_t frame,
                std::size_t n,
                bool do_later_ones_fail)
{
  FrameEncoder encoder = encoderOf(kind);
  FrameDecoder decoder;
  bool has_failed = false;
  bool was_lost = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::optional<FrameStamp> stamp = stampOf(kind, i);
    Bytes bytes;
    CompressionStatus status;
    {
      const FailingAllocation failing(i == frame ? n : 0, do_later_ones_fail);
      status = encoder.encode(frames[i], stamp, bytes);
      has_failed = has_failed || (i == frame && failing.hasFailed());
    }
    if (!status.ok()) {
      EXPECT_EQ(i, frame);
      EXPECT_EQ(status.code(), CompressionCode::OutOfMemory) << status.message();
      EXPECT_TRUE(bytes.empty());
      EXPECT_TRUE(encoder.isIFrameDue());
      was_lost = true;
      continue;
    }
    EXPECT_EQ(encoder.statistics().bytes, bytes.size());
    if (was_lost) {
      EXPECT_TRUE(encoder.statistics().is_i_frame);
      was_lost = false;
    }
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectSameVoxels(back, frames[i]);
  }
  return has_failed;
}

TEST_P(FailingMemory, EncodersContinueWithAnIFrame)
{
  const std::vector<VoxelFrame> frames = framesOf(GetParam());
  expectFailuresHandled(
      frames.size(), 1, [&](std::size_t frame, std::size_t n, bool do_later_ones_fail) {
        return sendWithFailure(GetParam(), frames, frame, n, do_later_ones_fail);
      });
}

/** \brief Filters frames; an allocation of one of them fails, after which the filter
 * shows what one shows that begins with the next frame. */
bool
filterWithFailure(const std::vector<VoxelFrame>& frames,
                  std::size_t frame,
                  std::size_t n,
                  bool do_later_ones_fail)
{
  pcl_ext::TemporalVoxelFilter filter;
  pcl_ext::TemporalVoxelFilter later;
  bool has_failed = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    VoxelFrame shown = frames[i];
    bool is_whole = true;
    {
      const FailingAllocation failing(i == frame ? n : 0, do_later_ones_fail);
      try {
        EXPECT_TRUE(filter.filter(shown).ok());
      }
      catch (const std::bad_alloc&) {
        is_whole = false;
      }
      if (i == frame) {
        has_failed = failing.hasFailed();
        EXPECT_EQ(is_whole, !has_failed);
      }
    }
    if (!is_whole) {
      later.reset();
      continue;
    }
    VoxelFrame expected = frames[i];
    EXPECT_TRUE(later.filter(expected).ok());
    expectSameVoxels(shown, expected);
  }
  return has_failed;
}

TEST(TemporalVoxelFilterMemory, FiltersBeginAnew)
{
  const std::vector<VoxelFrame> frames =
      framesOf({StreamFormat::Version1, Effort::Fast, false});
  expectFailuresHandled(
      frames.size(), 1, [&](std::size_t frame, std::size_t n, bool do_later_ones_fail) {
        return filterWithFailure(frames, frame, n, do_later_ones_fail);
      });
}

} // namespace
