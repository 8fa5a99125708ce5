// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A stream taken apart into frames, for a mutator that changes them and joins
 * them again with valid checksums.
 */
#pragma once

#include "bytes/byte_source.h"
#include "bytes/checksum.h"
#include "codec/published/frame.h"
#include "support/forged_frames.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ext::fuzz {

using io::test::Bytes;

/** \brief A frame, or bytes between frames. */
struct RowFrame {
  static constexpr std::size_t no_id = ~std::size_t{0};

  Bytes bytes;
  std::size_t id = no_id;        ///< of the frame in its row; copies share it
  std::size_t reference = no_id; ///< id of the frame that it depends on

  /** \brief True if there are flags, a number and a place for a checksum. */
  bool
  isVersion1() const
  {
    return bytes.size() >= io::test::flags_offset + 5 &&
           std::memcmp(bytes.data(), io::version1_magic, io::version1_magic_size) == 0;
  }

  bool
  isPublished() const
  {
    return bytes.size() >= io::published::magic_size &&
           std::memcmp(bytes.data(), io::published::magic, io::published::magic_size) ==
               0;
  }

  // Of version 1:

  bool
  isIFrame() const
  {
    return (bytes[io::test::flags_offset] & 1) != 0;
  }

  std::uint32_t
  checksum() const
  {
    return numberAt(io::version1_magic_size + 1);
  }

  std::uint32_t
  frameNumber() const
  {
    return numberAt(io::test::flags_offset + 1);
  }

  void
  setFrameNumber(std::uint32_t number)
  {
    for (std::size_t i = 0; i < 4; ++i)
      bytes[io::test::flags_offset + 1 + i] =
          static_cast<std::uint8_t>(number >> 8 * i);
  }

  void
  setChecksum(std::uint32_t reference_checksum)
  {
    bytes = io::test::withChecksum(std::move(bytes), reference_checksum);
  }

  bool
  hasChecksumFor(std::uint32_t reference_checksum) const
  {
    return checksum() == io::chainedChecksum(reference_checksum,
                                             bytes.data() + io::test::flags_offset,
                                             bytes.size() - io::test::flags_offset);
  }

  /** \brief Header and payload; nothing if the header is none. */
  std::optional<io::test::Parts>
  parts() const
  {
    io::MemoryBuffer buffer(bytes.data() + io::version1_magic_size,
                            bytes.size() - io::version1_magic_size);
    io::ByteSource source(buffer, bytes.size());
    io::test::Parts parts;
    Bytes header_bytes;
    if (!io::readVersion1Header(
             source, io::DecoderLimits(), parts.header, parts.checksum, header_bytes)
             .ok())
      return std::nullopt;
    parts.payload.assign(
        bytes.begin() +
            static_cast<std::ptrdiff_t>(io::test::flags_offset + header_bytes.size()),
        bytes.end());
    return parts;
  }

private:
  std::uint32_t
  numberAt(std::size_t offset) const
  {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i)
      number |= static_cast<std::uint32_t>(bytes[offset + i]) << 8 * i;
    return number;
  }
};

/** \brief The frames of a stream in their order. */
class FrameRow {
public:
  std::vector<RowFrame> frames;

  /** \brief Cuts a stream where frames begin, and finds out which frame each P-frame
   * depends on, so that frames may be lost, repeated and swapped and still depend on
   * the same. */
  FrameRow(const std::uint8_t* data, std::size_t size)
  {
    for (std::size_t begin = 0; begin < size;) {
      const std::size_t end = std::min(endOfFrame(data, begin, size), size);
      frames.emplace_back().bytes.assign(data + begin, data + end);
      begin = end;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
      RowFrame& frame = frames[i];
      frame.id = next_id_++;
      if (!frame.isVersion1())
        continue;
      constexpr std::size_t most = 8;
      for (std::size_t back = 1; back <= std::min(i, most); ++back)
        if (const RowFrame& candidate = frames[i - back];
            candidate.isVersion1() && frame.hasChecksumFor(candidate.checksum())) {
          frame.reference = candidate.id;
          break;
        }
    }
  }

  /** \brief A frame that is new in the row. */
  RowFrame
  newFrame(Bytes bytes)
  {
    RowFrame frame;
    frame.bytes = std::move(bytes);
    frame.id = next_id_++;
    return frame;
  }

  /** \brief Makes all checksums right.
   * \param[in] is_renumbering every P-frame also gets the number after its reference
   */
  void
  putRight(bool is_renumbering)
  {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      RowFrame& frame = frames[i];
      if (!frame.isVersion1())
        continue;
      std::uint32_t checksum = 0;
      if (!frame.isIFrame()) {
        const RowFrame* const reference = referenceOf(i);
        checksum = reference != nullptr ? reference->checksum() : 0;
        if (is_renumbering && reference != nullptr)
          frame.setFrameNumber(reference->frameNumber() + 1);
      }
      frame.setChecksum(checksum);
    }
  }

  /** \brief The stream, of whole frames as far as they have room.
   * \return bytes written
   */
  std::size_t
  write(std::uint8_t* data, std::size_t max_size) const
  {
    std::size_t size = 0;
    for (const RowFrame& frame : frames) {
      if (frame.bytes.empty() || frame.bytes.size() > max_size - size)
        continue;
      std::memcpy(data + size, frame.bytes.data(), frame.bytes.size());
      size += frame.bytes.size();
    }
    return size;
  }

private:
  /** \brief The frame of version 1 that one depends on; else the one before it. */
  const RowFrame*
  referenceOf(std::size_t index) const
  {
    const RowFrame* nearest = nullptr;
    for (std::size_t i = index; i-- > 0;) {
      if (!frames[i].isVersion1())
        continue;
      if (nearest == nullptr)
        nearest = &frames[i];
      if (frames[i].id == frames[index].reference ||
          frames[index].reference == RowFrame::no_id)
        return &frames[i];
    }
    return nearest;
  }

  static std::size_t
  endOfFrame(const std::uint8_t* data, std::size_t begin, std::size_t size)
  {
    RowFrame frame;
    frame.bytes.assign(data + begin, data + size);
    if (frame.isVersion1())
      if (const auto parts = frame.parts();
          parts && parts->payload.size() >= parts->header.payload_size)
        return size - parts->payload.size() +
               static_cast<std::size_t>(parts->header.payload_size);
    const auto find = [&](const char* magic, std::size_t magic_size) {
      return static_cast<std::size_t>(
          std::search(data + begin + 1, data + size, magic, magic + magic_size) - data);
    };
    return std::min(find(io::version1_magic, io::version1_magic_size),
                    find(io::published::magic, io::published::magic_size));
  }

  std::size_t next_id_ = 0;
};

} // namespace pcl_ext::fuzz
