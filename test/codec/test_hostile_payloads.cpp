#include "support/payload_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

/** \brief A stream whose first three frames the receiver has decoded; the payload of the
 * fourth is replaced. */
struct ForgedStream {
  Effort effort;
  bool is_i_frame;
  std::vector<VoxelFrame> frames;
  std::vector<Bytes> payloads;

  ForgedStream(Effort some_effort,
               bool on_i_frame,
               bool has_depth_model,
               unsigned int bits)
  : effort(some_effort), is_i_frame(on_i_frame)
  {
    RoomStream::Settings settings = roomSettings(6, 9, has_depth_model, bits);
    settings.noise = 4;
    RoomStream room(settings);
    CodingWorkspace work;
    PayloadCoders encoder;
    for (std::size_t i = 0; i < 5; ++i) {
      frames.push_back(room.next());
      payloads.emplace_back();
      encodePayload(
          encoder.of(effort), work, frames.back(), isIFrame(i), payloads.back());
    }
  }

  bool
  isIFrame(std::size_t frame) const
  {
    return frame == 0 || (is_i_frame && frame == 3);
  }

  /** \brief The receiver in front of frame 3. */
  void
  begin(PayloadCoders& decoder) const
  {
    for (std::size_t i = 0; i < 3; ++i) {
      VoxelFrame back;
      ASSERT_TRUE(
          decode(decoder, payloads[i], frames[i], frames[i].size(), isIFrame(i), back));
      expectSameFrame(back, frames[i]);
    }
  }

  /** \brief Whether a frame has a single payload; the context coder's end has several,
   * and a depth model may split a symbol in several ways. */
  bool
  hasOnePayloadAFrame() const
  {
    return effort == Effort::Fast && !frames[0].depth_model;
  }

  /** \brief A payload in the place of the fourth frame's. */
  Bytes
  encodedFourth(const VoxelFrame& frame) const
  {
    CodingWorkspace work;
    PayloadCoders encoder;
    Bytes payload;
    for (std::size_t i = 0; i < 4; ++i) {
      payload.clear();
      encodePayload(
          encoder.of(effort), work, i < 3 ? frames[i] : frame, isIFrame(i), payload);
    }
    return payload;
  }

  bool
  decode(PayloadCoders& decoder,
         const Bytes& payload,
         const VoxelFrame& like,
         std::size_t count,
         bool on_i_frame,
         VoxelFrame& back) const
  {
    PayloadSizes sizes;
    const MemoryUse memory_use;
    CodingWorkspace work;
    PayloadCoder& coder = decoder.of(effort);
    const bool is_good =
        decodePayload(coder, work, payload, like, count, on_i_frame, back, sizes);
    if (is_good)
      coder.learn();
    EXPECT_LE(memory_use.peak(), std::size_t{1} << 22);
    return is_good;
  }
};

/** \brief Decodes forged payloads in the place of the fourth frame. */
class Receiver {
public:
  explicit Receiver(const ForgedStream& stream) : stream_(stream)
  {
    stream_.begin(decoder_);
  }

  /** \brief A payload that is accepted ends the receiver's stream, one that is refused
   * leaves it as it was. */
  void
  take(const Bytes& payload, std::size_t count)
  {
    VoxelFrame back;
    if (!stream_.decode(
            decoder_, payload, stream_.frames[3], count, stream_.isIFrame(3), back)) {
      ++refused;
      return;
    }
    ++accepted;
    if (stream_.hasOnePayloadAFrame()) {
      EXPECT_EQ(stream_.encodedFourth(back), payload);
    }
    decoder_ = PayloadCoders();
    stream_.begin(decoder_);
  }

  /** \brief Expects that the stream goes on. */
  void
  expectUnharmed()
  {
    for (std::size_t i = 3; i < 5; ++i) {
      VoxelFrame back;
      const VoxelFrame& frame = stream_.frames[i];
      ASSERT_TRUE(stream_.decode(decoder_,
                                 stream_.payloads[i],
                                 frame,
                                 frame.size(),
                                 stream_.isIFrame(i),
                                 back));
      expectSameFrame(back, frame);
    }
  }

