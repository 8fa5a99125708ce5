// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/export.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The checksum of a frame, which distinguishes it from others of its number: that
 * of its header, or of all bytes in the published layout, which has none.
 * \param[in] frame description of the bytes, Ok
 * \param[in] bytes exactly one frame
 * \param[in] size number of bytes
 */
PCL_EXT_CODEC_EXPORT std::uint32_t
checksumOf(const FrameDescription& frame, const std::uint8_t* bytes, std::size_t size);

/** \brief Tells which frames of a stream can be decoded after those before them, by
 * numbers and chained checksums. Nothing is decoded: a payload that no encoder writes may
 * have the right checksum, and the published layout has none. */
class PCL_EXT_CODEC_EXPORT FrameChain {
public:
  /** \brief What a frame is after those before it. */
  enum class Place {
    Next,   ///< it can be decoded
    Gap,    ///< a P-frame whose reference is not the last frame
    Damaged ///< its checksum is wrong
  };

  /** \brief Looks at a frame.
   * \param[in] frame description of the bytes, Ok
   * \param[in] bytes exactly one frame
   * \param[in] size number of bytes
   */
  Place
  placeOf(const FrameDescription& frame,
          const std::uint8_t* bytes,
          std::size_t size) const;

  /** \brief Makes a frame the last one; parameters as above. */
  void
  follow(const FrameDescription& frame, const std::uint8_t* bytes, std::size_t size);

  /** \brief The last frame is not known: only an I-frame is next. */
  void
  breakOff()
  {
    last_.reset();
  }

  /** \brief Makes a frame the last one if it is the next one, else breaks off. */
  Place
  take(const FrameDescription& frame, const std::uint8_t* bytes, std::size_t size);

  /** \brief Whether a P-frame may be next. */
  bool
  isWhole() const
  {
    return last_.has_value();
  }

private:
  struct Last {
    StreamFormat format;
    std::uint32_t number;
    std::uint32_t checksum;
  };

  std::optional<Last> last_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
