// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "link/followed_stream.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::link {

namespace {

/** \brief True if a checksum tells a frame from others, see io::FrameOrder::decoded(). */
bool
isIdentifiable(const io::FrameDescription& frame)
{
  return frame.voxels > 0 || frame.stamp || frame.stamp_difference;
}

} // namespace

void
FollowedStream::begin(std::uint64_t publisher, std::uint32_t number)
{
  publisher_ = publisher;
  ++statistics.publishers;
  number_ = number - 1;
  order_ = io::FrameOrder(true);
  chain_.breakOff();
}

void
FollowedStream::skip()
{
  ++(has_i_frame_ ? statistics.frames_skipped : statistics.frames_early);
}

bool
FollowedStream::isLate(const FrameHeader& header,
                       std::uint32_t checksum,
                       bool is_i_frame)
{
  const auto number = static_cast<std::uint32_t>(header.number);
  const std::uint32_t advance = number - number_;
  // A connection that was lost may deliver many frames after the next one's first, with
  // I-frames among them. A lower number alone may follow a forged one that was too high,
  // and so may a time that is much earlier.
  constexpr std::chrono::minutes longest_delay{1};
  const bool is_before = advance >= 1u << 31 && header.time < time_ &&
                         header.time >= time_ - std::min<Time>(time_, longest_delay);
  return advance == 0 || is_before || order_.isOld(number, checksum, is_i_frame) ||
         (!is_i_frame && advance > most_lost);
}

bool
FollowedStream::accept(const FrameHeader& header, const WholeFrame& frame)
{
  const bool is_i_frame = frame.description.is_i_frame;
  const bool is_of_another = publisher_ != header.publisher;
  // Another run of the publisher, or a second one. It begins anew with an I-frame; until
  // then the frames of the one before may go on.
  if (is_of_another && publisher_ && !is_i_frame) {
    skip();
    ++frames_of_another_;
    return false;
  }
  const auto number = static_cast<std::uint32_t>(header.number);
  const std::uint32_t checksum =
      io::checksumOf(frame.description, frame.bytes, frame.size);
  if (!is_of_another && isLate(header, checksum, is_i_frame)) {
    ++statistics.frames_late;
    ++late_in_a_row_;
    return false;
  }
  const bool begins = is_of_another || number - number_ > most_lost;
  const bool is_next = !begins && number == number_ + 1;
  const auto place = chain_.placeOf(frame.description, frame.bytes, frame.size);
  if (place == io::FrameChain::Place::Damaged) {
    ++statistics.frames_damaged;
    // Elsewhere its number is not to be trusted.
    if (is_next) {
      number_ = number;
      chain_.breakOff();
    }
    return false;
  }
  if (begins)
    begin(header.publisher, number);
  statistics.frames_lost += number - number_ - 1;
  number_ = number;
  time_ = header.time;
  order_.decoded(number, checksum, isIdentifiable(frame.description));
  if (!is_i_frame && (!is_next || place == io::FrameChain::Place::Gap)) {
    chain_.breakOff();
    skip();
    return false;
  }
  has_i_frame_ = true;
  chain_.follow(frame.description, frame.bytes, frame.size);
  requests_in_a_row_ = frames_of_another_ = late_in_a_row_ = 0;
  return true;
}

void
FollowedStream::drop()
{
  chain_.breakOff();
  ++statistics.frames_dropped;
}

bool
FollowedStream::shouldRequest(Clock::time_point now, Clock::duration interval)
{
  if (now < next_request_)
    return false;
  constexpr unsigned int most_doublings = 4;
  next_request_ = now + interval * (1 << std::min(requests_in_a_row_, most_doublings));
  ++requests_in_a_row_;
  ++statistics.i_frame_requests;
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::link
