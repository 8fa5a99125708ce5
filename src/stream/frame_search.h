// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/reread_allowance.h"

#include <cstddef>
#include <cstdint>
#include <streambuf>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The format of a frame, by its magic bytes. */
enum class FoundFormat { None, Version1, Published };

/** \brief Number of magic bytes of a format. */
std::size_t
magicSize(FoundFormat format);

/** \brief Finds the frames of a stream in its bytes: one in each call of a decoder, which
 * then moves the buffer to where its next call has to search. */
class FrameSearch {
public:
  /** \param[in] max_bytes most bytes that a search reads
   * \param[in] keeps_incomplete whether the next call begins with an incomplete frame at
   * the end of the input again
   */
  FrameSearch(std::size_t max_bytes, bool keeps_incomplete);

  /** \brief Begins a call. */
  void
  begin(std::streambuf& buffer);

  /** \brief Reads up to and including the next magic bytes of either format.
   * \param[out] status why there are none, if there are none
   */
  FoundFormat
  find(std::streambuf& buffer, CompressionStatus& status);

  /** \brief Bytes of this call before the frame. */
  std::size_t
  frameOffset() const
  {
    return frame_offset_;
  }

  /** \brief Ends a call. Moves the buffer, if it can seek, to where the next call has to
   * search: after the frame, to its second byte if its size may be forged, or to its
   * first if it is to be kept.
   * \param[in] status of the frame
   * \param[in,out] buffer after the bytes read
   * \param[in] skipped bytes of the frame that were not read
   */
  void
  end(const CompressionStatus& status, std::streambuf& buffer, std::size_t skipped);

private:
  std::size_t max_bytes_;
  bool keeps_incomplete_;
  std::uint64_t unfinished_search_ = 0; // last bytes of a search ended by the limit
  RereadAllowance rereads_;
  // Of the current call.
  std::streambuf::off_type begin_ = -1; // of a buffer that can seek
  std::size_t frame_offset_ = 0;
};

/** \brief The format of a frame that begins with some bytes, or may do so if more
 * arrive.
 * \param[in] bytes the first byte
 * \param[in] count number of bytes; of none Version1 may be the beginning
 */
FoundFormat
possibleFormat(const std::uint8_t* bytes, std::size_t count);

} // namespace pcl_ext::PCL_EXT_ABI::io
