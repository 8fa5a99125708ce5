// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: what reaches a decoder of one or two senders' frames, with frames lost,
 * swapped, repeated, damaged and cut off, senders that start again and frame numbers
 * that wrap, against a model of what may be shown.
 *
 * A decoded frame is the one that was encoded with these bytes. A P-frame is decoded
 * only after its own predecessor. A damaged frame of version 1 is never decoded. A
 * frame that was decoded since its sender began is not decoded again, except for an
 * I-frame right after itself, and unless so many frames were refused in a row that the
 * decoder takes the sender for one that began again.
 *
 * What must be decoded: the frame after the one that was decoded last, also if others
 * were refused in between; an I-frame with a higher number that is no copy; the first
 * I-frame that a decoder meets; and at the end the first two frames of a sender that
 * starts again.
 *
 * The published layout has no checksum: once a damaged frame of it has passed, or a
 * P-frame after another sender's frame of the right number, nothing is demanded of it
 * until its next I-frame.
 */
#include "checked_decoding.h"
#include "small_streams.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <utility>

namespace {

using namespace pcl_ext::fuzz;
using namespace pcl_ext::io;

constexpr std::size_t frames_of_run = 12;
constexpr std::size_t most_deliveries = 32;

/** \brief A sender that started several times; the last run is kept for the end. */
struct Sender {
  static constexpr std::size_t runs_in_use = 3;
  std::array<SentStream, runs_in_use + 1> runs;
};

/** \brief The senders of one byte of an input, made when they are first asked for. */
const Sender&
senderOf(std::uint8_t choice, std::size_t which)
{
  static std::map<std::size_t, std::unique_ptr<Sender>> senders;
  const std::size_t index = 2 * (choice % stream_choices) + which;
  std::unique_ptr<Sender>& sender = senders[index];
  if (!sender) {
    sender = std::make_unique<Sender>();
    const StreamKind kind = streamKind(choice);
    for (std::size_t run = 0; run < sender->runs.size(); ++run) {
      // The third run has been sent for years: its numbers wrap within it.
      const bool wraps = run == 2 && kind.format == StreamFormat::Version1;
      const std::size_t seed = 10 * index + run + 1;
      sendAll(kind,
              sensorFrames(
                  kind, seed, frames_of_run, 0.04 + 0.001 * static_cast<double>(seed)),
              run == 1 ? 100 : 4,
              wraps ? ~std::uint32_t{0} - 4 : 1,
              sender->runs[run]);
    }
  }
  return *sender;
}

bool
isPublished(const SentFrame& frame)
{
  return frame.kind->format == StreamFormat::Published;
}

/** \brief A decoder and what is known of it. */
class Receiver {
public:
  Receiver() : decoder_(smallLimits()) {}

  /** \brief Delivers a frame as it was sent, or with bytes before it that are no
   * frame. */
  void
  deliver(const SentFrame& sent, std::size_t rubbish = 0)
  {
    Bytes bytes(rubbish, 0x2a);
    bytes.insert(bytes.end(), sent.bytes.begin(), sent.bytes.end());
    History& history = historyOf(sent);
    const bool is_copy = contains(history.decoded, sent);
    const bool is_successor = last_ != nullptr && sent.predecessor == last_;
    if (decode(bytes).ok()) {
      require(!contains(history.decoded_since_start, sent) || is_successor ||
              (sent.is_i_frame && history.last == &sent) ||
              sent.sensor_frame.voxels.keys
                  .empty() || // the same to the byte as another one
              (sent.number == 1 && history.has_input_ended) ||
              history.refused_in_a_row >= refused_until_restart);
      accept(sent);
      return;
    }
    ++history.refused_in_a_row;
    const bool is_first = is_untouched_ && sent.is_i_frame;
    const bool is_newer = sent.is_i_frame && last_ != nullptr &&
                          isPublished(*last_) == isPublished(sent) &&
                          isAbove(sent.number, last_->number);
    require(is_copy || !(is_first || is_successor || is_newer));
  }

  void
  deliverDamaged(const SentFrame& sent, const Bytes& bytes, bool is_cut_off)
  {
    History& history = historyOf(sent);
    if (!decode(bytes).ok()) {
      ++history.refused_in_a_row;
      return;
    }
    require(isPublished(sent) && !is_cut_off);
    is_untouched_ = false;
    // Copies of what was decoded before it stay copies. The frame itself is one from
    // now on if the damage is in bytes that do not change what it shows.
    std::deque<const SentFrame*> decoded = std::move(history.decoded);
    if (isSame(sent, decoded_frame_, decoder_.stamp()))
      decoded.push_back(&sent);
    history = History();
    history.decoded = std::move(decoded);
    history.is_known = false;
    last_ = nullptr;
  }

  void
  deliverRestart(const SentStream& stream)
  {
    for (std::size_t i = 0; i < 2; ++i) {
      require(decode(stream.frames[i].bytes).ok());
      accept(stream.frames[i]);
    }
  }

private:
  struct History {
    const SentFrame* last = nullptr;
    bool is_known = true; // what the decoder holds is what was sent
    std::deque<const SentFrame*> decoded;
    std::deque<const SentFrame*> decoded_since_start;
    unsigned int refused_in_a_row = 0;
    bool has_input_ended = false; // and may begin again
  };

