#include "codec/payload_coder.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

/** \brief A stream of which the receiver has seen some frames, and the frame that an
 * enemy replaces. */
struct Attack {
  Effort effort;
  bool is_i_frame;
  std::vector<VoxelFrame> frames;
  std::vector<Bytes> payloads;

  Attack(Effort some_effort, bool on_i_frame, bool has_depth_model, unsigned int bits)
  : effort(some_effort), is_i_frame(on_i_frame)
  {
    RoomStream::Settings settings;
    settings.depth = 6;
    settings.width = 9;
    settings.bits = bits;
    settings.noise = 4;
    if (has_depth_model)
      settings.depth_model = roomDepthModel(settings.depth, bits);
    RoomStream room(settings);
    CodingWorkspace work;
    PayloadCoders encoder;
    for (std::size_t i = 0; i < 5; ++i) {
      frames.push_back(room.next());
      payloads.emplace_back();
      encoder.of(effort).encode(work, frames.back(), isIFrame(i), payloads.back());
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

  bool
  decode(PayloadCoders& decoder,
         const Bytes& payload,
         const VoxelFrame& like,
         std::size_t count,
         bool on_i_frame,
         VoxelFrame& back) const
  {
    Bytes exact = payload;
    exact.shrink_to_fit();
    back = like;
    PayloadSizes sizes;
    const MemoryUse memory_use;
    CodingWorkspace work;
    PayloadCoder& coder = decoder.of(effort);
    const bool is_good = coder.decode(work,
                                      exact.data(),
                                      exact.data() + exact.size(),
                                      count,
                                      on_i_frame,
                                      back,
                                      sizes);
    if (is_good)
      coder.learn();
    EXPECT_LE(memory_use.peak(), std::size_t{1} << 22);
    if (is_good) {
      EXPECT_TRUE(isConsistent(back));
      EXPECT_EQ(back.size(), count);
      EXPECT_EQ(sizes.occupancy + sizes.intensity, payload.size());
    }
    return is_good;
  }
};

/** \brief What came of hostile payloads. */
struct Outcome {
  std::size_t accepted = 0;
  std::size_t refused = 0;
};

/** \brief Gives hostile payloads to a receiver; one that was taken for a frame ends that
 * receiver's stream, one that was not leaves it as it was. */
class Victim {
public:
  explicit Victim(const Attack& attack) : attack_(attack) { attack_.begin(decoder_); }

  void
  take(const Bytes& payload, std::size_t count)
  {
    VoxelFrame back;
    if (attack_.decode(
            decoder_, payload, attack_.frames[3], count, attack_.isIFrame(3), back)) {
      ++outcome.accepted;
      decoder_ = PayloadCoders();
      attack_.begin(decoder_);
    }
    else
      ++outcome.refused;
  }

  /** \brief Expects that the stream goes on. */
  void
  expectUnharmed()
  {
    for (std::size_t i = 3; i < 5; ++i) {
      VoxelFrame back;
      const VoxelFrame& frame = attack_.frames[i];
      ASSERT_TRUE(attack_.decode(decoder_,
                                 attack_.payloads[i],
                                 frame,
                                 frame.size(),
                                 attack_.isIFrame(i),
                                 back));
      expectSameFrame(back, frame);
    }
  }

  Outcome outcome;

private:
  const Attack& attack_;
  PayloadCoders decoder_;
};

/** \brief Every kind of stream for each effort. */
std::vector<Attack>
attacks()
{
  std::vector<Attack> attacks;
  for (const Effort effort : {Effort::Fast, Effort::Balanced, Effort::Small})
    for (const bool is_i_frame : {false, true})
      for (const bool has_depth_model : {false, true})
        attacks.emplace_back(effort, is_i_frame, has_depth_model, 8);
  attacks.emplace_back(Effort::Balanced, false, true, 16);
  attacks.emplace_back(Effort::Balanced, false, false, 16);
  attacks.emplace_back(Effort::Small, false, false, 1);
  return attacks;
}

TEST(HostilePayloads, TruncationsAreRefusedOrFrames)
{
  for (const Attack& attack : attacks()) {
    Victim victim(attack);
    const std::size_t count = attack.frames[3].size();
    for (std::size_t size = 0; size < attack.payloads[3].size(); ++size) {
      Bytes payload = attack.payloads[3];
      payload.resize(size);
      victim.take(payload, count);
    }
    // Bits go on behind the end, so that intensities may come out of nothing; voxels of
    // just that number hardly do.
    EXPECT_LT(4 * victim.outcome.accepted, 3 * attack.payloads[3].size());
    ASSERT_NO_FATAL_FAILURE(victim.expectUnharmed());
  }
}

TEST(HostilePayloads, FlipsAreRefusedOrFrames)
{
  std::mt19937_64 random(1);
  std::size_t refused = 0;
  for (const Attack& attack : attacks()) {
    Victim victim(attack);
    for (int round = 0; round < 1500; ++round) {
      Bytes payload = attack.payloads[3];
      for (std::uint64_t i = 1 + below(random, 3); i > 0; --i) {
        const std::size_t bit = below(random, 8 * payload.size());
        payload[bit / 8] = static_cast<std::uint8_t>(payload[bit / 8] ^ 1u << bit % 8);
      }
      victim.take(payload, attack.frames[3].size());
    }
    refused += victim.outcome.refused;
    ASSERT_NO_FATAL_FAILURE(victim.expectUnharmed());
  }
  EXPECT_GT(refused, 1000u);
}

TEST(HostilePayloads, RandomBytesAreRefusedOrFrames)
{
  std::mt19937_64 random(2);
  for (const Attack& attack : attacks()) {
    Victim victim(attack);
    for (int round = 0; round < 1500; ++round) {
      Bytes payload(below(random, round % 10 == 0 ? 4000 : 150));
      const std::uint64_t kind = below(random, 4);
      for (std::uint8_t& byte : payload)
        byte = static_cast<std::uint8_t>(kind == 0   ? 0
                                         : kind == 1 ? 0xff
                                         : kind == 2 ? random() & random() & random()
                                                     : random());
      const std::size_t counts[] = {
          1, 2, attack.frames[3].size(), below(random, 5000) + 1, 1 << 16};
      victim.take(payload, counts[below(random, 5)]);
    }
    EXPECT_GT(victim.outcome.refused, 1000u);
    ASSERT_NO_FATAL_FAILURE(victim.expectUnharmed());
  }
}

TEST(HostilePayloads, WrongCountsAreRefused)
{
  for (const Attack& attack : attacks()) {
    Victim victim(attack);
    const std::size_t count = attack.frames[3].size();
    for (const std::size_t wrong : {std::size_t{0},
                                    std::size_t{1},
                                    count - 1,
                                    count + 1,
                                    2 * count,
                                    std::size_t{1} << 20})
      victim.take(attack.payloads[3], wrong);
    EXPECT_EQ(victim.outcome.accepted, 0u);
    ASSERT_NO_FATAL_FAILURE(victim.expectUnharmed());
  }
}

TEST(HostilePayloads, ADeepGridOfTheMostVoxelsEndsSoon)
{
  // The dearest payload: no bytes, all decisions as they come, 19 levels above blocks.
  for (const Effort effort : {Effort::Fast, Effort::Balanced, Effort::Small})
    for (const std::uint8_t byte : Bytes{0, 0xff}) {
      CodingWorkspace work;
      PayloadCoders decoder;
      VoxelFrame back = emptyFrame(21);
      PayloadSizes sizes;
      const Bytes payload(100000, byte);
      EXPECT_FALSE(decoder.of(effort).decode(work,
                                             payload.data(),
                                             payload.data() + payload.size(),
                                             1 << 17,
                                             true,
                                             back,
                                             sizes));
    }
}

} // namespace