  std::size_t accepted = 0;
  std::size_t refused = 0;

private:
  const ForgedStream& stream_;
  PayloadCoders decoder_;
};

/** \brief Every kind of stream for each effort. */
std::vector<ForgedStream>
forgedStreams()
{
  std::vector<ForgedStream> streams;
  for (const Effort effort : all_efforts)
    for (const bool is_i_frame : {false, true})
      for (const bool has_depth_model : {false, true})
        streams.emplace_back(effort, is_i_frame, has_depth_model, 8);
  streams.emplace_back(Effort::Balanced, false, true, 16);
  streams.emplace_back(Effort::Balanced, false, false, 16);
  streams.emplace_back(Effort::Small, false, false, 1);
  return streams;
}

TEST(HostilePayloads, TruncationsAreRefusedOrValidFrames)
{
  for (const ForgedStream& stream : forgedStreams()) {
    Receiver receiver(stream);
    const std::size_t count = stream.frames[3].size();
    for (std::size_t size = 0; size < stream.payloads[3].size(); ++size) {
      Bytes payload = stream.payloads[3];
      payload.resize(size);
      receiver.take(payload, count);
    }
    // Behind the end the context coder reads zeros, which may be the intensities; the
    // number of voxels is hardly ever right.
    EXPECT_LT(4 * receiver.accepted, 3 * stream.payloads[3].size());
    EXPECT_TRUE(stream.effort != Effort::Fast || receiver.accepted == 0);
    ASSERT_NO_FATAL_FAILURE(receiver.expectUnharmed());
  }
}

TEST(HostilePayloads, BitFlipsAreRefusedOrValidFrames)
{
  std::mt19937_64 random(1);
  std::size_t refused = 0;
  for (const ForgedStream& stream : forgedStreams()) {
    Receiver receiver(stream);
    for (int round = 0; round < 1500; ++round) {
      Bytes payload = stream.payloads[3];
      for (std::uint64_t i = 1 + below(random, 3); i > 0; --i)
        payload = flipped(payload, below(random, 8 * payload.size()));
      receiver.take(payload, stream.frames[3].size());
    }
    refused += receiver.refused;
    // The last state of rANS shows most of what is wrong, but is no checksum.
    EXPECT_TRUE(stream.effort != Effort::Fast || receiver.refused > 1350);
    ASSERT_NO_FATAL_FAILURE(receiver.expectUnharmed());
  }
  EXPECT_GT(refused, 1000u);
}

TEST(HostilePayloads, RandomBytesAreRefusedOrValidFrames)
{
  std::mt19937_64 random(2);
  for (const ForgedStream& stream : forgedStreams()) {
    Receiver receiver(stream);
    for (int round = 0; round < 1500; ++round) {
      Bytes payload(below(random, round % 10 == 0 ? 4000 : 150));
      const std::uint64_t kind = below(random, 4);
      for (std::uint8_t& byte : payload)
        byte = static_cast<std::uint8_t>(kind == 0   ? 0
                                         : kind == 1 ? 0xff
                                         : kind == 2 ? random() & random() & random()
                                                     : random());
      const std::size_t counts[] = {
          1, 2, stream.frames[3].size(), below(random, 5000) + 1, 1 << 16};
      receiver.take(payload, counts[below(random, 5)]);
    }
    EXPECT_GT(receiver.refused, 1000u);
    ASSERT_NO_FATAL_FAILURE(receiver.expectUnharmed());
  }
}

TEST(HostilePayloads, ManyVoxelsInADeepGridAreRefused)
{
  // The most expensive payload: constant decisions, 19 levels above blocks.
  for (const Effort effort : all_efforts)
    for (const std::uint8_t byte : Bytes{0, 0xff}) {
      CodingWorkspace work;
      PayloadCoders decoder;
      VoxelFrame back;
      PayloadSizes sizes;
      EXPECT_FALSE(decodePayload(decoder.of(effort),
                                 work,
                                 Bytes(100000, byte),
                                 emptyFrame(21),
                                 1 << 17,
                                 true,
                                 back,
                                 sizes));
    }
}

} // namespace