  /** \brief The decoder's rule has more; damaged frames, which count here, are not
   * its. */
  static constexpr unsigned int refused_until_restart = 8;

  History&
  historyOf(const SentFrame& sent)
  {
    return histories_[isPublished(sent) ? 1 : 0];
  }

  static bool
  isAbove(std::uint32_t number, std::uint32_t other)
  {
    return static_cast<std::int32_t>(number - other) > 0;
  }

  static bool
  contains(const std::deque<const SentFrame*>& frames, const SentFrame& sent)
  {
    // Two senders may make the same bytes.
    return std::any_of(frames.begin(), frames.end(), [&](const SentFrame* frame) {
      return frame->bytes == sent.bytes;
    });
  }

  CompressionStatus
  decode(const Bytes& bytes)
  {
    const CompressionStatus status =
        decoder_.decode(bytes.data(), bytes.size(), decoded_frame_);
    if (status.code() == CompressionCode::EndOfStream)
      for (History& history : histories_)
        history.has_input_ended = true;
    if (status.ok())
      require(isConsistent(decoded_frame_));
    else
      requireReason(status, decoded_frame_);
    return status;
  }

  /** \brief A frame was decoded, as which it was delivered. */
  void
  accept(const SentFrame& sent)
  {
    History& history = historyOf(sent);
    const bool is_same = isSame(sent, decoded_frame_, decoder_.stamp());
    if (!isPublished(sent))
      require(is_same && (sent.is_i_frame || history.last == sent.predecessor));
    else if (sent.is_i_frame) {
      require(is_same);
      history.is_known = true;
    }
    else if (history.is_known) {
      require(history.last != nullptr && history.last->number + 1 == sent.number);
      history.is_known = history.last == sent.predecessor;
      require(is_same || !history.is_known);
    }
    history.has_input_ended = false;
    if (history.last != nullptr && !isAbove(sent.number, history.last->number))
      history.decoded_since_start.clear();
    for (auto* const frames : {&history.decoded, &history.decoded_since_start}) {
      frames->push_back(&sent);
      constexpr std::size_t remembered_frames = 256;
      if (frames->size() > remembered_frames)
        frames->pop_front();
    }
    history.last = &sent;
    history.refused_in_a_row = 0;
    is_untouched_ = false;
    last_ = history.is_known ? &sent : nullptr;
  }

  FrameDecoder decoder_;
  VoxelFrame decoded_frame_;
  bool is_untouched_ = true;        // nothing was decoded yet
  const SentFrame* last_ = nullptr; // decoded last, if it is known which
  std::array<History, 2> histories_;
};

struct Position {
  const Sender* sender;
  std::size_t run = 0;
  std::size_t next = 0;

  const SentStream&
  stream() const
  {
    return sender->runs[run];
  }

  const SentFrame&
  nextFrame() const
  {
    return stream().frames[next];
  }

  void
  restart()
  {
    run = (run + 1) % Sender::runs_in_use;
    next = 0;
  }

  void
  advance(std::size_t frames)
  {
    next += frames;
    if (next >= frames_of_run)
      restart();
  }
};

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FuzzInput input(data, size);
  const std::uint8_t kinds = input.byte();
  // Mostly two of a kind, whose frames are more similar.
  const std::uint8_t second_kind = input.byte();
  Position positions[] = {
      {&senderOf(kinds, 0)},
      {&senderOf(second_kind < 128 ? kinds : second_kind, 1)},
  };
  Receiver receiver;
  for (std::size_t i = 0; i < most_deliveries && !input.isAtEnd(); ++i) {
    const std::uint8_t choice = input.byte();
    Position& position = positions[choice >> 3 & 1];
    switch (choice & 7) {
    case 0:
    case 1:
      receiver.deliver(position.nextFrame(), choice >> 4 & 3);
      position.advance(1);
      break;
    case 2: // lost
      position.advance(1 + (choice >> 4));
      break;
    case 3: // a copy of an earlier frame, or one that comes early
      receiver.deliver(position.stream().frames[input.byte() % frames_of_run]);
      break;
    case 4: { // the same, of any run
      const std::uint8_t which = input.byte();
      receiver.deliver(position.sender->runs[which / 16 % Sender::runs_in_use]
                           .frames[which % frames_of_run]);
      break;
    }
    case 5:
      receiver.deliverDamaged(
          position.nextFrame(),
          test::flipped(position.nextFrame().bytes, input.number<std::uint16_t>()),
          false);
      break;
    case 6: {
      Bytes bytes = position.nextFrame().bytes;
      bytes.resize(input.byte() % bytes.size());
      receiver.deliverDamaged(position.nextFrame(), bytes, true);
      break;
    }
    default:
      position.restart();
    }
  }
  receiver.deliverRestart(positions[0].sender->runs.back());
  return 0;
}
