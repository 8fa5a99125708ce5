// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Fuzz target: frames of an encoder that were changed, mostly with valid checksums.
 * Decoding never crashes or throws; a frame that is Ok is consistent, within its grid
 * and within the limits; one that is not is empty and comes with a reason; and the next
 * valid I-frame and the P-frame after it decode to exactly their voxels. A decoder of
 * changes agrees with one of whole frames.
 *
 * The input is a stream. The mutator takes it apart into frames, changes fields of
 * headers, depth models, payloads, symbols of the published layout and the order of the
 * frames, and computes the chain of checksums anew.
 */
#include "changes_decoding.h"
#include "checked_decoding.h"
#include "frame_changes.h"
#include "frame_row.h"
#include "small_streams.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::fuzz;
using namespace pcl_ext::io;

/** \brief An I-frame and a P-frame of another sender, for each effort and of the
 * published layout. */
const std::array<SentStream, 4>&
freshStreams()
{
  static const auto streams = [] {
    constexpr StreamKind kinds[] = {
        {StreamFormat::Version1, Effort::Fast, false},
        {StreamFormat::Version1, Effort::Balanced, false},
        {StreamFormat::Version1, Effort::Small, false},
        {StreamFormat::Published, Effort::Balanced, false},
    };
    auto made = std::make_unique<std::array<SentStream, 4>>();
    for (std::size_t i = 0; i < made->size(); ++i)
      sendAll(kinds[i], sensorFrames(kinds[i], 77, 2, 0.0625), 100, 1, (*made)[i]);
    return made;
  }();
  return *streams;
}

/** \brief What was decoded last; a new decoder stands before frame 1. */
struct LastFrame {
  bool is_published = false;
  std::uint32_t number = 0;
  std::uint8_t flags = 0; // version 1
};

void
requireFreshFrames(FrameDecoder& decoder, const LastFrame& last)
{
  const SentStream& stream =
      freshStreams()[last.is_published ? 3 : std::size_t{last.flags} >> 4 & 3];
  std::uint32_t checksum = 0;
  for (std::uint32_t i = 0; i < stream.frames.size(); ++i) {
    const SentFrame& sent = stream.frames[i];
    Bytes bytes = sent.bytes;
    // Behind all that was decoded.
    const std::uint32_t number = last.number + 1 + i;
    if (last.is_published)
      for (std::size_t byte = 0; byte < 4; ++byte)
        bytes[published::magic_size + byte] =
            static_cast<std::uint8_t>(number >> 8 * byte);
    else
      checksum = renumber(number, sent.is_i_frame ? 0 : checksum, bytes);
    VoxelFrame frame;
    require(decoder.decode(bytes.data(), bytes.size(), frame).ok());
    require(isSame(sent, frame, decoder.stamp()));
  }
}

void
changeRow(FrameRow& row, Random& random)
{
  std::vector<RowFrame>& frames = row.frames;
  const std::size_t place = random.below(frames.size());
  const auto at = [&frames](std::size_t index) {
    return frames.begin() + static_cast<std::ptrdiff_t>(index);
  };
  switch (random.below(16)) {
  case 0: // lost
    frames.erase(at(place));
    return;
  case 1: { // repeated, early or late
    const RowFrame copy = frames[place];
    frames.insert(at(random.below(frames.size() + 1)), copy);
    return;
  }
  case 2: // swapped
    std::swap(frames[place], frames[random.below(frames.size())]);
    return;
  case 3: { // of another stream
    const SentStream& stream = freshStreams()[random.below(freshStreams().size())];
    const Bytes& bytes = stream.frames[random.below(stream.frames.size())].bytes;
    frames.insert(at(place), row.newFrame(bytes));
    return;
  }
  case 4:
    frames.insert(at(place), row.newFrame(forgedFrame(random)));
    return;
  case 5: // what depended on it depends on the frame before it
    if (place > 0)
      for (std::size_t i = place + 1; i < frames.size(); ++i)
        if (frames[i].reference == frames[place].id)
          frames[i].reference = frames[place - 1].id;
    changeFrame(frames[place], random);
    return;
  case 6: // two in one
    if (place + 1 < frames.size()) {
      const Bytes& next = frames[place + 1].bytes;
      Bytes& bytes = frames[place].bytes;
      const std::size_t kept = random.below(bytes.size() + 1);
      bytes.resize(kept);
      bytes.insert(bytes.end(),
                   next.begin() +
                       static_cast<std::ptrdiff_t>(random.below(next.size() + 1)),
                   next.end());
    }
    return;
  default:
    changeFrame(frames[place], random);
  }
}

} // namespace

extern "C" std::size_t
LLVMFuzzerCustomMutator(std::uint8_t* data,
                        std::size_t size,
                        std::size_t max_size,
                        unsigned int seed)
{
  Random random(seed);
  if (random.oneOf(32))
    return LLVMFuzzerMutate(data, size, max_size);
  FrameRow row(data, size);
  if (row.frames.empty())
    row.frames.push_back(row.newFrame(forgedFrame(random)));
  for (std::size_t changes = 1 + random.below(3); changes > 0; --changes)
    if (!row.frames.empty())
      changeRow(row, random);
  if (!random.oneOf(16))
    row.putRight(!random.oneOf(4));
  return row.write(data, max_size);
}

extern "C" std::size_t
LLVMFuzzerCustomCrossOver(const std::uint8_t* data1,
                          std::size_t size1,
                          const std::uint8_t* data2,
                          std::size_t size2,
                          std::uint8_t* out,
                          std::size_t max_size,
                          unsigned int seed)
{
  Random random(seed);
  FrameRow row(data1, size1);
  const FrameRow other(data2, size2);
  const std::size_t kept = random.below(row.frames.size() + 1);
  const std::size_t begin = random.below(other.frames.size() + 1);
  std::vector<RowFrame> tail(row.frames.begin() + static_cast<std::ptrdiff_t>(kept),
                             row.frames.end());
  row.frames.resize(kept);
  for (std::size_t i = begin; i < other.frames.size(); ++i) {
    // Either in front of what was there, frame by frame, or instead of it.
    row.frames.push_back(row.newFrame(other.frames[i].bytes));
    if (random.oneOf(2) && !tail.empty()) {
      row.frames.push_back(tail.front());
      tail.erase(tail.begin());
    }
  }
  if (!random.oneOf(8))
    row.putRight(random.oneOf(2));
  return row.write(out, max_size);
}

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FrameDecoder decoder(smallLimits());
  LastFrame last;
  decodeAll(data, size, decoder, [&](std::size_t end) {
    const std::uint8_t* const begin = data + end - decoder.statistics().bytes;
    last.is_published = begin[0] == '<';
    last.number = decoder.statistics().frame_number;
    if (!last.is_published)
      last.flags = begin[test::flags_offset];
  });
  requireFreshFrames(decoder, last);
  requireSameChanges(data, size);
  return 0;
}
