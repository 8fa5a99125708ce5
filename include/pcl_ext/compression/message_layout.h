// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/export.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief A field, and where messages have it. */
struct PlacedField : FieldDescription {
  std::uint32_t offset = 0; ///< within a point, bytes

  bool
  operator==(const PlacedField& other) const
  {
    return FieldDescription::operator==(other) && offset == other.offset;
  }
};

/** \brief Where messages have the fields of their points, for programs that read these
 * as structures. */
struct MessageLayout {
  std::vector<PlacedField> fields; ///< coordinates, too; without steps
  std::uint32_t point_step = 0;    ///< bytes
  std::uint32_t row_padding = 0;   ///< bytes behind each row of an organised cloud

  bool
  operator==(const MessageLayout& other) const
  {
    return fields == other.fields && point_step == other.point_step &&
           row_padding == other.row_padding;
  }
};

/** \brief Most bytes of a point and of the padding of a row, and most bytes that a layout
 * takes in a frame. */
constexpr std::uint32_t most_point_step = 1u << 12;
constexpr std::uint32_t most_row_padding = 1u << 16;
constexpr std::size_t most_layout_bytes = 1u << 10;

/** \brief Bytes that a layout takes in a frame at most. */
PCL_EXT_CODEC_EXPORT std::size_t
bytesOf(const MessageLayout& layout);

/** \brief Whether a layout is within these, and its fields are within a point. */
PCL_EXT_CODEC_EXPORT bool
isLayout(const MessageLayout& layout);

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
