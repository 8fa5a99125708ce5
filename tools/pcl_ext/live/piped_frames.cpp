// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "live/piped_frames.h"

#include <pcl_ext/compression/frame_decoder.h>

#include "console/interruption.h"
#include "inputs/standard_input.h"
#include "options/text_values.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace pcl_ext::tools {

namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 16;
constexpr char mcap_magic[] = "\x89MCAP0\r\n";

/** \brief Limits for looking at frames without decoding them. */
io::DecoderLimits
limitsOfFrames()
{
  io::DecoderLimits limits = io::DecoderLimits::none();
  limits.max_frame_bytes = io::DecoderLimits().max_frame_bytes;
  return limits;
}

} // namespace

bool
PipedFrames::receive(const std::function<void()>& meanwhile)
{
  while (!isInterrupted()) {
    if (meanwhile) {
      constexpr int patience_ms = 100;
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const int ready = ::poll(&input, 1, patience_ms);
      meanwhile();
      if (ready == 0)
        continue;
    }
    const std::size_t before = bytes_.size();
    bytes_.resize(before + piece_bytes);
    const std::size_t count = readPipe(STDIN_FILENO, &bytes_[before], piece_bytes);
    bytes_.resize(before + count);
    if (count == 0)
      return false;
    if (bytes_.size() >= needed_)
      return true;
  }
  return false;
}

/** \brief The frame's stamp, or the time now if frames have none. */
std::chrono::nanoseconds
PipedFrames::timeOf(const io::FrameDescription& frame)
{
  if (frame.is_i_frame)
    stamp_ = frame.stamp;
  else if (frame.stamp_difference)
    stamp_ = stamp_.value_or(0) + static_cast<std::uint64_t>(*frame.stamp_difference);
  constexpr std::uint64_t most =
      std::uint64_t{std::numeric_limits<std::int64_t>::max()} / 1000;
  if (stamp_ && *stamp_ <= most)
    return std::chrono::microseconds(static_cast<std::int64_t>(*stamp_));
  return std::chrono::system_clock::now().time_since_epoch();
}

void
PipedFrames::publish(const std::uint8_t* frame, std::size_t size)
{
  const io::FrameDescription description =
      io::describeFrame(frame, size, limitsOfFrames());
  const std::size_t number = frames_++;
  const io::FrameChain::Place place = chain_.take(description, frame, size);
  if (place == io::FrameChain::Place::Next) {
    ++frames_published_;
    output_.publish(stream_, timeOf(description), {frame, frame + size});
  }
  else if (place == io::FrameChain::Place::Gap && frames_published_ == 0)
    ++frames_early_;
  else {
    failures_.add(name_, number, "", undecodable_frame);
    is_whole_ = false;
  }
}

void
PipedFrames::publishFrames()
{
  std::size_t begin = 0;
  needed_ = 1;
  while (begin < bytes_.size() && !isInterrupted()) {
    const std::uint8_t* const bytes = bytes_.data() + begin;
    const std::size_t count = bytes_.size() - begin;
    const io::FrameSize size = io::frameSize(bytes, count, limitsOfFrames());
    if (size.needed > count) {
      needed_ = size.needed;
      break;
    }
    if (size.status.ok()) {
      publish(bytes, size.known);
    }
    else {
      if (skipped_bytes_ == 0)
        first_problem_ = size.status.message();
      skipped_bytes_ += size.drop;
      is_whole_ &= frames_ == 0;
    }
    begin += size.known + size.drop;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin));
}

bool
PipedFrames::run(const std::function<void()>& meanwhile)
{
  stream_ = output_.addStream(name_, {});
  needed_ = sizeof(mcap_magic) - 1;
  bool is_first = true;
  while (receive(meanwhile)) {
    if (is_first && std::equal(mcap_magic,
                               mcap_magic + needed_,
                               bytes_.begin(),
                               [](char a, std::uint8_t b) {
                                 return static_cast<std::uint8_t>(a) == b;
                               }))
      throw std::runtime_error(
          "the standard input is an MCAP file, which can be read when it is complete: "
          "name the file; frames that arrive are .pcxi, as pcl_ext encode -o - writes "
          "them");
    is_first = false;
    publishFrames();
  }
  failures_.finish();
  if (frames_published_ == 0 && !isInterrupted())
    throw std::runtime_error("the standard input has no " + emptiness());
  const bool is_whole = report();
  output_.end();
  return is_whole;
}

std::string
PipedFrames::emptiness() const
{
  if (frames_ > 0)
    return "frame that can be decoded: no I-frame is among its " +
           counted(frames_, "frame");
  if (!first_problem_.empty())
    return "frame: " + first_problem_;
  return bytes_.empty() ? "frame: it is empty" : "frame: it ends within the first one";
}

bool
PipedFrames::report()
{
  if (frames_early_ > 0)
    console_.remark(counted(frames_early_, "frame") +
                    " left out before the first I-frame of the standard input");
  if (skipped_bytes_ > 0)
    console_.error(std::to_string(skipped_bytes_) +
                   " bytes of the standard input are no frame: " + first_problem_);
  const bool is_cut_off = !bytes_.empty() && !isInterrupted();
  if (is_cut_off)
    console_.error("the standard input ends within a frame, which is lost");
  return is_whole_ && !is_cut_off;
}

} // namespace pcl_ext::tools
